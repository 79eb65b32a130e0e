// SPDX-License-Identifier: MIT
#include "app/train/data_set.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <system_error>

#include <glm/geometric.hpp>

#include "app/session/photographs.h"
#include "app/train/hash.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"
#include "raster/base/fail.h"
#include "raster/scene/image_metrics.h"

namespace qs::train {
namespace {

constexpr int kMostWidth = 1600;

int divided(int side, int divisor) { return std::max(1, (side + divisor / 2) / divisor); }

// A photograph at the resolution of training.
Image reduced(const Image& photograph, std::optional<int> scale, ThreadPool& pool) {
  const int width = photograph.width, height = photograph.height;
  if (scale) return area_average(photograph, divided(width, *scale), divided(height, *scale), pool);
  if (width <= kMostWidth) return photograph;
  const double factor = static_cast<double>(kMostWidth) / width;
  return area_average(photograph, kMostWidth,
                      std::max(1, static_cast<int>(std::lround(height * factor))), pool);
}

Image read_reduced(const LensCamera& taken, const std::filesystem::path& file, glm::vec3 background,
                   const DataOptions& options, ThreadPool& pool) {
  const Image photograph = read_photograph(file, background, 1, pool, taken);
  require_same_shape(photograph, file, taken.camera);
  for (const float value : photograph.values) {
    if (!std::isfinite(value)) fail("{}: holds values that are not finite numbers", file.string());
  }
  return reduced(photograph, options.resolution_scale, pool);
}

PhotographView read_view(const LensCamera& taken, const std::filesystem::path& file,
                         const DataOptions& options, ThreadPool& pool) {
  const glm::vec3 background = options.keep_alpha ? glm::vec3(0) : options.background;
  const Image image = read_reduced(taken, file, background, options, pool);
  const LensCamera camera = taken.scaled(image.width, image.height);
  PhotographView view{camera.camera, camera.lens, file, {}, {}};
  view.rgb.resize(image.values.size());
  std::transform(image.values.begin(), image.values.end(), view.rgb.begin(), to_8bit);
  if (!options.keep_alpha) return view;
  // Over white a pixel is brighter by 1 - alpha.
  const Image white = read_reduced(taken, file, glm::vec3(1), options, pool);
  for (std::size_t i = 0; i < image.values.size(); i += 3)
    view.alpha.push_back(to_8bit(1 - (white.values[i] - image.values[i])));
  if (std::all_of(view.alpha.begin(), view.alpha.end(), [](auto alpha) { return alpha == 255; }))
    view.alpha.clear();
  return view;
}

// The cameras of a file of Blender's data sets.
std::vector<LensCamera> blender_cameras(const std::filesystem::path& file) {
  std::vector<LensCamera> cameras = read_lens_cameras(file);
  for (LensCamera& camera : cameras)
    camera.camera.name = photograph_name(camera.photograph.generic_string());
  return cameras;
}

// All cameras by name. Set: the number of training views, which then come first.
std::vector<LensCamera> cameras_of(const DataOptions& options, std::optional<std::size_t>& first) {
  const auto train = options.data / "transforms_train.json";
  const auto test = options.data / "transforms_test.json";
  std::error_code error;
  if (!std::filesystem::is_regular_file(train, error)) {
    std::vector<LensCamera> cameras = read_lens_cameras(options.data);
    sort_by_name(cameras);
    return cameras;
  }
  std::vector<LensCamera> cameras = blender_cameras(train);
  sort_by_name(cameras);
  first = cameras.size();
  if (std::filesystem::is_regular_file(test, error)) {
    std::vector<LensCamera> more = blender_cameras(test);
    sort_by_name(more);
    cameras.insert(cameras.end(), more.begin(), more.end());
  }
  return cameras;
}

std::filesystem::path photographs_of(const DataOptions& options) {
  if (!options.images.empty()) return options.data / options.images;
  std::error_code error;
  const auto usual = options.data / "images";
  return std::filesystem::is_directory(usual, error) ? usual : options.data;
}

}  // namespace

std::vector<glm::vec3> PhotographView::target(glm::vec3 background) const {
  std::vector<glm::vec3> pixels(rgb.size() / 3);
  for (std::size_t i = 0; i < rgb.size(); ++i)
    pixels[i / 3][static_cast<int>(i % 3)] = static_cast<float>(rgb[i]) / 255;
  for (std::size_t i = 0; i < alpha.size(); ++i)
    pixels[i] += background * (1 - static_cast<float>(alpha[i]) / 255);
  return pixels;
}

Image PhotographView::image() const {
  Image image(camera.width, camera.height, 3);
  std::transform(rgb.begin(), rgb.end(), image.values.begin(),
                 [](std::uint8_t value) { return static_cast<float>(value) / 255; });
  return image;
}

std::vector<LensCamera> DataSet::cameras() const {
  std::vector<LensCamera> all;
  for (const auto* views : {&training, &test}) {
    for (const PhotographView& view : *views) all.push_back({view.camera, view.lens, {}});
  }
  sort_by_name(all);
  return all;
}

std::string DataSet::fingerprint() const {
  std::uint64_t hash = 0;
  const auto add = [&hash](const auto& bytes) {
    hash = hash_of(std::as_bytes(std::span(bytes)), hash);
  };
  for (const auto* views : {&training, &test}) {
    for (const PhotographView& view : *views) {
      add(format_camera(view.camera));
      add(view.rgb);
      add(view.alpha);
    }
  }
  return fmt::format("{} training and {} test views, {:016x}", training.size(), test.size(), hash);
}

double DataSet::extent() const {
  std::vector<Camera> cameras;
  for (const PhotographView& view : training) cameras.push_back(view.camera);
  return extent_of(cameras);
}

DataSet read_data_set(const DataOptions& options, ThreadPool& pool, const Progress& progress) {
  std::optional<std::size_t> first_test;
  const std::vector<LensCamera> cameras = cameras_of(options, first_test);
  DataSet set;
  set.folder = options.data;
  set.photographs = photographs_of(options);
  set.blender = first_test.has_value();
  const Photographs photographs(set.photographs);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    progress.update(static_cast<float>(i) / static_cast<float>(cameras.size()));
    const auto file = photographs.find(cameras[i].camera.name);
    if (!file) {
      ++set.skipped;
      continue;
    }
    const std::size_t number = set.training.size() + set.test.size();
    const bool test =
        first_test ? i >= *first_test
                   : options.holdout > 0 && number % static_cast<std::size_t>(options.holdout) == 0;
    (test ? set.test : set.training).push_back(read_view(cameras[i], *file, options, pool));
  }
  if (set.training.empty() && set.test.empty()) {
    fail(
        "{}: holds no photograph named like one of the {} cameras of {}: name the folder with "
        "--images",
        set.photographs.string(), cameras.size(), options.data.string());
  }
  if (set.training.empty()) {
    fail("{}: all {} photographs are test views: use --holdout 0 to train from them",
         set.photographs.string(), set.test.size());
  }
  if (const auto points = find_points_file(options.data)) set.points = read_points(*points);
  return set;
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
