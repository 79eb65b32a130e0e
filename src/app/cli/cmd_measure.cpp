// SPDX-License-Identifier: MIT
//
// quadsplat measure: points of surfaces under pixels, and the distances and angles between them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtx/quaternion.hpp>
#include <nlohmann/json.hpp>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/framing/first_view.h"
#include "app/session/alterations.h"
#include "app/session/shot.h"
#include "base/fail.h"
#include "base/json_of.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"
#include "raster/select/surface.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr double kSnapDegrees = 3;  // of an axis
const glm::dvec3 kUp(0, -1, 0);     // of a level scene

struct MeasureCommand {
  FrameOptions frame;
  CameraChoice cameras;
  std::vector<glm::ivec2> pixels;
  std::optional<double> known;
  std::string unit;
  bool levels = false;
  std::optional<std::filesystem::path> json;
};

double degrees_between(glm::dvec3 a, glm::dvec3 b) {
  return glm::degrees(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
}

class Measurement {
 public:
  explicit Measurement(const MeasureCommand& command)
      : command_(command), session_(open_session(command.frame)) {
    const Shot shot = choose_shots(command.cameras, command.frame, session_).front();
    view_ = fmt::format("{}, {} x {}{}", shot.origin, shot.camera.width, shot.camera.height,
                        altered_clause(session_));
    const Frame& frame =
        session_.renderer->render(shot.camera, session_.settings, {.color = false, .trace = true});
    for (const glm::ivec2 pixel : command.pixels) {
      if (pixel.x >= shot.camera.width || pixel.y >= shot.camera.height)
        fail(ErrorKind::usage, "measure: there is no pixel {},{}: the picture is {} x {}", pixel.x,
             pixel.y, shot.camera.width, shot.camera.height);
      points_.push_back(surface_at(frame, session_.scene->cloud, shot.camera, pixel));
    }
    const std::vector<Camera> cameras = cameras_of(command.frame, *session_.scene);
    up_ = declared_up(command.frame.up, session_.scene->vertical_axis);
    if (!up_ && !cameras.empty()) up_ = cameras_up(cameras, kUp);
    if (command.known) find_scale(*command.known);
    if (command.levels) find_level();
  }

  ordered_json json() const {
    ordered_json json = {{"view", view_}, {"unit", unit()}};
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto& point = points_[i];
      json["points"].push_back({{"pixel", {command_.pixels[i].x, command_.pixels[i].y}}});
      ordered_json& entry = json["points"].back();
      if (!point) continue;
      entry["position"] = json_of(place(*point));
      entry["distance"] = scale_ * point->distance;
      entry["along"] = scale_ * point->along;
      entry["across"] = scale_ * point->across;
      entry["soft"] = point->is_soft();
    }
    json["distances"] = ordered_json::array();
    each_pair([&](std::size_t i, const MeasuredLength& length, glm::dvec3 offset) {
      json["distances"].push_back({{"from", i},
                                   {"to", i + 1},
                                   {"length", length.length},
                                   {"error", length.error},
                                   {"offset", json_of(offset)}});
      if (up_) json["distances"].back()["height"] = glm::dot(offset, *up_);
    });
    json["angles"] = ordered_json::array();
    each_angle([&](std::size_t i, double degrees) {
      json["angles"].push_back({{"at", i}, {"degrees", degrees}});
    });
    for (const ordered_json& step : steps_) json["steps"].push_back(step);
    return json;
  }

  std::string text() const {
    std::string text = view_ + "\n";
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const glm::ivec2 pixel = command_.pixels[i];
      text += fmt::format("point {} at pixel {},{}: ", i + 1, pixel.x, pixel.y);
      if (!points_[i]) {
        text += "no surface, more than half of the light passes\n";
        continue;
      }
      const SurfacePoint& point = *points_[i];
      const glm::dvec3 at = place(point);
      text += fmt::format("({:.6g}, {:.6g}, {:.6g}), {:.5g} ± {:.2g} {} away{}\n", at.x, at.y, at.z,
                          scale_ * point.distance, scale_ * point.along, unit(),
                          point.is_soft() ? ", a soft surface" : "");
    }
    double total = 0, variance = 0;
    int pairs = 0;
    each_pair([&](std::size_t i, const MeasuredLength& length, glm::dvec3 offset) {
      text += fmt::format("{} to {}: {:.5g} ± {:.2g} {} (x {:.4g}, y {:.4g}, z {:.4g}{})\n", i + 1,
                          i + 2, length.length, length.error, unit(), offset.x, offset.y, offset.z,
                          up_ ? fmt::format("; height {:.4g}", glm::dot(offset, *up_)) : "");
      total += length.length;
      variance += length.error * length.error;
      ++pairs;
    });
    if (pairs > 1)
      text += fmt::format("together: {:.5g} ± {:.2g} {}\n", total, std::sqrt(variance), unit());
    each_angle([&](std::size_t i, double degrees) {
      text += fmt::format("angle at {}: {:.2f} degrees\n", i + 1, degrees);
    });
    for (const ordered_json& step : steps_)
      text += fmt::format("for a file of edits: {}\n", json_line(step));
    return text;
  }

 private:
  // "units" for a scene without a scale.
  std::string unit() const { return command_.unit.empty() ? "units" : command_.unit; }

  glm::dvec3 place(const SurfacePoint& point) const {
    return scale_ * (point.position + session_.scene->cloud.origin);
  }

  const SurfacePoint& required(std::size_t i, const char* option) const {
    if (i >= points_.size()) fail(ErrorKind::usage, "measure: {}: needs {} points", option, i + 1);
    if (!points_[i])
      fail("measure: {}: pixel {},{} shows no surface", option, command_.pixels[i].x,
           command_.pixels[i].y);
    return *points_[i];
  }

  void find_scale(double known) {
    const SurfacePoint &from = required(0, "--known"), &to = required(1, "--known");
    const double length = length_between(from, to).length;
    if (!(length > 0)) fail(ErrorKind::usage, "measure: --known: both points are the same");
    scale_ = known / length;
    steps_.push_back({{"step", "scale"}, {"factor", scale_}});
    if (!command_.unit.empty()) steps_.back()["unit"] = command_.unit;
  }

  // The turn that makes the plane of the first three points level, with its side of the camera up.
  void find_level() {
    required(2, "--level");
    const SurfacePoint &a = required(0, "--level"), &b = required(1, "--level"), &c = *points_[2];
    const glm::dvec3 across = glm::cross(b.position - a.position, c.position - a.position);
    if (!(glm::length(across) > 1e-6 * glm::dot(b.position - a.position, b.position - a.position)))
      fail(ErrorKind::usage, "measure: --level: the points lie on a line");
    glm::dvec3 normal = glm::normalize(across);
    if (glm::dot(normal, a.direction) > 0) normal = -normal;
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 exact(0.0);
      exact[axis] = std::copysign(1.0, normal[axis]);
      if (degrees_between(normal, exact) <= kSnapDegrees) normal = exact;
    }
    const glm::dquat turn = glm::rotation(normal, kUp);
    steps_.push_back({{"step", "level"}, {"rotation", {turn.x, turn.y, turn.z, turn.w}}});
  }

  // each(i, length, offset) of the points i and i + 1, if both pixels show a surface.
  template <class Each>
  void each_pair(const Each& each) const {
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      if (!points_[i] || !points_[i + 1]) continue;
      const MeasuredLength length = length_between(*points_[i], *points_[i + 1]);
      each(i, MeasuredLength{scale_ * length.length, scale_ * length.error},
           place(*points_[i + 1]) - place(*points_[i]));
    }
  }

  template <class Each>
  void each_angle(const Each& each) const {
    for (std::size_t i = 1; i + 1 < points_.size(); ++i)
      if (points_[i - 1] && points_[i] && points_[i + 1])
        each(i, degrees_between(points_[i - 1]->position - points_[i]->position,
                                points_[i + 1]->position - points_[i]->position));
  }

  const MeasureCommand& command_;
  Session session_;
  std::string view_;
  std::vector<std::optional<SurfacePoint>> points_;
  std::optional<glm::dvec3> up_;
  double scale_ = 1;
  std::vector<ordered_json> steps_;
};

int run(const MeasureCommand& command) {
  require_one_picture("measure", command.cameras, command.frame);
  check_rules("measure", {{!command.unit.empty() && !command.known, "--unit: needs --known"}});
  note_inputs(command.frame);
  check_targets({command.json});
  const Measurement measurement(command);
  if (command.json) write_text(*command.json, json_file_text(measurement.json()));
  if (command.json != "-") fmt::print("{}", measurement.text());
  return kExitOk;
}

}  // namespace

CommandAction measure_command(Options& options) {
  const auto command = std::make_shared<MeasureCommand>();
  declare_frame_options(options, command->frame);
  declare_camera_choice(options, command->cameras);
  options.values(
      "--pixels", "X,Y",
      "the points to measure, counted from the top left; distances are between neighbours",
      {"24,16", "0,0"}, [command](const std::vector<std::string>& words) {
        command->pixels.clear();
        for (const std::string& word : words)
          command->pixels.push_back(parse_pixel("--pixels", word));
      });
  options.required();
  options.real("--known", "LENGTH", 1e-9, 1e9, command->known,
               "true distance of the first two points: all lengths are scaled to it, and the step "
               "of a file of edits is printed",
               {"0.3"});
  options.named("--unit", {"m", "cm", "mm", "ft", "in"}, command->unit,
                "unit of --known (default: units)");
  options.flag("--level", command->levels,
               "the first three points are on the ground: prints the step of a file of edits that "
               "makes it level");
  options.overwrite();
  options.text("--json", "FILE", command->json,
               "everything as JSON; - = stdout, instead of the text", {"measures.json"});
  options.example("quadsplat measure plush.spz --pixels 700,900 700,300 --known 30 --unit cm",
                  "the distance of two points, and the scale that makes it 30 cm");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
