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
#include "base/path_kind.h"
#include "base/text.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"
#include "learn/run/hash.h"
#include "raster/kernel/random.h"
#include "raster/scene/image_metrics.h"
#include "raster/scene/place.h"

namespace qs::train {
namespace {

// The cameras of a data set, by name.
struct DataCameras {
  CameraSet set;
  std::optional<std::size_t> first_test;  // of Blender's data sets: the training cameras are first
};

// A file of Blender's data sets. Names have the photographs' folders.
CameraSet blender_cameras(const std::filesystem::path& file) {
  CameraSet set = read_camera_set(file);
  for (LensCamera& camera : set.cameras)
    camera.camera.name = photograph_name(
        std::filesystem::path(with_slashes(camera.photograph)).lexically_normal().generic_string());
  sort_by_name(set.cameras);
  return set;
}

DataCameras cameras_of(const DataOptions& options) {
  const auto train = options.data / "transforms_train.json";
  const auto test = options.data / "transforms_test.json";
  const auto validation = options.data / "transforms_val.json";
  if (!is_file(train)) {
    DataCameras cameras{read_camera_set(options.data), std::nullopt};
    sort_by_name(cameras.set.cameras);
    return cameras;
  }
  DataCameras cameras{blender_cameras(train), std::nullopt};
  CameraSet& set = cameras.set;
  cameras.first_test = set.cameras.size();
  if (is_file(test)) {
    const CameraSet more = blender_cameras(test);
    set.cameras.insert(set.cameras.end(), more.cameras.begin(), more.cameras.end());
    set.left_out.insert(set.left_out.end(), more.left_out.begin(), more.left_out.end());
    set.warnings.insert(set.warnings.end(), more.warnings.begin(), more.warnings.end());
  }
  if (is_file(validation)) set.warnings.push_back(validation.string() + ": is not used");
  return cameras;
}

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

// The folder `given` in the data set; if it is empty, `usual`, or `otherwise` if that is missing.
std::filesystem::path folder_of(const DataOptions& options, const std::filesystem::path& given,
                                const char* usual, const std::filesystem::path& otherwise) {
  const std::filesystem::path folder = options.data / (given.empty() ? usual : given);
  return !given.empty() || is_folder(folder) ? folder : otherwise;
}

bool names_photographs_by_path(const CameraSet& set) { return set.file.extension() == ".json"; }

std::filesystem::path photographs_folder(const DataOptions& options, const CameraSet& set) {
  if (options.images.empty() && names_photographs_by_path(set))
    if (const auto shared = shared_folder(photograph_names(set.cameras), set.folder()))
      return *shared;
  return folder_of(options, options.images, "images", options.data);
}

// The photographs of the cameras; empty: none. A given folder holds all of them.
std::vector<std::filesystem::path> photographs_of(const DataOptions& options, const CameraSet& set,
                                                  const Photographs& photographs) {
  std::filesystem::path from;
  if (options.images.empty())
    from = names_photographs_by_path(set) ? set.folder() : photographs.folder();
  return find_pictures(photograph_names(set.cameras), from, photographs);
}

// The masks of photographs.
struct Masks {
  std::vector<std::filesystem::path> files;  // of every camera; empty: it has none
  std::filesystem::path folder;              // empty: the cameras file names them
  bool exist = false;
};

// Masks that the cameras file names. Photographs may share one.
Masks named_masks(const CameraSet& set) {
  const auto names = list_of<std::string>(set.cameras, &LensCamera::mask);
  std::vector<std::string> given = names;
  std::erase(given, "");
  if (given.empty()) return {};
  const Photographs pictures(shared_folder(given, set.folder()).value_or(set.folder()));
  Masks masks{find_pictures(names, set.folder(), pictures, true), {}, true};
  if (std::ranges::all_of(masks.files, [](const auto& file) { return file.empty(); }))
    fail("{}: none of the masks that it names exists, such as {}", set.file.string(), given[0]);
  return masks;
}

// Masks of a folder: NAME.jpg.png or NAME.png.
Masks masks_of_folder(const std::vector<std::filesystem::path>& photographs,
                      const std::filesystem::path& folder,
                      const std::filesystem::path& mask_folder) {
  const Photographs pictures(mask_folder);
  std::vector<std::string> with_ending, names;
  for (const std::filesystem::path& file : photographs) {
    const std::string name = file.lexically_relative(folder).generic_string();
    with_ending.push_back(file.empty() ? "" : name + ".png");
    names.push_back(file.empty() ? "" : name);
  }
  Masks masks{find_pictures(with_ending, {}, pictures), mask_folder, true};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!masks.files[i].empty()) names[i].clear();
  const auto others = find_pictures(names, {}, pictures);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (masks.files[i].empty()) masks.files[i] = others[i];
  return masks;
}

// The masks of `photographs`, which lie in the folder.
Masks masks_of(const DataOptions& options, const CameraSet& set,
               const std::vector<std::filesystem::path>& photographs,
               const std::filesystem::path& folder) {
  if (options.masks.empty())
    if (Masks named = named_masks(set); named.exist) return named;
  const auto mask_folder = folder_of(options, options.masks, "masks", {});
  return mask_folder.empty() ? Masks{} : masks_of_folder(photographs, folder, mask_folder);
}

std::string masks_text(const Masks& masks, const CameraSet& set,
                       const std::vector<std::filesystem::path>& photographs) {
  if (!masks.exist) return "no masks";
  std::size_t views = 0, covered = 0;
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    views += photographs[i].empty() ? 0 : 1;
    covered += photographs[i].empty() || masks.files[i].empty() ? 0 : 1;
  }
  const std::string place = masks.folder.empty()
                                ? "as " + set.file.filename().string() + " names them"
                                : "in " + masks.folder.string();
  return covered == views
             ? fmt::format("{} {}", counted(covered, "mask"), place)
             : fmt::format("masks of {} of {} photographs {}, the others count as a whole", covered,
                           views, place);
}

void read_points_of(const DataOptions& options, const CameraSet& set, DataSet& data) {
  std::optional<std::filesystem::path> file;
  if (!set.points.empty()) {
    for (const std::string& spelled : {set.points, with_slashes(set.points)})
      if (!file && is_file(set.folder() / spelled))
        file = (set.folder() / spelled).lexically_normal();
    if (!file)
      data.warnings.push_back(fmt::format("{}: there is no file of points {}, which it names",
                                          set.file.string(), set.points));
  }
  if (!file)
    file = names_photographs_by_path(set) ? find_points_file(options.data)
                                          : find_points_of_model(set.folder(), options.data);
  if (!file) return;
  data.points_file = *file;
  const std::vector<ScenePoint> points = read_points(*file);
  data.points = without_repetitions(points);
  data.repeated_points = points.size() - data.points.size();
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

// In its full size, undistorted.
Image read_checked(const PhotographSource& source, glm::vec3 background, ThreadPool& pool) {
  Image photograph = read_photograph(source.file, background, 1, pool, source.taken);
  require_same_shape(photograph, source.file, source.taken.camera);
  const std::vector<float>& values = photograph.values;
  if (!std::ranges::all_of(values, [](float value) { return std::isfinite(value); }))
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
  if (mask.width != photograph.width || mask.height != photograph.height)
    fail("{}: a mask of {} x {} pixels, but its photograph {} has {} x {}", source.mask.string(),
         mask.width, mask.height, source.file.string(), photograph.width, photograph.height);
  // The sums of zeros are exact, so a pixel counts only if no part of it is masked out.
  const Image out =
      reduced(undistorted(masked_out(mask), source.taken, pool), source.resolution_scale, pool);
  std::vector<std::uint8_t> counts(out.values.size());
  std::ranges::transform(out.values, counts.begin(),
                         [](float value) { return static_cast<std::uint8_t>(value > 0 ? 0 : 1); });
  const auto masked = std::ranges::count(counts, std::uint8_t{0});
  if (masked == 0) return {};
  if (static_cast<std::size_t>(masked) == counts.size())
    fail("{}: masks out every pixel of {}", source.mask.string(), source.file.string());
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
  const Image photograph = read_checked(source, background, pool);
  const Image image = reduced(photograph, source.resolution_scale, pool);
  const LensCamera camera = source.taken.scaled(image.width, image.height);
  PhotographView view{camera.camera, camera.lens, source, {}, {}, {}};
  view.rgb.resize(image.values.size());
  std::ranges::transform(image.values, view.rgb.begin(), to_8bit);
  if (!source.mask.empty()) view.mask = read_mask(source, photograph, pool);
  if (!source.keep_alpha) return view;
  // Over white, a pixel is brighter than over black by 1 - alpha.
  const Image white =
      reduced(read_checked(source, glm::vec3(1), pool), source.resolution_scale, pool);
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
    for (const PhotographView& view : *views) all.push_back({view.camera, view.lens, {}});
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
  auto [set, first_test] = cameras_of(options);
  std::vector<LensCamera>& cameras = set.cameras;
  DataSet data;
  data.origin = move_near_origin(cameras);
  data.folder = options.data;
  data.photographs = photographs_folder(options, set);
  data.blender = first_test.has_value();
  data.photo_memory = options.photo_memory;
  data.warnings = set.sentences();
  const Photographs photographs(data.photographs);
  const auto files = photographs_of(options, set, photographs);
  if (std::ranges::all_of(files, [](const auto& file) { return file.empty(); }))
    fail(
        "{}: holds no photograph named like one of the {} cameras of {}: name the folder with "
        "--images",
        data.photographs.string(), cameras.size(), options.data.string());
  const Masks masks = masks_of(options, set, files, data.photographs);
  data.used = used_sentence(set, files, photographs) + ", " + masks_text(masks, set, files);
  data.left_out = left_out_sentence(set, files, photographs, masks.folder);
  add_new(data.warnings, orientation_sentence(cameras, files));
  std::erase(data.warnings, "");
  if (!options.masks.empty() &&
      std::ranges::all_of(masks.files, [](const auto& file) { return file.empty(); }))
    fail("{}: holds no mask named like one of the photographs of {}", masks.folder.string(),
         data.photographs.string());
  // Read every photograph that has a camera, as a training or a test view.
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    progress.update(static_cast<float>(i) / static_cast<float>(cameras.size()));
    if (files[i].empty()) continue;
    const std::size_t number = data.training.size() + data.test.size();
    const bool test =
        first_test ? i >= *first_test
                   : options.holdout > 0 && number % static_cast<std::size_t>(options.holdout) == 0;
    const PhotographSource source{cameras[i],
                                  files[i],
                                  masks.exist ? masks.files[i] : std::filesystem::path(),
                                  options.resolution_scale,
                                  options.background,
                                  options.keep_alpha};
    auto& views = test ? data.test : data.training;
    views.push_back(read_view(source, pool));
    bytes += views.back().bytes();
    if (bytes > data.photo_memory) data.release_pixels();
  }
  // Refuse data from which nothing can be trained.
  if (data.training.empty())
    fail("{}: all {} photographs are test views: use --holdout 0 to train from them",
         data.photographs.string(), data.test.size());
  read_points_of(options, set, data);
  for (ScenePoint& point : data.points) point.position -= data.origin;
  return data;
}

std::vector<std::size_t> outliers(const std::vector<Camera>& cameras) {
  constexpr double kFarInMedians = 10;
  const auto median_of = [](std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  if (cameras.empty()) return {};
  glm::dvec3 middle;
  std::vector<double> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const Camera& camera : cameras) values.push_back(camera.position()[axis]);
    middle[axis] = median_of(values);
  }
  values.clear();
  for (const Camera& camera : cameras) values.push_back(glm::distance(camera.position(), middle));
  const double far = kFarInMedians * median_of(values);
  std::vector<std::size_t> found;
  for (std::size_t i = 0; far > 0 && i < cameras.size(); ++i)
    if (values[i] > far) found.push_back(i);
  // More than a few are no mistake but a second place.
  return 20 * found.size() > std::max<std::size_t>(20, cameras.size()) ? std::vector<std::size_t>()
                                                                       : found;
}

std::vector<Camera> without_outliers(const std::vector<Camera>& cameras) {
  std::vector<Camera> kept = cameras;
  const std::vector<std::size_t> far = outliers(cameras);
  for (auto i = far.rbegin(); i != far.rend(); ++i)
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(*i));
  return kept;
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
