// SPDX-License-Identifier: MIT
#include "app/measure/camera_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "app/framing/camera_control.h"
#include "base/fail.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "raster/lens/lens_view.h"

namespace qs {
namespace {

// The interpolated values of a keyframe.
struct Pose {
  glm::dvec3 position;
  glm::dquat rotation;  // world_from_view
  glm::dvec2 log_focal, center;
};

Pose pose_of(const Camera& camera) {
  return {camera.position(), glm::quat_cast(glm::transpose(glm::dmat3(camera.view_from_world))),
          glm::log(camera.focal_px), camera.center_px};
}

// A piece of the path between two keyframes.
struct Piece {
  double before, span, after;  // durations of this interval and its neighbours, 0 beyond the ends
  bool begins_still, ends_still;  // the camera rests at the keyframe
};

// The cubic through b (t = 0) and c (t = span) with the Catmull-Rom slopes of a, b, c, d.
template <class V>
V spline(V a, V b, V c, V d, const Piece& piece, double t) {
  const auto [before, span, after, begins_still, ends_still] = piece;
  V slope_b = (before > 0 ? (c - a) / (before + span) : (c - b) / span) * span;
  V slope_c = (after > 0 ? (d - b) / (span + after) : (c - b) / span) * span;
  if (begins_still) slope_b *= 0.0;
  if (ends_still) slope_c *= 0.0;
  const double u = t / span, u2 = u * u, u3 = u2 * u;
  return b * (2 * u3 - 3 * u2 + 1) + slope_b * (u3 - 2 * u2 + u) + c * (3 * u2 - 2 * u3) +
         slope_c * (u3 - u2);
}

glm::dvec4 as_vector(glm::dquat q) { return {q.x, q.y, q.z, q.w}; }

// View depth at which the transmittance of a pixel falls to one half. `frame` has a trace. Empty if
// the pixel is outside the image or stays more transparent.
std::optional<double> pixel_depth(const Frame& frame, const Camera& camera, glm::ivec2 pixel) {
  const Trace& trace = frame.trace;
  const int x = pixel.x, y = pixel.y;
  if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) return std::nullopt;
  const auto tile = static_cast<std::size_t>(frame.grid.tile_of(x, y));
  double transmittance = 1;
  for (std::uint64_t i = trace.tile_begin[tile]; i < trace.tile_begin[tile + 1]; ++i) {
    const auto found =
        std::ranges::lower_bound(trace.gaussians, trace.listed[static_cast<std::size_t>(i)]);
    const auto slot = static_cast<std::size_t>(found - trace.gaussians.begin());
    const Footprint& footprint = trace.footprints[slot];
    const double dx = x - static_cast<double>(footprint.mean_px.x);
    const double dy = y - static_cast<double>(footprint.mean_px.y);
    const double squared = static_cast<double>(footprint.conic.x) * dx * dx +
                           2 * static_cast<double>(footprint.conic.y) * dx * dy +
                           static_cast<double>(footprint.conic.z) * dy * dy;
    // gamma = 2 ln(255 opacity), so this is 255 alpha before its cap.
    const double alpha_255 = std::exp(0.5 * (static_cast<double>(footprint.gamma) - squared));
    if (alpha_255 < 1) continue;
    transmittance *= 1 - std::min(0.99, alpha_255 / 255);
    if (transmittance <= 0.5) return static_cast<double>(trace.depths[slot]);
  }
  return std::nullopt;
}

[[noreturn]] void fail_to_be_a_path(const std::string& name) {
  fail("{}: is not a camera path: a list of at least two cameras", name);
}

// The camera turned so that it looks along a ray of its view axes, which is at its middle pixel.
Camera aimed(Camera camera, const glm::dvec3& ray) {
  const glm::dvec3 forward = glm::normalize(ray);
  const glm::dvec3 down = std::abs(forward.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 right = glm::normalize(glm::cross(down, forward));
  const glm::dmat3 turn = glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  camera.view_from_world = turn * camera.view_from_world;
  camera.center_px = glm::dvec2(center_pixel(camera));
  return camera;
}

}  // namespace

std::vector<Keyframe> read_camera_path(const std::filesystem::path& path) {
  std::vector<Keyframe> keyframes =
      parse_camera_path(read_text_file(path, std::size_t{64} << 20), path.string());
  if (keyframes.size() < 2) fail_to_be_a_path(path.string());
  return keyframes;
}

std::vector<Keyframe> parse_camera_path(const std::string& text, const std::string& name) {
  const bool is_json = json_kind(text) != JsonKind::none;
  const nlohmann::json json = is_json ? parse_json(text, name) : nlohmann::json();
  if (!json.is_array()) fail_to_be_a_path(name);
  std::vector<Keyframe> keyframes;
  for (const nlohmann::json& entry : json) {
    const std::string where = fmt::format("{}: keyframe {}", name, keyframes.size());
    const Camera camera = camera_of(entry, where);
    const double fallback = keyframes.empty() ? 0 : keyframes.back().time + 1;
    const bool timed = entry.contains("time");
    if (timed && !entry["time"].is_number()) fail("{}: time is not a number", where);
    const double time = timed ? entry["time"].get<double>() : fallback;
    if (!keyframes.empty() && !(time > keyframes.back().time))
      fail("{}: its time {} is not after the one before", where, time);
    const bool marked = entry.contains("ease");
    if (marked && !entry["ease"].is_boolean()) fail("{}: ease is neither true nor false", where);
    keyframes.push_back({time, camera, marked && entry["ease"].get<bool>()});
  }
  return keyframes;
}

std::string format_camera_path(const std::vector<Keyframe>& keyframes) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Keyframe& keyframe : keyframes) {
    list.push_back(camera_json(keyframe.camera));
    list.back()["time"] = keyframe.time;
    if (keyframe.eases) list.back()["ease"] = true;
  }
  // By these words the program recognises its own files (io/bytes/file_guard.h).
  if (!list.empty()) list.front()["written_by"] = "quadsplat";
  return json_file_text(list);
}

Camera camera_at(const std::vector<Keyframe>& keyframes, double time) {
  const std::size_t last = keyframes.size() - 1;
  const double clamped = std::clamp(time, keyframes.front().time, keyframes.back().time);
  std::size_t k = 0;
  while (k + 2 < keyframes.size() && keyframes[k + 1].time <= clamped) ++k;
  const std::size_t places[4] = {k == 0 ? 0 : k - 1, k, k + 1, std::min(k + 2, last)};
  const Camera& first = keyframes.front().camera;
  Pose p[4];
  for (int i = 0; i < 4; ++i)
    p[i] = pose_of(keyframes[places[i]].camera.resized(first.width, first.height));
  // q and -q are the same rotation; the spline needs the sign that is nearer to its neighbour.
  for (int i = 1; i < 4; ++i)
    if (glm::dot(p[i].rotation, p[i - 1].rotation) < 0) p[i].rotation = -p[i].rotation;
  const auto at = [&](std::size_t i) { return keyframes[places[i]].time; };
  const Piece piece{at(1) - at(0), at(2) - at(1), at(3) - at(2), keyframes[places[1]].eases,
                    keyframes[places[2]].eases};
  const auto through = [&](const auto& value) {
    return spline(std::invoke(value, p[0]), std::invoke(value, p[1]), std::invoke(value, p[2]),
                  std::invoke(value, p[3]), piece, clamped - at(1));
  };
  const glm::dvec3 position = through(&Pose::position);
  const glm::dvec4 q =
      glm::normalize(through([](const Pose& pose) { return as_vector(pose.rotation); }));
  Camera camera = first;
  camera.name.clear();
  camera.focal_px = glm::exp(through(&Pose::log_focal));
  camera.center_px = through(&Pose::center);
  const glm::dmat3 rotation = glm::transpose(glm::mat3_cast(glm::dquat(q.w, q.x, q.y, q.z)));
  camera.view_from_world =
      glm::dmat4x3(rotation[0], rotation[1], rotation[2], -(rotation * position));
  return camera;
}

double closed_length(const std::vector<Keyframe>& keyframes) {
  const double length = keyframes.back().time - keyframes.front().time;
  return length + length / static_cast<double>(keyframes.size() - 1);
}

std::vector<Keyframe> closed_path(const std::vector<Keyframe>& keyframes) {
  const double length = closed_length(keyframes);
  const auto shifted = [](Keyframe keyframe, double seconds) {
    keyframe.time += seconds;
    return keyframe;
  };
  std::vector<Keyframe> closed = {shifted(keyframes.back(), -length)};
  closed.insert(closed.end(), keyframes.begin(), keyframes.end());
  closed.push_back(shifted(keyframes[0], length));
  closed.push_back(shifted(keyframes[1], length));
  // camera_at() takes the size and the near plane of the first keyframe.
  const Camera& first = keyframes.front().camera;
  closed.front().camera = closed.front().camera.resized(first.width, first.height);
  closed.front().camera.near_depth = first.near_depth;
  return closed;
}

std::vector<Camera> sample_path(const std::vector<Keyframe>& keyframes, int count) {
  const double begin = keyframes.front().time, length = keyframes.back().time - begin;
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i)
    cameras.push_back(camera_at(keyframes, count == 1 ? begin : begin + length * i / (count - 1)));
  return cameras;
}

std::vector<Camera> zoom_path(const Camera& start, glm::dvec3 target, int steps, double closest) {
  std::vector<Camera> cameras;
  for (int step = 0; step < steps; ++step)
    cameras.push_back(zoom_camera(start, target, steps, closest, step));
  return cameras;
}

Camera zoom_camera(const Camera& start, glm::dvec3 target, int steps, double closest, int step) {
  assert(steps >= 2 && closest > 0);
  if (step == 0) return start;
  const double distance = std::pow(closest, static_cast<double>(step) / (steps - 1));
  return moved_to(start, target + distance * (start.position() - target));
}

glm::ivec2 center_pixel(const Camera& camera) { return {camera.width / 2, camera.height / 2}; }

std::optional<glm::dvec3> find_point(Renderer& renderer, const Camera& camera,
                                     RenderSettings settings, glm::ivec2 pixel) {
  settings.mode = default_mode();
  settings.style = DrawStyle::splats;  // points leave gaps
  const std::shared_ptr<const LensView> lens = settings.lens;
  if (has_faces(lens)) {
    const auto ray = lens->sized({camera.width, camera.height}).direction(pixel);
    if (!ray) return std::nullopt;
    settings.lens.reset();
    return find_point(renderer, aimed(camera, *ray), settings, center_pixel(camera));
  }
  const std::optional<double> depth = pixel_depth(
      renderer.render(camera, settings, {.color = false, .trace = true}), camera, pixel);
  if (!depth) return std::nullopt;
  glm::dvec2 at(pixel);
  if (lens) {  // the pixel of a pinhole camera that shows the point
    const glm::dvec2 middle = 0.5 * glm::dvec2(camera.width - 1, camera.height - 1);
    at = camera.center_px +
         (at - middle) * camera.focal_px * lens->height / (camera.height * *depth);
  }
  return point_at(camera, at, *depth);
}

}  // namespace qs
