// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/rounding.h"
#include "io/bytes/json_text.h"
#include "io/bytes/zip.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/quantised.h"
#include "io/picture/webp_image.h"
#include "io/scene/sog/palette.h"
#include "io/scene/sog/sog.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostEntries = 65536, kEntriesPerRow = 64;
constexpr std::size_t kLongestSide = 16380;  // WebP: 16,383; sides are multiples of 4
constexpr float kLeastLogScale = -30;        // JSON has no infinity

using Texel = std::array<std::uint8_t, 4>;

std::uint8_t byte_of(double value) {
  return static_cast<std::uint8_t>(round_to_integer(value, 255));
}

std::size_t rounded_up(std::size_t value, std::size_t step) {
  return (value + step - 1) / step * step;
}

Array<float> three_each(const Array<glm::vec3>& vectors, std::size_t stride, float least) {
  Array<float> values;
  values.reserve(3 * vectors.size() / stride);
  for (std::size_t i = 0; i < vectors.size(); i += stride)
    for (int axis = 0; axis < 3; ++axis) values.push_back(std::max(vectors[i][axis], least));
  return values;
}

// Builds the pictures of a cloud whose Gaussians are in the file's order.
class SogEncoder {
 public:
  SogEncoder(const GaussianCloud& cloud, ThreadPool& pool) : cloud_(cloud), pool_(pool) {
    const auto side = std::sqrt(static_cast<double>(cloud.size()));
    width_ = rounded_up(static_cast<std::size_t>(std::ceil(side)), 4);
    height_ = rounded_up((cloud.size() + width_ - 1) / width_, 4);
    meta = {{"version", 2}, {"asset", {{"generator", "quadsplat"}}}, {"count", cloud.size()}};
    if (cloud.antialiased) meta["model"] = "antialiased";
  }

  ordered_json meta;
  std::vector<SogPicture> pictures;

  void add_positions() {
    glm::dvec3 low(INFINITY), high(-INFINITY);
    const auto stored = [this](std::size_t i) {
      const glm::dvec3 position(cloud_.positions[i]);
      return glm::sign(position) * glm::log(1.0 + glm::abs(position));
    };
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      low = glm::min(low, stored(i));
      high = glm::max(high, stored(i));
    }
    const glm::dvec3 extent = glm::max(high - low, glm::dvec3(1e-300));
    for (const int shift : {0, 8}) {
      add_picture(shift == 0 ? "means_l.webp" : "means_u.webp", [&](std::size_t i) {
        const glm::dvec3 steps = 65535.0 * (stored(i) - low) / extent;
        const auto part = [&](double step) {
          return static_cast<std::uint8_t>(round_to_integer(step, 65535) >> shift);
        };
        return Texel{part(steps.x), part(steps.y), part(steps.z), 255};
      });
    }
    meta["means"] = {{"mins", {low.x, low.y, low.z}},
                     {"maxs", {high.x, high.y, high.z}},
                     {"files", {"means_l.webp", "means_u.webp"}}};
  }

  void add_scales() {
    const Codebook codebook = make_codebook(three_each(cloud_.log_scales, 1, kLeastLogScale));
    add_picture("scales.webp", [&](std::size_t i) {
      const glm::vec3 scale = glm::max(cloud_.log_scales[i], glm::vec3(kLeastLogScale));
      return texel(codebook, &scale.x, 255);
    });
    meta["scales"] = {{"codebook", codebook.values}, {"files", {"scales.webp"}}};
  }

  // The three smaller components of w, x, y, z; alpha names the component that is left out.
  void add_rotations() {
    add_picture("quats.webp", [&](std::size_t i) {
      const glm::quat& q = cloud_.rotations[i];
      const SmallestThree three = drop_largest({q.w, q.x, q.y, q.z});
      const auto part = [&](std::size_t k) {
        return byte_of((three.others[k] * std::sqrt(0.5) + 0.5) * 255);
      };
      return Texel{part(0), part(1), part(2), static_cast<std::uint8_t>(252 + three.dropped)};
    });
    meta["quats"] = {{"files", {"quats.webp"}}};
  }

  void add_colors() {
    const Codebook codebook = make_codebook(three_each(cloud_.sh, sh_count(cloud_), -INFINITY));
    add_picture("sh0.webp", [&](std::size_t i) {
      return texel(codebook, &sh_of(cloud_, i)->x,
                   byte_of(opacity_of_logit(cloud_.opacity_logits[i]) * 255));
    });
    meta["sh0"] = {{"codebook", codebook.values}, {"files", {"sh0.webp"}}};
  }

  void add_sh(const Progress& progress) {
    if (cloud_.sh_degree == 0) return;
    const std::size_t rest = sh_count(cloud_) - 1;
    const VectorRows rows{&cloud_.sh[1].x, cloud_.size(), 3 * (rest + 1), 3 * rest};
    const Palette palette = make_palette(rows, kMostEntries, pool_, progress);
    const Codebook codebook = make_codebook(palette.values);
    const std::size_t lines = (palette.size() + kEntriesPerRow - 1) / kEntriesPerRow;
    add_picture(
        "shN_centroids.webp",
        [&](std::size_t i) { return texel(codebook, &palette.values[3 * i], 255); },
        palette.size() * rest, kEntriesPerRow * rest, lines);
    add_picture("shN_labels.webp", [&](std::size_t i) {
      const std::uint32_t label = palette.label[i];
      return Texel{static_cast<std::uint8_t>(label), static_cast<std::uint8_t>(label >> 8), 0, 255};
    });
    meta["shN"] = {{"count", palette.size()},
                   {"bands", cloud_.sh_degree},
                   {"codebook", codebook.values},
                   {"files", {"shN_centroids.webp", "shN_labels.webp"}}};
  }

 private:
  static Texel texel(const Codebook& codebook, const float* values, std::uint8_t alpha) {
    return {codebook.nearest(values[0]), codebook.nearest(values[1]), codebook.nearest(values[2]),
            alpha};
  }

  using Colour = std::function<Texel(std::size_t i)>;

  void add_picture(const char* name, const Colour& color) {
    add_picture(name, color, cloud_.size(), width_, height_);
  }
  void add_picture(const char* name, const Colour& color, std::size_t count, std::size_t width,
                   std::size_t height) {
    constexpr std::size_t kGrain = 4096;
    SogPicture picture{name, width, height, std::vector<std::uint8_t>(4 * width * height)};
    pool_.for_each(count, kGrain,
                   [&](std::size_t i) { std::ranges::copy(color(i), &picture.values[4 * i]); });
    pictures.push_back(std::move(picture));
  }

  const GaussianCloud& cloud_;
  ThreadPool& pool_;
  std::size_t width_ = 0, height_ = 0;
};

}  // namespace

SogPictures sog_pictures(const GaussianCloud& cloud, ThreadPool& pool, const Progress& progress) {
  SogEncoder encoder(cloud, pool);
  encoder.add_positions();
  encoder.add_scales();
  encoder.add_rotations();
  encoder.add_colors();
  progress.update(1.0f / 3);
  encoder.add_sh(part_of(progress, 1.0f / 3, 1));
  progress.update(1);
  return {json_line(encoder.meta), std::move(encoder.pictures)};
}

std::vector<std::vector<ZipEntry>> encode_pictures(std::span<const SogPictures> scenes,
                                                   ThreadPool& pool, const std::stop_token& stop) {
  std::vector<std::vector<ZipEntry>> files(scenes.size());
  std::vector<std::pair<const SogPicture*, ZipEntry*>> work;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    files[i].resize(1 + scenes[i].pictures.size());
    files[i].front() = {"meta.json", scenes[i].meta};
    for (std::size_t k = 0; k < scenes[i].pictures.size(); ++k)
      work.emplace_back(&scenes[i].pictures[k], &files[i][1 + k]);
  }
  // The largest first, so that no thread still encodes a large one when the others are done.
  std::ranges::stable_sort(work, std::greater(),
                           [](const auto& pair) { return pair.first->values.size(); });
  pool.for_each(work.size(), 1, [&](std::size_t i) {
    const auto& [name, width, height, values] = *work[i].first;
    *work[i].second = {
        name, encode_data_webp({values, static_cast<int>(width), static_cast<int>(height)}, stop)};
  });
  return files;
}

void write_sog(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
               const Progress& progress) {
  if (cloud.size() > kLongestSide * kLongestSide)
    fail("{}: {} Gaussians are more than the {} that SOG's pictures hold", path.string(),
         cloud.size(), kLongestSide * kLongestSide);
  progress.update(0);
  const SogPictures pictures =
      sog_pictures(select(cloud, morton_order(cloud)), pool, part_of(progress, 0, 0.6f));
  write_zip(path, encode_pictures({&pictures, 1}, pool, progress.stop).front(), ZipForm::stored);
  progress.update(1);
}

}  // namespace qs
