// SPDX-License-Identifier: MIT
//
// NeRF's transforms.json as written for instant-ngp, nerfcontext and the Blender scenes. A frame's
// transform_matrix is world_from_view by rows, with OpenGL's view axes (x right, y up, z back).
// Intrinsics are given for the file or, with precedence, for the frame: fl_x, fl_y or
// camera_angle_x, _y; cx, cy from pixel corners; w, h, or else the size of the first frame's
// photograph. Distortion k1, k2, p1, p2 is defined as in Lens.
#include <cmath>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "base/path_kind.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/camera_formats.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

using nlohmann::json;

constexpr double kMaxAngle = 3.1;  // just below pi

// A frame's values, with the file's values as defaults.
struct FrameEntry {
  const JsonEntry frame, file;

  const JsonEntry& with(const char* key) const { return frame.has(key) ? frame : file; }
  bool has(const char* key) const { return with(key).has(key); }
  double number(const char* key) const { return with(key).number(key); }
};

double focal_px(const FrameEntry& frame, const char* length, const char* angle, int side) {
  if (frame.has(length)) return frame.with(length).positive(length);
  const double radians = frame.with(angle).positive(angle);
  if (radians > kMaxAngle)
    fail("{}: {} is {}, but is less than pi", frame.frame.where, angle, radians);
  return 0.5 * side / std::tan(0.5 * radians);
}

void require_known_lens(const FrameEntry& frame) {
  for (const char* key : {"k3", "k4"})
    if (frame.has(key) && std::abs(frame.number(key)) > kNoDistortion)
      fail("{}: {} is not 0: the lens distorts; undistort the photographs first", frame.frame.where,
           key);
  if (!frame.has("camera_model")) return;
  const std::string& model = frame.with("camera_model").text("camera_model");
  if (model.find("PINHOLE") == std::string::npos && model != "OPENCV" && model != "RADIAL" &&
      model != "SIMPLE_RADIAL")
    fail("{}: camera_model {} is no pinhole camera; undistort the photographs first",
         frame.frame.where, model.substr(0, 40));
}

// The camera with the frame's distortion; `camera` has the intrinsics of the photograph.
LensCamera with_lens(const Camera& camera, const FrameEntry& frame) {
  Lens lens{camera.focal_px, camera.center_px};
  bool distorts = false;
  for (const auto& [key, member] : kDistortion) {
    if (frame.has(key)) lens.*member = frame.number(key);
    distorts = distorts || std::abs(lens.*member) > kNoDistortion;
  }
  return distorts ? undistorted_camera(camera, lens, frame.frame.where)
                  : LensCamera{camera, std::nullopt, {}};
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
  if (const double error = rotation_error(view_from_world); !(error < kMaxRotationError))
    fail("{}: transform_matrix holds no rotation (off by {:.2g})", frame.where, error);
  return {view_from_world[0], view_from_world[1], view_from_world[2],
          -(view_from_world * position)};
}

std::filesystem::path photograph_of(const JsonEntry& frame, const std::filesystem::path& file) {
  return file.parent_path() / frame.text("file_path");
}

// Blender's files give neither the size of their photographs nor their extension, .png.
glm::ivec2 photograph_size(const JsonEntry& frame, const std::filesystem::path& file) {
  std::filesystem::path path = photograph_of(frame, file);
  if (!is_there(path)) path += ".png";
  if (!is_there(path))
    fail("{}: w and h are missing, and so is its photograph {}", frame.where, path.string());
  const Image image = read_image(path);
  return {image.width, image.height};
}

}  // namespace

std::vector<LensCamera> read_transforms_json(const std::filesystem::path& path) {
  const std::string source = path.string();
  const json file = parse_json(read_text_file(path, kMaxCameraFileBytes), source);
  if (!file.is_object() || !file.contains("frames") || !file["frames"].is_array())
    fail("{}: not a list of cameras, nor an object with a list of frames", source);
  std::vector<LensCamera> cameras;
  glm::ivec2 size(0);  // the photographs' size; 0 until one is read
  for (const json& object : file["frames"]) {
    const std::string where = fmt::format("{}: frame {}", source, cameras.size());
    if (!object.is_object()) fail("{}: not a JSON object", where);
    const FrameEntry frame{{object, where}, {file, where}};
    require_known_lens(frame);
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
    camera.focal_px.x = focal_px(frame, "fl_x", "camera_angle_x", camera.width);
    const bool own_height =
        frame.has("fl_y") || (!frame.has("fl_x") && frame.has("camera_angle_y"));
    camera.focal_px.y =
        own_height ? focal_px(frame, "fl_y", "camera_angle_y", camera.height) : camera.focal_px.x;
    camera.center_px = 0.5 * glm::dvec2(camera.width - 1, camera.height - 1);
    if (frame.has("cx")) camera.center_px.x = frame.number("cx") - 0.5;
    if (frame.has("cy")) camera.center_px.y = frame.number("cy") - 0.5;
    if (frame.frame.has("file_path"))
      camera.name = photograph_name(photograph_of(frame.frame, path).filename().string());
    cameras.push_back(with_lens(camera, frame));
    if (frame.frame.has("file_path"))
      cameras.back().photograph =
          std::filesystem::path(frame.frame.text("file_path")).lexically_normal();
  }
  return cameras;
}

}  // namespace qs
