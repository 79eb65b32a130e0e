// SPDX-License-Identifier: MIT
#include "app/measure/camera_path.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"

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

// q and -q are the same rotation; the spline needs the sign that is nearer to its neighbour.
glm::dquat near(glm::dquat rotation, glm::dquat neighbour) {
  return glm::dot(rotation, neighbour) < 0 ? -rotation : rotation;
}

glm::dvec4 as_vector(glm::dquat q) { return {q.x, q.y, q.z, q.w}; }

}  // namespace

std::vector<Keyframe> read_camera_path(const std::filesystem::path& path) {
  const std::string text = read_text_file(path, std::size_t{64} << 20);
  const bool is_json = json_kind(text) != JsonKind::none;
  const nlohmann::json json = is_json ? parse_json(text, path.string()) : nlohmann::json();
  if (!json.is_array() || json.size() < 2) {
    fail("{}: is not a camera path: a list of at least two cameras", path.string());
  }
  std::vector<Keyframe> keyframes;
  for (const nlohmann::json& entry : json) {
    const std::string where = fmt::format("{}: keyframe {}", path.string(), keyframes.size());
    const Camera camera = camera_of(entry, where);
    const double fallback = keyframes.empty() ? 0 : keyframes.back().time + 1;
    const bool timed = entry.contains("time");
    if (timed && !entry["time"].is_number()) fail("{}: time is not a number", where);
    const double time = timed ? entry["time"].get<double>() : fallback;
    if (!keyframes.empty() && !(time > keyframes.back().time)) {
      fail("{}: its time {} is not after the one before", where, time);
    }
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
  for (int i = 1; i < 4; ++i) p[i].rotation = near(p[i].rotation, p[i - 1].rotation);
  const auto at = [&](std::size_t i) { return keyframes[places[i]].time; };
  const Piece piece{at(1) - at(0), at(2) - at(1), at(3) - at(2), keyframes[places[1]].eases,
                    keyframes[places[2]].eases};
  const auto through = [&](auto a, auto b, auto c, auto d) {
    return spline(a, b, c, d, piece, clamped - at(1));
  };
  const glm::dvec3 position = through(p[0].position, p[1].position, p[2].position, p[3].position);
  const glm::dvec4 q = glm::normalize(through(as_vector(p[0].rotation), as_vector(p[1].rotation),
                                              as_vector(p[2].rotation), as_vector(p[3].rotation)));
  Camera camera = first;
  camera.name.clear();
  camera.focal_px =
      glm::exp(through(p[0].log_focal, p[1].log_focal, p[2].log_focal, p[3].log_focal));
  camera.center_px = through(p[0].center, p[1].center, p[2].center, p[3].center);
  const glm::dmat3 rotation = glm::transpose(glm::mat3_cast(glm::dquat(q.w, q.x, q.y, q.z)));
  camera.view_from_world =
      glm::dmat4x3(rotation[0], rotation[1], rotation[2], -(rotation * position));
  return camera;
}

double closed_length(const std::vector<Keyframe>& keyframes) {
  const double length = keyframes.back().time - keyframes.front().time;
  const auto intervals = static_cast<double>(keyframes.size() - 1);
  return length + length / intervals;
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

}  // namespace qs
