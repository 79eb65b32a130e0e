// SPDX-License-Identifier: MIT
// Needs QUADSPLAT_VIDEO.
//
// VP9 there and back, with libvpx's decoder.
#include "io/picture/vp9.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <vpx/vp8dx.h>
#include <vpx/vpx_decoder.h>

namespace qs {
namespace {

class Vp9Decoder {
 public:
  Vp9Decoder() {
    EXPECT_EQ(vpx_codec_dec_init(&context_, vpx_codec_vp9_dx(), nullptr, 0), VPX_CODEC_OK);
  }
  ~Vp9Decoder() { vpx_codec_destroy(&context_); }
  Vp9Decoder(const Vp9Decoder&) = delete;
  Vp9Decoder& operator=(const Vp9Decoder&) = delete;

  // Null if it cannot be decoded. Valid until the next picture.
  const vpx_image_t* decode(const std::string& bytes) {
    if (vpx_codec_decode(&context_, reinterpret_cast<const std::uint8_t*>(bytes.data()),
                         static_cast<unsigned>(bytes.size()), nullptr, 0) != VPX_CODEC_OK)
      return nullptr;
    vpx_codec_iter_t next = nullptr;
    return vpx_codec_get_frame(&context_, &next);
  }

 private:
  vpx_codec_ctx_t context_{};
};

// Smooth waves that move to the right by two pixels a picture.
std::vector<std::uint8_t> waves(int width, int height, int picture) {
  std::vector<std::uint8_t> rgba;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 4; ++c) {
        const double phase = 0.07 * (x - 2 * picture) + 0.05 * y + c;
        rgba.push_back(static_cast<std::uint8_t>(128 + 100 * std::sin(phase)));
      }
    }
  }
  return rgba;
}

std::vector<std::uint8_t> noise_picture(int width, int height, std::uint32_t state) {
  std::vector<std::uint8_t> rgba(4 * static_cast<std::size_t>(width * height));
  for (std::uint8_t& value : rgba) {
    state = state * 1664525 + 1013904223;
    value = static_cast<std::uint8_t>(state >> 24);
  }
  return rgba;
}

I420 planes_of(const std::vector<std::uint8_t>& rgba, int width, int height) {
  I420 planes;
  planes.set({rgba, width, height});
  return planes;
}

double psnr(const I420& expected, const vpx_image_t& found) {
  double sum = 0;
  for (int y = 0; y < expected.height(); ++y) {
    for (int x = 0; x < expected.width(); ++x) {
      const double difference =
          expected
              .y()[static_cast<std::size_t>(y) * expected.stride() + static_cast<std::size_t>(x)] -
          found.planes[VPX_PLANE_Y][y * found.stride[VPX_PLANE_Y] + x];
      sum += difference * difference;
    }
  }
  return 10 *
         std::log10(255.0 * 255.0 * expected.width() * expected.height() / std::max(sum, 1e-9));
}

TEST(Vp9, moving_pictures_come_back_one_by_one) {
  for (const auto& [width, height] : {std::pair{320, 180}, {161, 91}, {16, 16}}) {
    Vp9Encoder encoder(width, height);
    Vp9Decoder decoder;
    for (int i = 0; i < 12; ++i) {
      const I420 planes = planes_of(waves(width, height, i), width, height);
      const Vp9Picture picture = encoder.encode(planes, 1.0 / 30, 4'000'000, false);
      EXPECT_EQ(picture.is_key, i == 0) << i;
      const vpx_image_t* const found = decoder.decode(picture.bytes);
      ASSERT_NE(found, nullptr) << "a picture comes out for each that goes in";
      ASSERT_EQ(static_cast<int>(found->d_w), width);
      ASSERT_EQ(static_cast<int>(found->d_h), height);
      EXPECT_EQ(found->range, VPX_CR_STUDIO_RANGE);
      EXPECT_EQ(found->cs, VPX_CS_BT_601);
      EXPECT_GT(psnr(planes, *found), 38) << width << " " << i;
    }
  }
}

TEST(Vp9, the_smallest_pictures_are_encoded) {
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 9}, {7, 2}}) {
    Vp9Encoder encoder(width, height);
    Vp9Decoder decoder;
    const I420 planes = planes_of(waves(width, height, 0), width, height);
    for (int i = 0; i < 3; ++i)
      EXPECT_NE(decoder.decode(encoder.encode(planes, 0.1, 1'000'000, false).bytes), nullptr);
  }
}

// A ramp that moves to the right, because waves take too long for large pictures.
std::vector<std::uint8_t> ramp(int width, int height, int picture) {
  std::vector<std::uint8_t> rgba(4 * static_cast<std::size_t>(width * height));
  for (std::size_t i = 0; i < rgba.size(); ++i) {
    const std::size_t pixel = i / 4;
    const auto x = pixel % static_cast<std::size_t>(width),
               y = pixel / static_cast<std::size_t>(width);
    rgba[i] = static_cast<std::uint8_t>((x + y + static_cast<std::size_t>(picture)) / 8);
  }
  return rgba;
}

struct Size {
  int width, height;
};

class Vp9Sizes : public testing::TestWithParam<Size> {};

TEST_P(Vp9Sizes, pictures_of_any_number_of_threads_are_decoded) {
  const auto [width, height] = GetParam();
  const bool is_large = width > 2048;
  for (const int threads : is_large ? std::vector{4} : std::vector{1, 2, 3, 4, 64}) {
    Vp9Encoder encoder(width, height, threads);
    EXPECT_LE(encoder.threads(), std::max(1, (width + 63) / 256)) << threads;
    EXPECT_LE(encoder.threads(), std::min(threads, 4));
    Vp9Decoder decoder;
    for (int i = 0; i < 4; ++i) {
      const I420 planes = planes_of(ramp(width, height, i), width, height);
      const Vp9Picture picture = encoder.encode(planes, 1.0 / 30, 8'000'000, i == 2);
      EXPECT_EQ(picture.is_key, i == 0 || i == 2) << threads << " " << i;
      EXPECT_GE(picture.quantizer, kLeastQuantizer);
      EXPECT_LE(picture.quantizer, kMostQuantizer);
      const vpx_image_t* const found = decoder.decode(picture.bytes);
      ASSERT_NE(found, nullptr) << threads << " " << i;
      ASSERT_EQ(static_cast<int>(found->d_w), width);
      ASSERT_EQ(static_cast<int>(found->d_h), height);
      EXPECT_GT(psnr(planes, *found), 35) << threads << " " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Vp9Sizes,
                         testing::Values(Size{1, 1}, Size{16, 16}, Size{255, 3}, Size{256, 64},
                                         Size{257, 40}, Size{448, 9}, Size{449, 9}, Size{511, 70},
                                         Size{512, 64}, Size{513, 33}, Size{960, 20}, Size{961, 20},
                                         Size{1024, 1}, Size{4096, 2160}));

TEST(Vp9, threads_have_a_tile_column_each) {
  EXPECT_EQ(Vp9Encoder(1280, 64, 1).threads(), 1);
  EXPECT_EQ(Vp9Encoder(1280, 64, 2).threads(), 2);
  EXPECT_EQ(Vp9Encoder(1280, 64, 3).threads(), 3);
  EXPECT_EQ(Vp9Encoder(1280, 64, 64).threads(), 4);
  EXPECT_EQ(Vp9Encoder(640, 64, 4).threads(), 2);
  EXPECT_EQ(Vp9Encoder(320, 64, 4).threads(), 1);
  EXPECT_EQ(Vp9Encoder(320, 64, 0).threads(), 1);
}

TEST(Vp9, threads_change_the_pictures_little) {
  constexpr int kWidth = 1024, kHeight = 128;
  std::size_t bytes[2] = {};
  double quality[2] = {};
  for (const int threads : {1, 4}) {
    Vp9Encoder encoder(kWidth, kHeight, threads);
    Vp9Decoder decoder;
    for (int i = 0; i < 10; ++i) {
      const I420 planes = planes_of(waves(kWidth, kHeight, i), kWidth, kHeight);
      const Vp9Picture picture = encoder.encode(planes, 1.0 / 30, 2'000'000, false);
      const vpx_image_t* const found = decoder.decode(picture.bytes);
      ASSERT_NE(found, nullptr);
      bytes[threads > 1] += picture.bytes.size();
      quality[threads > 1] += psnr(planes, *found) / 10;
    }
  }
  EXPECT_GT(quality[0], 47);
  EXPECT_NEAR(quality[1], quality[0], 0.25);
  EXPECT_NEAR(static_cast<double>(bytes[1]), static_cast<double>(bytes[0]),
              0.06 * static_cast<double>(bytes[0]));
}

TEST(Vp9, key_pictures_come_when_asked_for_and_decode_alone) {
  Vp9Encoder encoder(160, 96);
  std::vector<Vp9Picture> pictures;
  for (int i = 0; i < 6; ++i) {
    pictures.push_back(
        encoder.encode(planes_of(waves(160, 96, i), 160, 96), 1.0 / 30, 2'000'000, i == 4));
  }
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(pictures[static_cast<std::size_t>(i)].is_key, i == 0 || i == 4) << i;
  Vp9Decoder late;
  EXPECT_EQ(late.decode(pictures[3].bytes), nullptr) << "it refers to pictures before it";
  Vp9Decoder decoder;
  EXPECT_NE(decoder.decode(pictures[4].bytes), nullptr);
  EXPECT_NE(decoder.decode(pictures[5].bytes), nullptr);
}

TEST(Vp9, the_bit_rate_is_kept_and_the_quantiser_shows_where_it_cannot_be) {
  const auto run = [](int bits_per_second, auto picture_of) {
    Vp9Encoder encoder(320, 180);
    std::size_t bytes = 0;
    int quantizer = 0;
    for (int i = 0; i < 90; ++i) {
      const Vp9Picture picture =
          encoder.encode(planes_of(picture_of(i), 320, 180), 1.0 / 30, bits_per_second, false);
      bytes += i < 30 ? 0 : picture.bytes.size();
      quantizer = picture.quantizer;
      EXPECT_GE(quantizer, kLeastQuantizer);
      EXPECT_LE(quantizer, kMostQuantizer);
    }
    return std::pair(static_cast<double>(8 * bytes) / 2, quantizer);  // of two seconds
  };
  const auto noises = [](int i) { return noise_picture(320, 180, static_cast<std::uint32_t>(i)); };
  const auto [kept, medium] = run(12'000'000, noises);
  EXPECT_GT(kept, 6e6);
  EXPECT_LT(kept, 15e6);
  EXPECT_LT(medium, kMostQuantizer);
  EXPECT_EQ(run(100'000, noises).second, kMostQuantizer);
  EXPECT_LT(run(4'000'000, [](int i) { return waves(320, 180, i); }).second, 20);
}

TEST(Vp9, rates_and_times_beyond_sense_do_no_harm) {
  Vp9Encoder encoder(64, 48);
  Vp9Decoder decoder;
  const I420 planes = planes_of(waves(64, 48, 0), 64, 48);
  for (const double seconds : {0.0, -5.0, 1e9}) {
    for (const int bits : {0, -1, 1, 2'000'000'000})
      EXPECT_NE(decoder.decode(encoder.encode(planes, seconds, bits, false).bytes), nullptr);
  }
}

}  // namespace
}  // namespace qs
