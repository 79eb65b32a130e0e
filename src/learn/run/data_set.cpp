// SPDX-License-Identifier: MIT
#include "learn/run/data_set.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <system_error>
#include <utility>

#include <glm/geometric.hpp>
#include <unistd.h>

#include "base/fail.h"
#include "base/list_of.h"
#include "base/text.h"
#include "io/camera/cameras.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"
#include "learn/run/data_files.h"
#include "learn/run/hash.h"
#include "raster/kernel/random.h"
#include "raster/scene/image_metrics.h"
#include "raster/scene/place.h"

namespace qs::train {
namespace {

// Moves georeferenced cameras by the origin that this returns.
glm::dvec3 move_near_origin(std::vector<LensCamera>& cameras) {
  if (cameras.empty()) return glm::dvec3(0);
  const glm::dvec3 stored = cameras.front().camera.origin;  // of a model's cameras.json
  const glm::dvec3 origin = stored + origin_of(cameras.size(), [&](std::size_t i) {
                              return cameras[i].camera.position();
                            });
  for (LensCamera& camera : cameras) camera.camera = camera.camera.placed(origin);
  return origin;
}

// The points from data.origin on, each place once.
void read_points_of(DataSet& data) {
  if (data.points_file.empty()) return;
  std::vector<ScenePoint> points = read_points(data.points_file, data.warnings);
  for (ScenePoint& point : points) point.position -= data.origin;
  data.points = without_repetitions(points);
  data.repeated_points = points.size() - data.points.size();
}

// "points3D.bin: no point of it is seen by 3 of 9 training cameras: ...", or "".
std::string blind_sentence(const DataSet& data) {
  const std::vector<Camera> cameras = data.training_cameras();
  const auto blind = std::ranges::count_if(cameras, [&](const Camera& camera) {
    return !sees_any(camera, data.points.size(),
                     [&](std::size_t i) { return glm::dvec4(data.points[i].position, 0); });
  });
  if (data.points.empty() || blind == 0) return "";
  return fmt::format(
      "{}: no point of it is seen by {} of {} training cameras: they and the points are of "
      "different frames, or focal lengths or axes are wrong",
      data.points_file.string(), blind, cameras.size());
}

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

// In its full size, as the lens took it.
Image read_checked(const PhotographSource& source, glm::vec3 background) {
  Image photograph = read_as_taken(source.file, background, source.taken);
  const std::vector<float>& values = photograph.values;
  if (!std::ranges::all_of(values, [](float value) { return std::isfinite(value); }))
    fail("{}: holds values that are not finite numbers", source.file.string());
  return photograph;
}

// 1 where the mask is black or transparent.
Image masked_out(const Image& mask) {
  Image out(mask.width, mask.height, 1);
  const int colors = mask.channels < 3 ? 1 : 3;  // without alpha
  const bool has_alpha = mask.channels > colors;
  const float* pixel = mask.values.data();
  for (float& is_out : out.values) {
    const bool is_black = std::all_of(pixel, pixel + colors, [](float v) { return v == 0; });
    is_out = is_black || (has_alpha && pixel[colors] == 0) ? 1.0f : 0.0f;
    pixel += mask.channels;
  }
  return out;
}

std::vector<std::uint8_t> read_mask(const PhotographSource& source, const Image& photograph,
                                    ThreadPool& pool) {
  const Image mask = read_image(source.mask);
  if (mask.width != photograph.width || mask.height != photograph.height)
    fail("{}: a mask of {} x {} pixels, but its photograph {} has {} x {}", source.mask.string(),
         mask.width, mask.height, source.file.string(), photograph.width, photograph.height);
  // The sums of zeros are exact, so a pixel counts only if no part of it is masked out. Weights can
  // be negative.
  Image parts = undistorted(masked_out(mask), source.taken, pool);
  for (float& value : parts.values) value = std::abs(value);
  const Image out = reduced(parts, source.resolution_scale, pool);
  std::vector<std::uint8_t> counts = lens_mask(source.taken, out.width, out.height, pool);
  if (counts.empty()) counts.assign(out.values.size(), 1);
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (out.values[i] > 0) counts[i] = 0;
  if (std::ranges::count(counts, std::uint8_t{0}) == 0) return {};
  return counts;
}

}  // namespace

Image PhotographView::image() const {
  Image image(camera.width, camera.height, 3);
  std::ranges::transform(rgb, image.values.begin(),
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
  const Image photograph = read_checked(source, background);
  const auto as_view = [&](const Image& taken) {
    return reduced(undistorted(taken, source.taken, pool), source.resolution_scale, pool);
  };
  const Image image = as_view(photograph);
  const LensCamera camera = source.taken.scaled(image.width, image.height);
  PhotographView view{camera.camera, camera.lens, source, {}, {}, {}};
  view.rgb.resize(image.values.size());
  std::ranges::transform(image.values, view.rgb.begin(), to_8bit);
  view.mask = source.mask.empty() ? lens_mask(source.taken, image.width, image.height, pool)
                                  : read_mask(source, photograph, pool);
  if (!source.keep_alpha) return view;
  // Over white, a pixel is brighter than over black by 1 - alpha.
  const Image white = as_view(read_checked(source, glm::vec3(1)));
  for (std::size_t i = 0; i < image.values.size(); i += 3)
    view.alpha.push_back(to_8bit(1 - (white.values[i] - image.values[i])));
  if (std::ranges::all_of(view.alpha, [](auto alpha) { return alpha == 255; })) view.alpha.clear();
  return view;
}

std::uint64_t half_of_memory() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) / 2;
}

std::vector<LensCamera> DataSet::cameras() const {
  std::vector<LensCamera> all;
  for (const auto* views : {&training, &test})
    for (const PhotographView& view : *views)
      all.push_back({view.camera, view.lens, view.source.taken.photograph});
  sort_by_name(all);
  return all;
}

std::string DataSet::fingerprint() const {
  std::uint64_t hash = 0;
  for (const auto* views : {&training, &test}) {
    for (const PhotographView& view : *views) {
      const std::string camera = format_camera(view.camera);
      hash = mix_bits(hash_of(std::as_bytes(std::span(camera)), hash) ^ view.content_hash());
    }
  }
  return fmt::format("{} training and {} test views, {:016x}", training.size(), test.size(), hash);
}

void DataSet::release_pixels() {
  for (auto* views : {&training, &test})
    for (PhotographView& view : *views) view.release_pixels();
}

std::vector<Camera> DataSet::training_cameras() const {
  return list_of<Camera>(training, &PhotographView::camera);
}

double DataSet::extent() const {
  const std::vector<Camera> cameras = training_cameras();
  return extent_of(published_extent ? cameras : without_outliers(cameras));
}

DataSet read_data_set(const DataOptions& options, ThreadPool& pool, const Progress& progress) {
  DataFiles files = find_data_files(options.data, options.images, options.masks);
  std::vector<LensCamera>& cameras = files.set.cameras;
  DataSet data;
  data.origin = move_near_origin(cameras);
  data.folder = files.folder;
  data.photographs = files.photographs_folder;
  data.blender = files.first_test.has_value();
  data.photo_memory = options.photo_memory;
  data.warnings = files.warnings;
  data.points_file = files.points;
  // Read every photograph that has a camera, as a training or a test view.
  std::uint64_t bytes = 0;
  std::size_t number = 0;  // of photographs
  std::size_t masked_out = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    progress.update(static_cast<float>(i) / static_cast<float>(cameras.size()));
    if (files.photographs[i].empty()) continue;
    if (!is_next_face(cameras, i)) ++number;
    const bool test =
        files.first_test
            ? i >= *files.first_test
            : options.holdout > 0 && (number - 1) % static_cast<std::size_t>(options.holdout) == 0;
    auto& views = test ? data.test : data.training;
    const std::size_t earlier = views.size();
    for (const LensCamera& taken : views_of(cameras[i])) {
      PhotographView view =
          read_view({taken, files.photographs[i], files.masks[i], options.resolution_scale,
                     options.background, options.keep_alpha},
                    pool);
      if (!view.mask.empty() && std::ranges::count(view.mask, 1) == 0) continue;
      views.push_back(std::move(view));
      bytes += views.back().bytes();
      if (bytes > data.photo_memory) data.release_pixels();
    }
    if (views.size() == earlier && ++masked_out == 1)
      data.warnings.push_back(
          fmt::format("{}: masks out every pixel of {}; such photographs are left out",
                      files.masks[i].string(), files.photographs[i].string()));
  }
  // Refuse data from which nothing can be trained.
  if (data.training.empty() && masked_out > 0)
    fail("{}, and no other is left to train from", data.warnings.back());
  if (data.training.empty())
    fail("{}: all {} photographs are test views: use --holdout 0 to train from them",
         data.photographs.string(), data.test.size());
  if (masked_out > 0)
    files.left_out.push_back(counted(masked_out, "photograph") + " without a pixel that counts");
  data.used = used_sentence(files.set, number - masked_out, files.photographs_folder) + ", " +
              files.used_masks;
  data.left_out = files.left_out.empty() ? "" : "left out: " + joined(files.left_out, ", ");
  read_points_of(data);
  add_new(data.warnings, blind_sentence(data));
  std::erase(data.warnings, "");
  return data;
}

double extent_of(const std::vector<Camera>& cameras) {
  glm::dvec3 mean(0);
  for (const Camera& camera : cameras) mean += camera.position() / double(cameras.size());
  double largest = 0;
  for (const Camera& camera : cameras)
    largest = std::max(largest, glm::distance(camera.position(), mean));
  return largest > 0 ? 1.1 * largest : 1;
}

}  // namespace qs::train
