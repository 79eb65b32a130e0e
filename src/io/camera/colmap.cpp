// SPDX-License-Identifier: MIT
#include "io/camera/colmap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <system_error>

#include <glm/gtc/quaternion.hpp>

#include "base/fail.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"

namespace qs {

namespace {

constexpr std::array kModels = {
    ColmapModel{0, "SIMPLE_PINHOLE", 3, 1, true, false},
    ColmapModel{1, "PINHOLE", 4, 2, true, false},
    ColmapModel{2, "SIMPLE_RADIAL", 4, 1, true, true},
    ColmapModel{3, "RADIAL", 5, 1, true, true},
    ColmapModel{4, "OPENCV", 8, 2, true, true},
    ColmapModel{5, "OPENCV_FISHEYE", 8, 2, false, false},
    ColmapModel{6, "FULL_OPENCV", 12, 2, true, false},
    ColmapModel{7, "FOV", 5, 2, false, false},
    ColmapModel{8, "SIMPLE_RADIAL_FISHEYE", 4, 1, false, false},
    ColmapModel{9, "RADIAL_FISHEYE", 5, 1, false, false},
    ColmapModel{10, "THIN_PRISM_FISHEYE", 12, 2, false, false},
    ColmapModel{11, "RAD_TAN_THIN_PRISM_FISHEYE", 16, 2, false, false},
};

constexpr std::uint64_t kMaxSide = 65535;

// The first model for which `is_wanted` is true; nullptr if there is none.
template <class F>
const ColmapModel* find_model(const F& is_wanted) {
  const auto found = std::find_if(kModels.begin(), kModels.end(), is_wanted);
  return found == kModels.end() ? nullptr : &*found;
}

}  // namespace

const ColmapModel* find_colmap_model(int id) {
  return find_model([&](const ColmapModel& model) { return model.id == id; });
}

const ColmapModel* find_colmap_model(std::string_view name) {
  return find_model([&](const ColmapModel& model) { return model.name == name; });
}

void add_colmap_lens(ColmapLenses& lenses, const ColmapLens& stored, const std::string& where) {
  const auto& [id, model, width, height, parameters] = stored;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
    fail("{}: a picture of {} x {} pixels is not between 1 x 1 and {} x {}", where, width, height,
         kMaxSide, kMaxSide);
  for (const double value : parameters)
    if (!std::isfinite(value)) fail("{}: a parameter is not finite", where);
  // The parameters are focal lengths, the principal point and the distortion.
  const auto focal_lengths = static_cast<std::size_t>(model.focal_lengths);
  const auto distortion = parameters.subspan(focal_lengths + 2);
  const bool distorts = std::any_of(distortion.begin(), distortion.end(),
                                    [](double value) { return std::abs(value) > kNoDistortion; });
  if (!model.pinhole || (distorts && !model.undistorted))
    fail("{}: a {} lens that distorts; undistort the photographs first (colmap image_undistorter)",
         where, model.name);
  Lens lens;
  lens.focal_px = {parameters[0], parameters[focal_lengths - 1]};
  lens.center_px = {parameters[focal_lengths] - 0.5, parameters[focal_lengths + 1] - 0.5};
  if (!(lens.focal_px.x > 0 && lens.focal_px.y > 0))
    fail("{}: the focal length is not above 0", where);
  Camera size;
  size.width = static_cast<int>(width);
  size.height = static_cast<int>(height);
  LensCamera camera{size, std::nullopt, {}};
  camera.camera.focal_px = lens.focal_px;
  camera.camera.center_px = lens.center_px;
  if (distorts) {
    for (std::size_t i = 0; i < distortion.size(); ++i) lens.*kDistortion[i].second = distortion[i];
    camera = undistorted_camera(size, lens, where);
  }
  if (!lenses.emplace(id, camera).second) fail("{}: there is another camera {}", where, id);
}

LensCamera colmap_camera(const ColmapLenses& lenses, const ColmapImage& image,
                         const std::string& where) {
  const auto lens = lenses.find(image.lens);
  if (lens == lenses.end()) fail("{}: there is no camera {}", where, image.lens);
  const double length = glm::length(image.rotation);
  if (!std::isfinite(length) || length < 1e-9) fail("{}: its quaternion is no rotation", where);
  for (int i = 0; i < 3; ++i)
    if (!std::isfinite(image.translation[i])) fail("{}: its translation is not finite", where);
  const glm::dmat3 rotation = glm::mat3_cast(image.rotation / length);
  LensCamera result = lens->second;
  Camera& camera = result.camera;
  camera.view_from_world = glm::dmat4x3(rotation[0], rotation[1], rotation[2], image.translation);
  camera.name = photograph_name(image.name);
  return result;
}

std::optional<std::filesystem::path> find_points_file(const std::filesystem::path& data) {
  std::error_code error;
  for (const char* folder : {"sparse/0", "sparse", "0", "."}) {
    for (const char* name : {"points3D.bin", "points3D.txt"}) {
      const auto file = (data / folder / name).lexically_normal();
      if (std::filesystem::is_regular_file(file, error)) return file;
    }
  }
  return std::nullopt;
}

std::vector<ScenePoint> read_points(const std::filesystem::path& file) {
  return file.extension() == ".txt" ? read_colmap_points_text(file)
                                    : read_colmap_points_binary(file);
}

}  // namespace qs
