// SPDX-License-Identifier: MIT
#include "io/camera/camera_formats.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <system_error>

#include <glm/matrix.hpp>

#include "base/fail.h"
#include "base/path_kind.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/lfs_pointer.h"
#include "io/camera/cameras.h"

namespace qs {

namespace {

// The "frames" of transforms.json may follow after the first bytes of the file.
constexpr std::array kFormats = {
    CameraFormat{"cameras.json",
                 "cameras.json",
                 {},
                 {JsonKind::cameras, JsonKind::camera_path},
                 read_cameras_json},
    CameraFormat{"COLMAP binary",
                 "sparse/0/images.bin",
                 {"images.bin", "cameras.bin"},
                 {},
                 read_colmap_binary},
    CameraFormat{
        "COLMAP text", "sparse/0/images.txt", {"images.txt", "cameras.txt"}, {}, read_colmap_text},
    CameraFormat{"transforms.json",
                 "transforms.json",
                 {},
                 {JsonKind::transforms, JsonKind::other},
                 read_transforms_json},
};

template <class Value>
bool holds(const std::array<Value, 2>& values, const Value& value) {
  return std::ranges::find(values, value) != values.end();
}

std::string start_of(const std::filesystem::path& file) {
  std::string start(4096, '\0');
  std::ifstream stream(file, std::ios::binary);
  if (!stream) fail("{}: cannot be opened", file.string());
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream.gcount()));
  refuse_lfs_pointer(start, file);
  return start;
}

// The file to read for a folder: the data set's folder, its `sparse`, or one model inside.
std::filesystem::path file_in(const std::filesystem::path& folder) {
  for (const CameraFormat& format : kFormats) {
    const std::filesystem::path place = format.place;
    for (const auto& candidate : {place, place.filename(), "0" / place.filename()})
      if (is_file(folder / candidate)) return folder / candidate;
  }
  fail("{}: a folder without cameras.json, COLMAP's images.bin or images.txt, or transforms.json",
       folder.string());
}

std::optional<std::filesystem::path> find_beside(const std::filesystem::path& scene_file,
                                                 const char* name) {
  std::error_code error;
  std::filesystem::path folder =
      std::filesystem::absolute(scene_file, error).lexically_normal().parent_path();
  for (int level = 0; level <= 3; ++level) {
    if (std::filesystem::is_regular_file(folder / name, error)) return folder / name;
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return std::nullopt;
}

}  // namespace

std::span<const CameraFormat> camera_formats() { return kFormats; }

std::vector<Camera> read_cameras(const std::filesystem::path& path) {
  return pinhole_cameras(read_lens_cameras(path));
}

std::vector<LensCamera> read_lens_cameras(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) fail("{}: cannot be read: no such file", path.string());
  const auto file = std::filesystem::is_directory(status) ? file_in(path) : path;
  const JsonKind kind = json_kind(start_of(file));
  const std::string name = file.filename().string();
  const auto format = std::ranges::find_if(kFormats, [&](const CameraFormat& row) {
    return holds(row.names, std::string_view(name)) ||
           (kind != JsonKind::none && holds(row.kinds, kind));
  });
  if (format == kFormats.end() && kind == JsonKind::none)
    fail(
        "{}: not a file of cameras: these are cameras.json, transforms.json, and images.bin and "
        "images.txt of COLMAP",
        file.string());
  // Another file is passed to the reader of cameras.json, whose message names the defect.
  std::vector<LensCamera> cameras =
      format == kFormats.end() ? read_cameras_json(file) : format->read(file);
  for (std::size_t i = 0; i < cameras.size(); ++i)
    check_camera(cameras[i].camera, fmt::format("{}: camera {}", file.string(), i));
  return cameras;
}

std::string photograph_name(const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  if (dot == std::string::npos || dot == 0) return file_name;
  const std::string ending = lower_case(file_name.substr(dot));
  for (const char* known :
       {".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr", ".bmp", ".heic", ".ppm", ".pfm"})
    if (ending == known) return file_name.substr(0, dot);
  return file_name;
}

void check_camera(const Camera& camera, const std::string& where) {
  // Frames are computed in single precision, which holds squares up to 3e38.
  constexpr double kMost = 1e15;
  const glm::dvec3 position = camera.position();
  for (const double value : {position.x, position.y, position.z})
    if (!(std::abs(value) <= kMost))
      fail("{}: its position {:.4g} is more than {:g} from the origin", where, value, kMost);
  for (const double value : {camera.focal_px.x, camera.focal_px.y, camera.center_px.x,
                             camera.center_px.y, camera.near_depth})
    if (!(std::abs(value) <= kMost))
      fail("{}: {:.4g} for its focal length, principal point or near plane is more than {:g}",
           where, value, kMost);
}

double rotation_error(const glm::dmat3& matrix) {
  const glm::dmat3 product = matrix * glm::transpose(matrix);
  double error = std::abs(glm::determinant(matrix) - 1);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) error = std::max(error, std::abs(product[i][k] - (i == k ? 1 : 0)));
  return error;
}

std::optional<std::filesystem::path> find_cameras_file(const std::filesystem::path& scene_file) {
  for (const CameraFormat& format : camera_formats())
    if (auto found = find_beside(scene_file, format.place)) return found;
  return std::nullopt;
}

bool model_wants_white_background(const std::filesystem::path& scene_file) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  const auto path = find_beside(scene_file, "cfg_args");
  // A Python Namespace(...) in one line.
  return path &&
         read_text_file(*path, kMaxBytes).find("white_background=True") != std::string::npos;
}

}  // namespace qs
