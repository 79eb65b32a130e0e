// SPDX-License-Identifier: MIT
//
// cameras.json, see cameras.h. Keys beyond INRIA's layout: cx, cy, near, and the exact values
// "translation" and "center_px". format_camera() adds these two because computing them from
// position and cx loses the last bits. They are ignored if they disagree with position and cx, cy,
// so that position, cx and cy can be edited by hand.
#include "io/camera/cameras.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/camera_formats.h"

namespace qs {
namespace {

using nlohmann::json;

// view_from_world: the transpose of the file's world_from_view, whose rows become columns.
glm::dmat3 parse_rotation(const JsonEntry& entry) {
  const json& rows = entry.get("rotation");
  if (!rows.is_array() || rows.size() != 3)
    fail("{}: rotation is not a list of 3 rows", entry.where);
  glm::dmat3 rotation;
  for (int i = 0; i < 3; ++i)
    rotation[i] = entry.vector<3>(rows[static_cast<std::size_t>(i)], "rotation");
  if (const double error = rotation_error(rotation); !(error < kMaxRotationError))
    fail("{}: rotation is not a rotation matrix (off by {:.2g})", entry.where, error);
  return rotation;
}

bool agree(double a, double b) { return std::abs(a - b) <= 1e-9 * (1 + std::abs(a) + std::abs(b)); }

Camera parse_object(const json& object, const std::string& where) {
  if (!object.is_object()) fail("{}: not a JSON object", where);
  const JsonEntry entry{object, where};
  Camera camera;
  const glm::dmat3 rotation = parse_rotation(entry);
  const auto position = entry.vector<3>("position");
  glm::dvec3 translation = -(rotation * position);
  if (entry.has("translation")) {
    const auto exact = entry.vector<3>("translation");
    const double tolerance = 1e-9 * (1 + glm::length(exact) + glm::length(position));
    if (glm::distance(exact, translation) <= tolerance) translation = exact;
  }
  camera.view_from_world = glm::dmat4x3(rotation[0], rotation[1], rotation[2], translation);
  camera.focal_px = {entry.positive("fx"), entry.positive("fy")};
  camera.width = entry.side("width");
  camera.height = entry.side("height");
  camera.center_px = 0.5 * glm::dvec2(camera.width - 1, camera.height - 1);
  if (entry.has("cx")) camera.center_px.x = entry.number("cx") - 0.5;
  if (entry.has("cy")) camera.center_px.y = entry.number("cy") - 0.5;
  if (entry.has("center_px")) {
    const auto exact = entry.vector<2>("center_px");
    if (agree(exact.x, camera.center_px.x) && agree(exact.y, camera.center_px.y))
      camera.center_px = exact;
  }
  if (entry.has("near")) camera.near_depth = entry.positive("near");
  if (entry.has("offset")) camera.origin = entry.vector<3>("offset");
  if (entry.has("img_name")) camera.name = photograph_name(entry.text("img_name"));
  return camera;
}

Camera checked_camera(const json& object, const std::string& where) {
  const Camera camera = parse_object(object, where);
  check_camera(camera, where);
  return camera;
}

json list(glm::dvec3 v) { return {v.x, v.y, v.z}; }

// A camera of a model that counts from an origin says so: "offset". It is at position + offset.
json object_of(const Camera& camera) {
  const glm::dmat4x3& view = camera.view_from_world;
  // The inverse, not the transpose: rotations read from files are orthonormal to a few digits only.
  const glm::dvec3 position = -(glm::inverse(glm::dmat3(view)) * view[3]);
  json object = {
      {"img_name", camera.name},
      {"width", camera.width},
      {"height", camera.height},
      {"position", list(position)},
      {"rotation", {list(view[0]), list(view[1]), list(view[2])}},
      {"fx", camera.focal_px.x},
      {"fy", camera.focal_px.y},
      {"cx", camera.center_px.x + 0.5},
      {"cy", camera.center_px.y + 0.5},
      {"near", camera.near_depth},
  };
  if (camera.origin != glm::dvec3(0)) object["offset"] = list(camera.origin);
  const Camera read_back = parse_object(object, "camera");
  if (read_back.view_from_world != view) object["translation"] = list(view[3]);
  if (read_back.center_px != camera.center_px)
    object["center_px"] = {camera.center_px.x, camera.center_px.y};
  return object;
}

}  // namespace

CameraSet read_cameras_json(const std::filesystem::path& path) {
  const std::string source = path.string();
  const json file = parse_python_json(read_text_file(path, kMaxCameraFileBytes), source);
  if (!file.is_array()) fail("{}: not a list of cameras", source);
  CameraSet set{path};
  for (std::size_t i = 0; i < file.size(); ++i) {
    const json& object = file[i];
    const std::string where = fmt::format("{}: camera {}", source, i);
    if (!object.is_object()) fail("{}: not a JSON object", where);
    const JsonEntry entry{object, where};
    const std::string name = entry.has("img_name") ? entry.text("img_name") : "";
    add_camera(set, name, [&] {
      LensCamera camera{parse_object(object, where), std::nullopt, name};
      camera.lens = lens_of_cameras_json(entry, {camera.camera.width, camera.camera.height});
      if (camera.lens && !camera.lens->face.empty())
        camera.photograph = entry.child("lens").text("photograph");
      return camera;
    });
  }
  return set;
}

Camera parse_camera(std::string_view text, std::string_view source) {
  return checked_camera(parse_json(text, source), std::string(source));
}

std::string format_camera(const Camera& camera) { return json_line(object_of(camera)); }

std::string format_cameras(const std::vector<LensCamera>& cameras) {
  std::string text;
  for (const LensCamera& camera : cameras) {
    json object = object_of(camera.camera);
    if (camera.lens) object["lens"] = lens_json(camera);
    text += (text.empty() ? "[\n" : ",\n") + json_line(object);
  }
  return text.empty() ? "[]\n" : text + "\n]\n";
}

nlohmann::ordered_json camera_json(const Camera& camera) { return object_of(camera); }

Camera camera_of(const nlohmann::ordered_json& object, std::string_view source) {
  return checked_camera(object, std::string(source));
}

}  // namespace qs
