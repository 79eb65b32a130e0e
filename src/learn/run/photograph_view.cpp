// SPDX-License-Identifier: MIT
#include "learn/run/photograph_view.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/fail.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"
#include "learn/run/hash.h"
#include "raster/scene/image_metrics.h"

namespace qs::train {
namespace {

constexpr int kMostWidth = 1600;

// A photograph at the resolution of training.
Image reduced(const Image& photograph, std::optional<int> scale, ThreadPool& pool) {
  if (scale) return divided(photograph, *scale, pool);
  const int width = photograph.width, height = photograph.height;
  if (width <= kMostWidth) return photograph;
  const double factor = static_cast<double>(kMostWidth) / width;
  return area_average(photograph, kMostWidth,
                      std::max(1, static_cast<int>(std::lround(height * factor))), pool);
}

// In its full size, undistorted.
Image read_checked(const PhotographSource& source, glm::vec3 background, ThreadPool& pool) {
  Image photograph = read_photograph(source.file, background, 1, pool, source.taken);
  require_same_shape(photograph, source.file, source.taken.camera);
  const std::vector<float>& values = photograph.values;
  if (!std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); }))
    fail("{}: holds values that are not finite numbers", source.file.string());
  return photograph;
}

// 1 where the mask is black.
Image masked_out(const Image& mask) {
  Image out(mask.width, mask.height, 1);
  const int colors = mask.channels < 3 ? 1 : 3;  // without alpha
  const float* pixel = mask.values.data();
  for (float& is_out : out.values) {
    is_out = std::all_of(pixel, pixel + colors, [](float v) { return v == 0; }) ? 1.0f : 0.0f;
    pixel += mask.channels;
  }
  return out;
}

std::vector<std::uint8_t> read_mask(const PhotographSource& source, const Image& photograph,
                                    ThreadPool& pool) {
  const Image mask = read_image(source.mask);
  if (mask.width != photograph.width || mask.height != photograph.height) {
    fail("{}: a mask of {} x {} pixels, but its photograph {} has {} x {}", source.mask.string(),
         mask.width, mask.height, source.file.string(), photograph.width, photograph.height);
  }
  // The sums of zeros are exact, so a pixel counts only if no part of it is masked out.
  const Image out =
      reduced(undistorted(masked_out(mask), source.taken, pool), source.resolution_scale, pool);
  std::vector<std::uint8_t> counts(out.values.size());
  std::transform(out.values.begin(), out.values.end(), counts.begin(),
                 [](float value) { return static_cast<std::uint8_t>(value > 0 ? 0 : 1); });
  const auto masked = std::count(counts.begin(), counts.end(), std::uint8_t{0});
  if (masked == 0) return {};
  if (static_cast<std::size_t>(masked) == counts.size())
    fail("{}: masks out every pixel of {}", source.mask.string(), source.file.string());
  return counts;
}

}  // namespace

Image PhotographView::image() const {
  Image image(camera.width, camera.height, 3);
  std::transform(rgb.begin(), rgb.end(), image.values.begin(),
                 [](std::uint8_t value) { return static_cast<float>(value) / 255; });
  return image;
}

void PhotographView::release_pixels() {
  released_hash = content_hash();
  released_bytes = bytes();
  for (auto* pixels : {&rgb, &alpha, &mask}) *pixels = {};
}

std::uint64_t PhotographView::content_hash() const {
  if (!has_pixels()) return released_hash;
  std::uint64_t hash = hash_of(std::as_bytes(std::span(rgb)));
  hash = hash_of(std::as_bytes(std::span(alpha)), hash);
  return hash_of(std::as_bytes(std::span(mask)), hash);
}

std::uint64_t PhotographView::bytes() const {
  return has_pixels() ? rgb.size() + alpha.size() + mask.size() : released_bytes;
}

PhotographView read_view(const PhotographSource& source, ThreadPool& pool) {
  const glm::vec3 background = source.keep_alpha ? glm::vec3(0) : source.background;
  const Image photograph = read_checked(source, background, pool);
  const Image image = reduced(photograph, source.resolution_scale, pool);
  const LensCamera camera = source.taken.scaled(image.width, image.height);
  PhotographView view{camera.camera, camera.lens, source, {}, {}, {}};
  view.rgb.resize(image.values.size());
  std::transform(image.values.begin(), image.values.end(), view.rgb.begin(), to_8bit);
  if (!source.mask.empty()) view.mask = read_mask(source, photograph, pool);
  if (!source.keep_alpha) return view;
  // Over white, a pixel is brighter than over black by 1 - alpha.
  const Image white =
      reduced(read_checked(source, glm::vec3(1), pool), source.resolution_scale, pool);
  for (std::size_t i = 0; i < image.values.size(); i += 3)
    view.alpha.push_back(to_8bit(1 - (white.values[i] - image.values[i])));
  if (std::all_of(view.alpha.begin(), view.alpha.end(), [](auto alpha) { return alpha == 255; }))
    view.alpha.clear();
  return view;
}

}  // namespace qs::train
