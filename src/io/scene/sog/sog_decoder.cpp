// SPDX-License-Identifier: MIT
#include "io/scene/sog/sog_decoder.h"

#include <array>
#include <cmath>
#include <vector>

#include "io/bytes/byte_cursor.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/quantised.h"
#include "io/picture/webp_image.h"

namespace qs {
namespace {

// Real scenes need 5 bytes or more per Gaussian, but pictures of one colour could claim millions.
constexpr std::uint64_t kMaxGaussiansPerByte = 8;
// A picture is a rectangle, so it has a few more texels than there are Gaussians.
constexpr std::uint64_t kSpareTexels = 65536;
constexpr std::uint64_t kCentroidsPerRow = 64, kMaxCentroidTexels = 1024 * 960;

// Upper bound: lossless WebP of noise is little larger than the pixels.
constexpr std::uint64_t packed_bytes(std::uint64_t texels) { return 5 * texels + 65536; }

struct Picture {
  std::string name;
  std::uint64_t max_texels;
  Array<std::uint8_t>* pixels;
  Array<std::byte> packed{};
};

double from_log(double value) { return std::copysign(std::expm1(std::abs(value)), value); }

}  // namespace

SogDecoder::SogDecoder(std::string_view meta, const std::string& source, FileSource& files,
                       const std::string& folder, ThreadPool& pool)
    : meta_(parse_sog_meta(meta, source)) {
  // List the pictures of the file.
  const std::uint64_t max_texels = 2 * meta_.count + kSpareTexels;
  std::vector<Picture> pictures = {{meta_.positions_low, max_texels, &positions_low_},
                                   {meta_.positions_high, max_texels, &positions_high_},
                                   {meta_.scales, max_texels, &scales_},
                                   {meta_.rotations, max_texels, &rotations_},
                                   {meta_.colors, max_texels, &colors_}};
  if (meta_.sh_bands != 0) {
    pictures.push_back({meta_.labels, max_texels, &labels_});
    pictures.push_back({meta_.centroids, kMaxCentroidTexels, &centroids_});
  }
  // Read the pictures and check their sizes before anything is decoded.
  for (Picture& picture : pictures) {
    picture.packed = files.read(folder + picture.name, packed_bytes(picture.max_texels));
    picture_bytes_ += picture.packed.size();
    const std::string where = source + ": " + picture.name;
    const WebpSize size = webp_size(picture.packed, where);
    if (size.pixels() > picture.max_texels) {
      fail("{}: {} x {} pixels are more than its {} Gaussians need", where, size.width, size.height,
           meta_.count);
    }
    if (picture.pixels == &centroids_) {
      const std::uint64_t rest = size.width / kCentroidsPerRow;
      if (meta_.sh_bands < 0) meta_.sh_bands = rest == 3 ? 1 : rest == 8 ? 2 : 3;
      const auto expected =
          static_cast<std::uint64_t>(sh_coefficient_count(meta_.sh_bands) - 1) * kCentroidsPerRow;
      if (size.width != expected) {
        fail("{}: {} pixels wide, {} bands need {}", where, size.width, meta_.sh_bands, expected);
      }
      centroid_columns_ = size.width;
      palette_ = size.height * kCentroidsPerRow;
      if (meta_.sh_palette > palette_) {
        fail("{}: {} x {} pixels are too few for {} rows of coefficients", where, size.width,
             size.height, meta_.sh_palette);
      }
      if (meta_.sh_palette > 0) palette_ = meta_.sh_palette;
    } else if (size.pixels() < meta_.count) {
      fail("{}: {} x {} pixels are too few for {} Gaussians", where, size.width, size.height,
           meta_.count);
    }
  }
  degree_ = meta_.sh_bands;
  if (!fits(meta_.count, 1, picture_bytes_ * kMaxGaussiansPerByte)) {
    fail("{}: {} Gaussians are announced, more than pictures of {} bytes can hold", source,
         meta_.count, picture_bytes_);
  }
  // Decode.
  pool.for_chunks(pictures.size(), 1, [&](std::size_t begin, std::size_t end, int) {
    for (std::size_t i = begin; i < end; ++i) {
      *pictures[i].pixels = decode_webp(pictures[i].packed, source + ": " + pictures[i].name);
    }
  });
}

// A row of the picture holds 64 centroids; each takes one texel per coefficient.
const std::uint8_t* SogDecoder::coefficients_of(std::uint64_t label) const {
  const std::uint64_t rest = centroid_columns_ / kCentroidsPerRow;
  return &centroids_[4 * (label / kCentroidsPerRow * centroid_columns_ +
                          label % kCentroidsPerRow * rest)];
}

void SogDecoder::fill(std::uint64_t from, GaussianCloud& cloud, std::size_t to) {
  const std::uint64_t texel = 4 * from;
  // Position and scale.
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t at = texel + static_cast<std::uint64_t>(axis);
    const double t = (positions_low_[at] + 256.0 * positions_high_[at]) / 65535;
    const double low = meta_.position_low[axis], high = meta_.position_high[axis];
    cloud.positions[to][axis] = static_cast<float>(from_log(low + (high - low) * t));
    cloud.log_scales[to][axis] = meta_.log_scale[static_cast<std::size_t>(axis)][scales_[at]];
  }

  // Rotation: three components, and in alpha the number of the largest one, which is left out.
  constexpr int kFirstTag = 252;
  const std::uint8_t* const q = &rotations_[texel];
  if (q[3] < kFirstTag) {
    cloud.rotations[to] = make_quat(1, 0, 0, 0);
    ++unrotated_;
  } else {
    const auto component = [q](int i) { return (q[i] / 127.5 - 1) * std::sqrt(0.5); };
    const auto wxyz = restore_largest({component(0), component(1), component(2)},
                                      static_cast<std::size_t>(q[3] - kFirstTag));
    cloud.rotations[to] = make_quat(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  }

  // Opacity and base colour.
  glm::vec3* const sh = sh_of(cloud, to);
  std::fill_n(sh, sh_count(cloud), glm::vec3(0));
  const std::uint8_t* const color = &colors_[texel];
  sh[0] = {meta_.dc[0][color[0]], meta_.dc[1][color[1]], meta_.dc[2][color[2]]};
  cloud.opacity_logits[to] = meta_.logit[color[3]];
  if (degree_ == 0) return;
  // View-dependent colour: a row of the palette.
  const std::uint64_t label = labels_[texel] + 256u * labels_[texel + 1];
  if (label >= palette_) {
    ++unlabelled_;
    return;
  }
  const std::uint8_t* const row = coefficients_of(label);
  const auto rest = static_cast<std::size_t>(sh_coefficient_count(degree_) - 1);
  for (std::size_t k = 0; k < rest; ++k) {
    sh[1 + k] = {meta_.sh[row[4 * k]], meta_.sh[row[4 * k + 1]], meta_.sh[row[4 * k + 2]]};
  }
}

}  // namespace qs
