// SPDX-License-Identifier: MIT
//
// quadsplat inspect: a pixel's Gaussians, and one of them under the magnifier.
#include <cstdio>

#include <nlohmann/json.hpp>

#include "app/cli/command.h"
#include "app/cli/view_choice.h"
#include "app/inspect/construction.h"
#include "app/inspect/inspection_text.h"
#include "app/measure/scene_facts.h"
#include "app/session/frame_metadata.h"
#include "io/picture/image_file.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

struct InspectCommand {
  FrameOptions frame;
  CameraChoice cameras;
  std::optional<glm::ivec2> pixel;
  std::optional<std::uint32_t> gaussian;
  std::optional<std::filesystem::path> picture;
  bool json = false;
};

glm::ivec2 parse_pixel(const std::string& text) {
  const std::vector<std::string> words = separated(text);
  if (words.size() != 2) fail(ErrorKind::usage, "--pixel: '{}' is not X,Y", text);
  return {parse_integer("--pixel", words[0], 0, 1'000'000),
          parse_integer("--pixel", words[1], 0, 1'000'000)};
}

bool parse(InspectCommand& command, Arguments arguments) {
  Options options("inspect", "shows which Gaussians make a pixel, and how the modes cover one");
  declare_frame_options(options, command.frame);
  declare_camera_choice(options, command.cameras);
  options.value("--pixel", "X,Y",
                "counted from the top left (default: the middle of --gaussian or of the picture)",
                [&](const std::string& text) { command.pixel = parse_pixel(text); });
  options.integer("--gaussian", "N", 0, 2'147'483'647, command.gaussian,
                  "the one to pick (default: the pixel's heaviest)");
  options.flag("--json", command.json, "everything as JSON on stdout, instead of tables");
  options.text("--picture", "FILE", command.picture,
               "draws ellipse, boxes and every mode's tiles to scale");
  options.example("quadsplat inspect plush.spz --camera-index 0 --pixel 800,600 --picture why.png",
                  "what is seen in the middle, and the construction of its heaviest Gaussian");
  if (!options.parse(arguments)) return false;
  if (command.cameras.several() || command.frame.modes.size() > 1) {
    fail(ErrorKind::usage, "inspect: it looks at one picture: choose one camera and one mode");
  }
  if (command.frame.modes.front() == kReferenceMode) {
    fail(ErrorKind::usage, "inspect: mode reference has no tiles: choose another one");
  }
  return true;
}

/// The middle of the Gaussian where the picture shows it, else of the picture.
glm::ivec2 default_pixel(const Frame& frame, glm::ivec2 size,
                         const std::optional<std::uint32_t>& gaussian) {
  const auto slot = gaussian ? slot_of(frame.trace, *gaussian) : std::nullopt;
  if (!slot) return size / 2;
  const glm::vec2 mean = frame.trace.footprints[*slot].mean_px;
  return {clamp_to_int(mean.x + 0.5f, size.x - 1), clamp_to_int(mean.y + 0.5f, size.y - 1)};
}

}  // namespace

int run_inspect(Arguments arguments) {
  InspectCommand command;
  if (!parse(command, arguments)) return kExitOk;
  Session session = open_session(command.frame);
  const Shot shot = choose_shots(command.cameras, command.frame, *session.scene).front();
  const Frame& frame =
      session.renderer->render(shot.camera, session.settings, inspection_outputs());
  const glm::ivec2 size(shot.camera.width, shot.camera.height);
  const glm::ivec2 pixel =
      command.pixel ? *command.pixel : default_pixel(frame, size, command.gaussian);
  const Inspection inspection =
      inspect(frame, size, pixel, session.settings.background, command.gaussian);
  const char* mode = mode_name(session.settings.mode);
  if (command.json) {
    nlohmann::ordered_json json = inspection_json(inspection);
    json["mode"] = mode;
    json["tile_px"] = frame.grid.tile_px;
    json["tile_columns"] = frame.grid.columns;
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{}, {} x {}, mode {}\n{}", shot.origin, size.x, size.y, mode,
               format_inspection(inspection));
  }
  if (!command.picture) return kExitOk;
  if (!inspection.gaussian) {
    fail("inspect: pixel {},{} shows no Gaussian, so there is none to draw: choose another pixel",
         pixel.x, pixel.y);
  }
  const std::string where =
      fmt::format("{} \u00b7 {}", scene_name(session.scene->path), shot.origin);
  write_image(draw_construction({inspection, frame.color, frame.grid, where}), *command.picture,
              frame_metadata(session.scene->path, shot.camera, session.settings.mode, frame.stats));
  fmt::print(stderr, "wrote {}\n", command.picture->string());
  return kExitOk;
}

}  // namespace qs
