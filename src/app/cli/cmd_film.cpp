// SPDX-License-Identifier: MIT
//
// quadsplat film: a camera that circles the scene or moves along a path -> a film.
#include <memory>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/cli/lens_options.h"
#include "app/film/film.h"
#include "app/framing/first_view.h"
#include "app/inspect/heatmap_frame.h"
#include "app/measure/statistics.h"
#include "app/session/alterations.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "base/quit_signals.h"
#include "base/warn.h"

namespace qs {
namespace {

struct FilmCommand {
  FrameOptions frame;
  std::filesystem::path output;
  std::optional<std::filesystem::path> path;
  std::optional<double> seconds, arc;
  std::optional<bool> numbers;
  LensOptions lens;
  Ease ease = Ease::none;
  FilmPlan plan;  // fps and quantity
  HeatOptions heat;
  bool turntable = false, loop = false;
};

CameraTrack choose_track(const FilmCommand& command, const Session& session, glm::ivec2 size) {
  if (!command.path) {
    const Scene& scene = *session.scene;
    const std::vector<Camera> cameras = cameras_of(command.frame, scene);
    const auto up = declared_up(command.frame.up, scene.vertical_axis);
    const Framing framing = subject_framing(
        cameras, up, [&] { return choose_framing(scene.cloud, up, *session.pool); });
    TurntableWish wish{std::nullopt, command.ease, size};
    if (command.arc) wish.arc = arc_of(*command.arc);
    return turntable_of(scene.cloud, cameras, framing, wish, *session.pool);
  }
  std::vector<Keyframe> keyframes = read_camera_path(*command.path);
  for (Keyframe& keyframe : keyframes)
    keyframe.camera = keyframe.camera.placed(session.scene->cloud.origin);
  return along(keyframes, command.ease, command.loop);
}

// Throws Cancelled after Ctrl+C or SIGTERM.
Progress until_signal(const Progress& progress) {
  return {[report = progress.report](float fraction) {
            if (QuitSignals::arrived()) throw Cancelled();
            if (report) report(fraction);
          },
          progress.stop};
}

void check(const FilmCommand& command) {
  check_rules(
      "film",
      {{command.turntable && command.path, "--turntable and --camera-path exclude each other"},
       {command.arc && command.path, "--arc is the angle of a turntable, not of a --camera-path"},
       {command.heat.quantity == HeatQuantity::missed && command.lens.has_faces(), kNoLensHeatmap},
       {command.loop && !command.path,
        "--loop needs a --camera-path; a turntable is a loop already"}});
  require_colors("film", command.heat, command.plan.quantity);
  require_heatmaps("film", command.heat, command.frame.modes);
}

// Sets the scales of the film's colour map and heat maps.
void choose_scales(const FilmCommand& command, const Session& session, FilmPlan& plan,
                   const Progress& progress) {
  plan.scale = film_scale(plan, progress);
  if (!command.heat.quantity) return;
  plan.heatmap = FilmHeatmap{*command.heat.quantity, {}, {}, session.pool.get()};
  plan.heatmap->scale = command.heat.maximum
                            ? exact_scale(static_cast<std::uint32_t>(*command.heat.maximum))
                            : film_heat_scale(plan, kScaleMode, progress);
}

int film(const FilmCommand& command) {
  check(command);
  FilmPlan plan = command.plan;
  plan.size = command.frame.size.value_or(plan.size);
  check_film(command.output, plan.size, plan.fps);  // throws before the scene is read
  Session session = open_session(command.frame);
  set_lens(command.lens, command.frame, session);
  plan.track = choose_track(command, session, plan.size);
  plan.seconds = command.seconds.value_or(plan.track.seconds);
  if (command.lens.is_panorama()) {
    plan.panorama = {command.lens.panorama_degrees() == 180, command.lens.stereo};
    if (!tags_panorama(command.output))
      warn(
          fmt::format("{}: players do not show it as a panorama: only .mp4 and pictures are tagged",
                      command.output.string()));
  }
  plan.altered = alterations_of(session).text;
  plan.altered_brief = alterations_of(session).brief;
  plan.numbers = command.numbers.value_or(command.frame.modes.size() > 1);
  for (const CullMode mode : command.frame.modes) {
    plan.ways.push_back({session.renderer.get(), session.settings, mode_name(mode)});
    plan.ways.back().settings.mode = mode;
  }
  std::vector<FilmedNumbers> numbers;
  {
    ProgressBar bar("choosing the scale");
    choose_scales(command, session, plan, until_signal(bar.progress()));
  }
  {
    ProgressBar bar("filming");
    numbers = write_film(command.output, plan, until_signal(bar.progress()));
  }
  fmt::print(stderr, "wrote {} ({} pictures, {} x {}, {} per second{})\n", command.output.string(),
             plan.frames(), plan.size.x, plan.size.y, plan.fps, altered_clause(session));
  if (plan.quantity != Quantity::color)
    fmt::print(stderr, "{}: colours from {}{}\n", row_of(plan.quantity).name,
               plan.scale.text_of_ends(), row_of(plan.quantity).unit);
  if (plan.heatmap) {
    const HeatmapRow& row = heatmap_row(plan.heatmap->quantity);
    fmt::print(stderr, "heat map {}: colours from 0 to {} per {}\n", row.name,
               counted(plan.heatmap->scale.maximum, row.unit), row.cell);
  }
  if (plan.ways.size() > 1) {
    fmt::print("{:16}{:>16}{:>10}{:>14}\n", "median of mode", "ms", "FPS", "pairs");
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto& [ms, pairs, spread] = numbers[i];
      fmt::print("{:16}{:>16}{:>10}{:>14}\n", plan.ways[i].name, time_text(ms, spread),
                 rate_text(ms, spread), grouped(static_cast<std::uint64_t>(pairs)));
    }
  }
  return kExitOk;
}

}  // namespace

CommandAction film_command(Options& options) {
  const auto command = std::make_shared<FilmCommand>();
  declare_frame_options(options, command->frame);
  declare_level_options(options, command->frame.levels);
  options.text("--output", "FILE", command->output,
               "the film: .mp4, .webm or .gif, which need ffmpeg, or a folder of PNG files",
               {"frames", "film.mp4"});
  options.required();
  options.flag("--turntable", command->turntable,
               "a circle around the subject of the scene (the default without --camera-path)");
  options.real("--arc", "DEGREES", 0, 360, command->arc,
               "angle of the turntable; below 360 the camera swings there and back (default: 360, "
               "or the side that the cameras saw and no wall hides)");
  declare_camera_path_option(options, command->path);
  declare_lens_options(options, command->lens);
  options.real("--seconds", "S", 0.01, 36000, command->seconds,
               "duration (default: 10 for a turntable, else that of the path)", {"0.1", "0.25"});
  declare_quantity_option(
      options, command->plan.quantity,
      "what the film shows (default: color); alpha and depths by a colour map with one scale");
  declare_heatmap_options(options, command->heat,
                          "fits 3dgs in pictures spread over the film, and all modes share it");
  options.real("--fps", "N", 1, 240, command->plan.fps, "pictures per second (default: 30)");
  options.enumerated(
      "--ease", kEaseNames, command->ease,
      "where the camera slows down to a stop: at the ends of the film or at all keyframes "
      "(default: none, or what the path says)");
  options.overwrite();
  options.flag("--loop", command->loop,
               "the path returns to its first camera, so that the film can be repeated");
  options.choice(
      "--numbers", {"on", "off"},
      [command = command.get()](int chosen) { command->numbers = chosen == 0; },
      "shows name, FPS and tile pairs in the picture (default: with several modes)");
  options.example("quadsplat film plush.spz --output plush.mp4", "once round the doll");
  options.example("quadsplat film plush.spz --cull 3dgs,quadbox --output modes.mp4",
                  "two modes side by side with their numbers");
  options.example("quadsplat film plush.spz --cull 3dgs,quadbox --heatmap pairs --output pairs.mp4",
                  "where both modes list tile pairs, in colours of one scale");
  options.example(
      "quadsplat film garden/ --camera-path path.json --loop --size 1920x1080 --output g.webm",
      "along the keyframes and back to the first one");
  return [command](Arguments) {
    check_lens("film", command->lens, command->frame);
    return film(*command);
  };
}

}  // namespace qs
