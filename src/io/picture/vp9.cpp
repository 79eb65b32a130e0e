// SPDX-License-Identifier: MIT
// Compiled alone: it has a macro of its own.
#include "io/picture/vp9.h"

#ifdef QUADSPLAT_VIDEO
#include <algorithm>
#include <cstdlib>

#include <vpx/vp8cx.h>
#include <vpx/vpx_encoder.h>
#endif

#include "base/fail.h"
#include "base/not_copied.h"

namespace qs {

#ifndef QUADSPLAT_VIDEO

struct Vp9Encoder::Codec {};

bool has_vp9() { return false; }
Vp9Encoder::Vp9Encoder(int, int, int) {
  fail(ErrorKind::device, "this program was built without libvpx, so it has no VP9 encoder");
}
Vp9Encoder::~Vp9Encoder() = default;
int Vp9Encoder::width() const { return 0; }
int Vp9Encoder::height() const { return 0; }
int Vp9Encoder::threads() const { return 0; }
Vp9Picture Vp9Encoder::encode(const I420&, double, int, bool) { return {}; }

#else

namespace {

constexpr int kTicks = 10000;  ///< ticks of the codec's clock in a second
constexpr double kShortest = 1.0 / 60, kLongest = 1.0 / 20;  ///< seconds between two pictures
constexpr int kFastest = 9;                                  ///< "cpu-used"
constexpr int kMostRate = 100'000;                           ///< kilobits per second
constexpr unsigned kMostOfOne = 300;  ///< percent of the mean picture that one may have
constexpr int kBlock = 64;            ///< pixels along a side of a superblock
constexpr int kLeastTile = 4;         ///< superblocks along a row of a tile
constexpr int kMostTileBits = 2;      ///< 4 tile columns

void demand(vpx_codec_err_t error) {
  if (error != VPX_CODEC_OK) fail(ErrorKind::device, "libvpx: {}", vpx_codec_err_to_string(error));
}

// The binary logarithm of the number of tile columns. One thread has one column, because columns
// cost a few bytes. Several threads have as many as there may be: 2 threads share 4 columns more
// evenly than 2. At this speed libvpx has no threads for the rows of a column.
int tile_bits(int width, int threads) {
  const int blocks = (width + kBlock - 1) / kBlock;
  int bits = 0;
  while (threads > 1 && bits < kMostTileBits && (blocks >> (bits + 1)) >= kLeastTile) ++bits;
  return bits;
}

}  // namespace

struct Vp9Encoder::Codec : NotCopied {
  vpx_codec_ctx_t context{};
  vpx_codec_enc_cfg_t config{};
  vpx_codec_pts_t time = 0;
  bool is_open = false;

  ~Codec() {
    if (is_open) vpx_codec_destroy(&context);
  }

  void open(int width, int height, int threads) {
    const int bits = tile_bits(width, threads);
    vpx_codec_iface_t* const vp9 = vpx_codec_vp9_cx();
    demand(vpx_codec_enc_config_default(vp9, &config, 0));
    config.g_w = static_cast<unsigned>(width);
    config.g_h = static_cast<unsigned>(height);
    config.g_timebase = {1, kTicks};
    config.g_threads = static_cast<unsigned>(std::clamp(threads, 1, 1 << bits));
    config.g_pass = VPX_RC_ONE_PASS;
    config.g_lag_in_frames = 0;  // every picture comes out immediately
    config.g_error_resilient = 0;
    config.kf_mode = VPX_KF_DISABLED;
    config.rc_end_usage = VPX_CBR;
    config.rc_dropframe_thresh = 0;
    config.rc_resize_allowed = 0;
    config.rc_min_quantizer = kLeastQuantizer;
    config.rc_max_quantizer = kMostQuantizer;
    config.rc_undershoot_pct = 50;
    config.rc_overshoot_pct = 50;
    config.rc_buf_initial_sz = 300;  // milliseconds
    config.rc_buf_optimal_sz = 300;
    config.rc_buf_sz = 600;
    config.rc_target_bitrate = 4000;
    demand(vpx_codec_enc_init(&context, vp9, &config, 0));
    is_open = true;
    demand(vpx_codec_control(&context, VP8E_SET_CPUUSED, kFastest));
    demand(vpx_codec_control(&context, VP9E_SET_COLOR_SPACE, VPX_CS_BT_601));
    demand(vpx_codec_control(&context, VP9E_SET_COLOR_RANGE, VPX_CR_STUDIO_RANGE));
    demand(vpx_codec_control(&context, VP8E_SET_MAX_INTRA_BITRATE_PCT, kMostOfOne));
    demand(vpx_codec_control(&context, VP9E_SET_MAX_INTER_BITRATE_PCT, kMostOfOne));
    demand(vpx_codec_control(&context, VP9E_SET_FRAME_PARALLEL_DECODING, 0));
    demand(vpx_codec_control(&context, VP9E_SET_TILE_COLUMNS, bits));
  }

  void set_rate(int bits_per_second) {
    const auto rate = static_cast<unsigned>(std::clamp(bits_per_second / 1000, 1, kMostRate));
    if (rate == config.rc_target_bitrate) return;
    config.rc_target_bitrate = rate;
    demand(vpx_codec_enc_config_set(&context, &config));
  }

  // The planes stay the picture's.
  static vpx_image_t image_of(const I420& picture) {
    vpx_image_t image;
    vpx_img_wrap(&image, VPX_IMG_FMT_I420, static_cast<unsigned>(picture.width()),
                 static_cast<unsigned>(picture.height()), 1,
                 const_cast<std::uint8_t*>(picture.y()));
    image.planes[VPX_PLANE_U] = const_cast<std::uint8_t*>(picture.u());
    image.planes[VPX_PLANE_V] = const_cast<std::uint8_t*>(picture.v());
    image.stride[VPX_PLANE_Y] = static_cast<int>(picture.stride());
    image.stride[VPX_PLANE_U] = image.stride[VPX_PLANE_V] =
        static_cast<int>(picture.chroma_stride());
    image.cs = VPX_CS_BT_601;
    image.range = VPX_CR_STUDIO_RANGE;
    return image;
  }
};

bool has_vp9() { return true; }

Vp9Encoder::Vp9Encoder(int width, int height, int threads) : codec_(std::make_unique<Codec>()) {
  codec_->open(width, height, threads);
}
Vp9Encoder::~Vp9Encoder() = default;

int Vp9Encoder::width() const { return static_cast<int>(codec_->config.g_w); }
int Vp9Encoder::height() const { return static_cast<int>(codec_->config.g_h); }
int Vp9Encoder::threads() const { return static_cast<int>(codec_->config.g_threads); }

Vp9Picture Vp9Encoder::encode(const I420& picture, double seconds, int bits_per_second, bool key) {
  Codec& codec = *codec_;
  codec.set_rate(bits_per_second);
  const auto ticks = static_cast<unsigned long>(kTicks * std::clamp(seconds, kShortest, kLongest));
  const vpx_image_t image = Codec::image_of(picture);
  demand(vpx_codec_encode(&codec.context, &image, codec.time, ticks, key ? VPX_EFLAG_FORCE_KF : 0,
                          VPX_DL_REALTIME));
  codec.time += static_cast<vpx_codec_pts_t>(ticks);
  Vp9Picture result;
  vpx_codec_iter_t next = nullptr;
  while (const vpx_codec_cx_pkt_t* const packet = vpx_codec_get_cx_data(&codec.context, &next)) {
    if (packet->kind != VPX_CODEC_CX_FRAME_PKT) continue;
    result.bytes.append(static_cast<const char*>(packet->data.frame.buf), packet->data.frame.sz);
    result.is_key = (packet->data.frame.flags & VPX_FRAME_IS_KEY) != 0;
  }
  demand(vpx_codec_control(&codec.context, VP8E_GET_LAST_QUANTIZER_64, &result.quantizer));
  if (result.bytes.empty()) fail(ErrorKind::device, "libvpx returned no picture");
  return result;
}

#endif

}  // namespace qs
