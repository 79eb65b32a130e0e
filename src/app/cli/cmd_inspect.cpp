// SPDX-License-Identifier: MIT
//
// quadsplat inspect: the Gaussians of a pixel, and the tiles that each mode lists for one of them.
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "app/cli/camera_choice.h"
#include "app/cli/command.h"
#include "app/inspect/construction.h"
#include "app/inspect/inspection.h"
#include "app/measure/scene_facts.h"
#include "app/session/alterations.h"
#include "app/session/shot.h"
#include "base/fail.h"
#include "io/bytes/json_text.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

struct InspectCommand {
  FrameOptions frame;
  CameraChoice cameras;
  std::optional<glm::ivec2> pixel;
  std::optional<std::uint32_t> gaussian;
  std::optional<std::filesystem::path> output, json;
};

// The pixel at the Gaussian's mean if the Gaussian is visible, else the middle of the picture.
glm::ivec2 default_pixel(const Frame& frame, glm::ivec2 size,
                         const std::optional<std::uint32_t>& gaussian) {
  const auto slot = gaussian ? slot_of(frame.trace, *gaussian) : std::nullopt;
  if (!slot) return size / 2;
  const glm::vec2 mean = frame.trace.footprints[*slot].mean_px;
  return {clamp_to_int(mean.x + 0.5f, size.x - 1), clamp_to_int(mean.y + 0.5f, size.y - 1)};
}

int run(const InspectCommand& command) {
  require_one_picture("inspect", command.cameras, command.frame);
  note_inputs(command.frame);
  check_targets({command.output, command.json});
  if (command.output) check_picture_name(*command.output);
  Session session = open_session(command.frame);
  const Shot shot = choose_shots(command.cameras, command.frame, session).front();
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
    write_text(*command.json, json_file_text(json));
  }
  if (command.json != "-")
    fmt::print("{}, {} x {}, mode {}{}\n{}", shot.origin, size.x, size.y, mode,
               altered_clause(session), format_inspection(inspection));
  if (!command.output) return kExitOk;
  if (!inspection.gaussian)
    fail("inspect: pixel {},{} shows no Gaussian to draw: choose another pixel", pixel.x, pixel.y);
  write_image(draw_construction({inspection, frame.color, frame.grid,
                                 picture_title(session.scene->path, shot.origin)}),
              *command.output,
              frame_metadata(session, shot.camera, session.settings.mode, frame.stats));
  fmt::print(stderr, "wrote {}\n", command.output->string());
  return kExitOk;
}

}  // namespace

CommandAction inspect_command(Options& options) {
  const auto command = std::make_shared<InspectCommand>();
  declare_frame_options(options, command->frame);
  declare_camera_choice(options, command->cameras);
  options.converted(
      "--pixel", "X,Y", command->pixel, parse_pixel,
      "counted from the top left (default: the centre of --gaussian, else of the picture)",
      {"0,0", "24,16", "47,31", "48,0"});
  options.integer("--gaussian", "N", 0, 2'147'483'647, command->gaussian,
                  "the Gaussian to explain (default: the one that contributes most to the pixel)");
  options.overwrite();
  options.text("--json", "FILE", command->json,
               "everything as JSON; - = stdout, instead of the tables", {"why.json"});
  options.text("--output", "FILE", command->output,
               "draws the ellipse, its boxes and the tiles of every mode to scale", {"why.png"});
  options.example("quadsplat inspect plush.spz --camera-index 0 --pixel 800,600 --output why.png",
                  "what a pixel shows, and the construction of its heaviest Gaussian");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
