// SPDX-License-Identifier: MIT
//
// quadsplat measure: points of surfaces under pixels, and the distances and angles between them.
#include <array>
#include <cstdio>
#include <iterator>
#include <memory>
#include <span>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/framing/first_view.h"
#include "app/session/alterations.h"
#include "app/session/scene_edits.h"
#include "app/session/shot.h"
#include "base/fail.h"
#include "base/json_of.h"
#include "base/warn.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"
#include "raster/select/measures.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

struct MeasureCommand {
  FrameOptions frame;
  CameraChoice cameras;
  std::vector<glm::ivec2> pixels;
  std::optional<double> known;
  std::string unit;
  bool levels = false;
  std::optional<std::filesystem::path> json, measures;
};

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
    if (!up_ && !cameras.empty()) up_ = cameras_up(cameras, glm::dvec3(0, -1, 0));
    if (command.measures) use_file(*command.measures);
    if (command.known) find_scale(*command.known);
    if (command.levels) find_level();
  }

  ordered_json json() const {
    ordered_json json = {{"view", view_}, {"unit", scale_.name()}};
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const auto& point = points_[i];
      json["points"].push_back({{"pixel", {command_.pixels[i].x, command_.pixels[i].y}}});
      ordered_json& entry = json["points"].back();
      if (!point) continue;
      entry["position"] = json_of(place(*point));
      entry["distance"] = scale_.factor * point->distance;
      entry["along"] = scale_.factor * point->along;
      entry["across"] = scale_.factor * point->across;
      entry["soft"] = point->is_soft();
    }
    json["distances"] = ordered_json::array();
    json["angles"] = ordered_json::array();
    each_line([&](std::span<const SurfacePoint> line, std::size_t first) {
      for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const auto [length, offset] = measured_leg(line[i], line[i + 1], scale_);
        json["distances"].push_back({{"from", first + i},
                                     {"to", first + i + 1},
                                     {"length", length.length},
                                     {"error", length.error},
                                     {"offset", json_of(offset)}});
        if (up_) json["distances"].back()["height"] = glm::dot(offset, *up_);
      }
      for (std::size_t i = 1; i + 1 < line.size(); ++i)
        json["angles"].push_back(
            {{"at", first + i}, {"degrees", degrees_at(line[i - 1], line[i], line[i + 1])}});
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
      text += fmt::format(
          "({:.6g}, {:.6g}, {:.6g}), {} away{}\n", at.x, at.y, at.z,
          length_text(scale_.factor * point.distance, scale_.factor * point.along, scale_.name()),
          point.is_soft() ? ", a soft surface" : "");
    }
    each_line([&](std::span<const SurfacePoint> line, std::size_t first) {
      for (const MeasureRow& row : measure_rows(line, first + 1, scale_, up_))
        text += fmt::format("{}: {}{}\n", row.name, row.value,
                            row.more.empty() ? "" : " (" + row.more + ")");
    });
    for (const ordered_json& step : steps_)
      text += fmt::format("for a file of edits: {}\n", json_line(step));
    return text;
  }

 private:
  glm::dvec3 place(const SurfacePoint& point) const {
    return scale_.factor * (point.position + session_.scene->cloud.origin);
  }

  const SurfacePoint& required(std::size_t i, const char* option) const {
    if (i >= points_.size()) fail(ErrorKind::usage, "measure: {}: needs {} points", option, i + 1);
    if (!points_[i])
      fail("measure: {}: pixel {},{} shows no surface", option, command_.pixels[i].x,
           command_.pixels[i].y);
    return *points_[i];
  }

  void use_file(const std::filesystem::path& path) {
    const MeasuresFile file = measures_of(*session_.scene, path);
    for (const std::string& sentence : file.warnings) warn("warning: " + sentence);
    scale_ = file.measures.scale;
    if (file.measures.ground) up_ = file.measures.ground->up;
  }

  void find_scale(double known) {
    const auto scale =
        scale_of(required(0, "--known"), required(1, "--known"), known, command_.unit);
    if (!scale) fail(ErrorKind::usage, "measure: --known: both points are the same");
    scale_ = *scale;
    steps_.push_back({{"step", "scale"}, {"factor", scale_.factor}});
    if (!command_.unit.empty()) steps_.back()["unit"] = command_.unit;
  }

  void find_level() {
    required(2, "--level");
    const std::array<SurfacePoint, 3> corners{required(0, "--level"), required(1, "--level"),
                                              *points_[2]};
    const auto ground = ground_through(corners);
    if (!ground) fail(ErrorKind::usage, "measure: --level: the points lie on a line");
    const double error = degrees_of_tilt_error(corners);
    if (error > 3)
      warn(fmt::format(
          "warning: --level: the ground is uncertain by {:.2g} degrees; points that are "
          "farther from one line are better",
          error));
    const glm::dquat turn = level_turn(ground->up);
    steps_.push_back({{"step", "level"}, {"rotation", {turn.x, turn.y, turn.z, turn.w}}});
  }

  // each(line, first) for the points without a gap; `first` is the index of the first point.
  template <class Each>
  void each_line(const Each& each) const {
    std::vector<SurfacePoint> line;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (points_[i]) line.push_back(*points_[i]);
      if (points_[i] && i + 1 < points_.size() && points_[i + 1]) continue;
      each(std::span<const SurfacePoint>(line), i + 1 - line.size());
      line.clear();
    }
  }

  const MeasureCommand& command_;
  Session session_;
  std::string view_;
  std::vector<std::optional<SurfacePoint>> points_;
  std::optional<glm::dvec3> up_;
  MeasureScale scale_;
  std::vector<ordered_json> steps_;
};

int run(const MeasureCommand& command) {
  require_one_picture("measure", command.cameras, command.frame);
  check_rules("measure", {{!command.unit.empty() && !command.known, "--unit: needs --known"},
                          {command.known && command.measures,
                           "--known and --measures both give the scale: choose one"}});
  note_inputs(command.frame);
  if (command.measures) note_input(*command.measures);
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
  options.named("--unit", {std::begin(kLengthUnits), std::end(kLengthUnits)}, command->unit,
                "unit of --known (default: units)");
  options.text("--measures", "FILE", command->measures,
               "lengths in the scale of this file of measures, and heights above its ground",
               {"scene.measures.json"});
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
