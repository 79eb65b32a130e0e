// SPDX-License-Identifier: MIT
//
// NeRF's transforms.json as written for instant-ngp, nerfcontext and the Blender scenes. A frame's
// transform_matrix is world_from_view by rows, with OpenGL's view axes (x right, y up, z back).
// Intrinsics are given for the file or, with precedence, for the frame: fl_x, fl_y or
// camera_angle_x, _y; cx, cy from pixel corners; w, h, or else the size of the first frame's
// photograph. lens_json.cpp has the keys of lenses. A
// frame's mask_path names its mask, and the file's ply_file_path its points. A camera is named as
// its photograph, without the folders that all photographs share.
#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "io/bytes/byte_text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/camera_formats.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

using nlohmann::json;

constexpr double kMaxAngle = 3.1;  // just below pi

double focal_px(const FrameEntry& frame, const char* length, const char* angle, int side) {
  if (frame.has(length)) return frame.with(length).positive(length);
  const double radians = frame.with(angle).positive(angle);
  if (radians > kMaxAngle)
    fail("{}: {} is {}, but is less than pi", frame.frame.where, angle, radians);
  return 0.5 * side / std::tan(0.5 * radians);
}

// Keys whose data would change the result, but which are not used.
constexpr const char* kUnusedKeys[] = {"train_filenames", "val_filenames",      "test_filenames",
                                       "depth_file_path", "rolling_shutter",    "camera_type",
                                       "distortion",      "fisheye_crop_radius"};

// Sentences about data of the file that is not used.
void warn_of_unused(const json& file, const std::string& source, CameraSet& set) {
  for (const char* key : kUnusedKeys) {
    const auto in_frame = [&](const json& frame) {
      return frame.is_object() && frame.contains(key);
    };
    if (file.contains(key) || std::ranges::any_of(file["frames"], in_frame))
      set.warnings.push_back(fmt::format("{}: {} is not used", source, key));
  }
  if (file.contains("mask_path"))
    set.warnings.push_back(fmt::format("{}: mask_path is not used outside frames", source));
}

glm::dmat4x3 view_from_world(const JsonEntry& frame) {
  const json& rows = frame.get("transform_matrix");
  if (!rows.is_array() || rows.size() < 3 || rows.size() > 4)
    fail("{}: transform_matrix is not a list of 3 or 4 rows", frame.where);
  glm::dmat3 view_from_world;  // its columns are the rows of world_from_view
  glm::dvec3 position;
  for (int i = 0; i < 3; ++i) {
    const auto row = frame.vector<4>(rows[static_cast<std::size_t>(i)], "transform_matrix");
    view_from_world[i] = {row.x, -row.y, -row.z};
    position[i] = row.w;
  }
  if (rows.size() == 4) {
    const auto last = frame.vector<4>(rows[3], "transform_matrix");
    if (glm::distance(last, glm::dvec4(0, 0, 0, 1)) > kMaxRotationError)
      fail("{}: the last row of transform_matrix is not 0, 0, 0, 1: is it transposed?",
           frame.where);
  }
  if (const double error = rotation_error(view_from_world); !(error < kMaxRotationError))
    fail("{}: transform_matrix holds no rotation (off by {:.2g})", frame.where, error);
  return {view_from_world[0], view_from_world[1], view_from_world[2],
          -(view_from_world * position)};
}

// Blender's files give neither the size of their photographs nor their endings.
glm::ivec2 photograph_size(const JsonEntry& frame, const std::filesystem::path& file) {
  const std::string& name = frame.text("file_path");
  const auto path = picture_at(file.parent_path(), name);
  if (!path)
    fail("{}: w and h are missing, and so is its photograph {}", frame.where,
         (file.parent_path() / name).string());
  const Image image = read_image(*path);
  return {image.width, image.height};
}

// Names the cameras as their photographs, without the folders of all of them.
void name_cameras(std::vector<LensCamera>& cameras) {
  namespace fs = std::filesystem;
  std::optional<fs::path> shared;
  const auto is_in = [](const fs::path& path, const fs::path& folder) {
    return std::ranges::mismatch(path, folder).in2 == folder.end();
  };
  for (const LensCamera& camera : cameras) {
    if (camera.photograph.empty()) continue;
    const fs::path folder = path_of(camera.photograph).parent_path();
    if (!shared) shared = folder;
    while (!is_in(folder, *shared))
      shared = shared->has_relative_path() ? shared->parent_path() : fs::path();
  }
  for (LensCamera& camera : cameras) {
    if (camera.photograph.empty()) continue;
    const fs::path path = path_of(camera.photograph);
    const fs::path name = shared->empty() ? path : path.lexically_relative(*shared);
    camera.camera.name = photograph_name(name.generic_string());
  }
}

// The camera of a frame. `size` are the pixels of photographs whose size is not given; 0 until one
// is read.
LensCamera camera_of_frame(const FrameEntry& frame, const std::filesystem::path& path,
                           glm::ivec2& size) {
  Camera camera;
  camera.view_from_world = view_from_world(frame.frame);
  if (!frame.has("w") && !frame.has("h")) {
    if (size.x == 0) size = photograph_size(frame.frame, path);
    camera.width = size.x;
    camera.height = size.y;
  } else {
    camera.width = frame.with("w").side("w");
    camera.height = frame.with("h").side("h");
  }
  Lens lens = lens_of_transforms(frame);
  lens.size_px = {camera.width, camera.height};
  if (lens.model->focal_lengths > 0) {
    lens.focal_px.x = focal_px(frame, "fl_x", "camera_angle_x", camera.width);
    const bool own_height =
        frame.has("fl_y") || (!frame.has("fl_x") && frame.has("camera_angle_y"));
    lens.focal_px.y =
        own_height ? focal_px(frame, "fl_y", "camera_angle_y", camera.height) : lens.focal_px.x;
  }
  lens.center_px = 0.5 * (lens.size_px - 1.0);
  if (frame.has("cx")) lens.center_px.x = frame.number("cx") - 0.5;
  if (frame.has("cy")) lens.center_px.y = frame.number("cy") - 0.5;
  LensCamera result = lens_camera(lens, frame.frame.where);
  result.camera.view_from_world = camera.view_from_world;
  return result;
}

}  // namespace

CameraSet read_transforms_json(const std::filesystem::path& path) {
  const std::string source = path.string();
  const json file = parse_python_json(read_text_file(path, kMaxCameraFileBytes), source);
  if (!file.is_object() || !file.contains("frames") || !file["frames"].is_array())
    fail("{}: not a list of cameras, nor an object with a list of frames", source);
  CameraSet set{path};
  glm::ivec2 size(0);
  const json& frames = file["frames"];
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string where = fmt::format("{}: frame {}", source, i);
    if (!frames[i].is_object()) fail("{}: not a JSON object", where);
    const FrameEntry frame{{frames[i], where}, {file, where}};
    const auto text = [&](const char* key) {
      return frame.frame.has(key) ? frame.frame.text(key) : "";
    };
    const std::string photograph = text("file_path"), mask = text("mask_path");
    add_camera(set, photograph, [&] {
      LensCamera camera = camera_of_frame(frame, path, size);
      camera.photograph = photograph;
      camera.mask = mask;
      return camera;
    });
  }
  name_cameras(set.cameras);
  const JsonEntry entry{file, source};
  if (entry.has("ply_file_path")) set.points = entry.text("ply_file_path");
  warn_of_unused(file, source, set);
  return set;
}

}  // namespace qs
