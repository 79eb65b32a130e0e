// SPDX-License-Identifier: MIT
#include "learn/run/data_set.h"

#include <algorithm>
#include <span>
#include <system_error>
#include <utility>

#include <glm/geometric.hpp>
#include <unistd.h>

#include "base/fail.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"
#include "io/camera/photographs.h"
#include "learn/run/hash.h"
#include "raster/kernel/random.h"

namespace qs::train {
namespace {

// The cameras of a file of Blender's data sets, by name.
std::vector<LensCamera> blender_cameras(const std::filesystem::path& file) {
  std::vector<LensCamera> cameras = read_lens_cameras(file);
  for (LensCamera& camera : cameras)
    camera.camera.name = photograph_name(camera.photograph.generic_string());
  sort_by_name(cameras);
  return cameras;
}

// All cameras by name. In Blender's data sets the training cameras come first, and `first` is set
// to their number.
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
  first = cameras.size();
  if (std::filesystem::is_regular_file(test, error)) {
    const std::vector<LensCamera> more = blender_cameras(test);
    cameras.insert(cameras.end(), more.begin(), more.end());
  }
  return cameras;
}

// The folder `given` in the data set; if it is empty, `usual`, or `otherwise` if that is missing.
std::filesystem::path folder_of(const DataOptions& options, const std::filesystem::path& given,
                                const char* usual, const std::filesystem::path& otherwise) {
  const std::filesystem::path folder = options.data / (given.empty() ? usual : given);
  std::error_code error;
  return !given.empty() || std::filesystem::is_directory(folder, error) ? folder : otherwise;
}

// The mask of a photograph of a folder; empty: it has none. Masks are NAME.jpg.png or NAME.png.
std::filesystem::path mask_of(const std::filesystem::path& photograph,
                              const std::filesystem::path& folder,
                              const std::optional<Photographs>& masks) {
  if (!masks) return {};
  const std::string name = photograph.lexically_relative(folder).generic_string();
  const auto found = masks->find(name);
  return found ? *found : masks->find(photograph_name(name)).value_or("");
}

}  // namespace

std::uint64_t half_of_memory() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) / 2;
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
  for (const auto* views : {&training, &test}) {
    for (const PhotographView& view : *views) {
      const std::string camera = format_camera(view.camera);
      hash = mix_bits(hash_of(std::as_bytes(std::span(camera)), hash) ^ view.content_hash());
    }
  }
  return fmt::format("{} training and {} test views, {:016x}", training.size(), test.size(), hash);
}

void DataSet::release_pixels() {
  for (auto* views : {&training, &test}) {
    for (PhotographView& view : *views) view.release_pixels();
  }
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
  set.photographs = folder_of(options, options.images, "images", options.data);
  set.blender = first_test.has_value();
  set.masks = folder_of(options, options.masks, "masks", {});
  set.photo_memory = options.photo_memory;
  // Read every photograph that has a camera, as a training or a test view.
  std::uint64_t bytes = 0;
  const Photographs photographs(set.photographs);
  std::optional<Photographs> masks;
  if (!set.masks.empty()) masks.emplace(set.masks);
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
    const PhotographSource source{cameras[i],
                                  *file,
                                  mask_of(*file, set.photographs, masks),
                                  options.resolution_scale,
                                  options.background,
                                  options.keep_alpha};
    if (!set.masks.empty() && source.mask.empty()) ++set.without_mask;
    auto& views = test ? set.test : set.training;
    views.push_back(read_view(source, pool));
    bytes += views.back().bytes();
    if (bytes > set.photo_memory) set.release_pixels();
  }
  // Refuse data from which nothing can be trained.
  if (set.training.empty() && set.test.empty()) {
    fail(
        "{}: holds no photograph named like one of the {} cameras of {}: name the folder with "
        "--images",
        set.photographs.string(), cameras.size(), options.data.string());
  }
  if (!options.masks.empty() && set.without_mask == set.training.size() + set.test.size()) {
    fail("{}: holds no mask named like one of the photographs of {}", set.masks.string(),
         set.photographs.string());
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
