// SPDX-License-Identifier: MIT
//
// quadsplat [view]: the window.
#include <system_error>

#include "app/cli/command.h"
#include "app/cli/frame_options.h"
#include "app/cli/options.h"
#include "app/viewer/state/preferences.h"
#include "app/viewer/view_loop.h"
#include "raster/base/fail.h"

namespace qs {

int run_view(Arguments arguments) {
  ViewOptions view;
  std::vector<std::filesystem::path> scenes;
  std::optional<std::filesystem::path> settings;
  bool no_vsync = false, no_interop = false;
  Options options("view", "opens a scene in a window; the command when none is named");
  options.optional_positional("SCENE", scenes, "splat file or model folder");
  declare_common_options(options, view.frame);
  options.text(
      "--beside", "NAME", view.beside,
      "splits the window, beside it: a culling mode, reference, or \"exact, cuda classic\"");
  options.flag("--no-vsync", no_vsync, "does not wait for the display");
  options.flag("--no-interop", no_interop, "CUDA frames pass the host on their way to the window");
  options.text("--settings", "FILE", settings,
               "where the window's settings are kept (default: in ~/.config); - = nowhere");
  options.text("--input", "FILE", view.script, "plays an input script, see docs/viewer.md");
  options.text("--out-dir", "DIR", view.out_dir,
               "screenshots, zooms and benches go below it (default: this folder)");
  options.example("quadsplat garden/", "opens a trained model");
  options.example("quadsplat view plush.spz --cameras cameras.json --cull exact --size 1600x1200",
                  "with its cameras, in another mode");
  if (!options.parse(arguments)) return kExitOk;
  if (!scenes.empty()) {
    std::error_code error;
    if (!std::filesystem::exists(scenes.front(), error)) {
      fail(ErrorKind::usage, "'{}' is neither a command nor a file (see 'quadsplat --help')",
           scenes.front().string());
    }
    if (scenes.size() > 1) fail(ErrorKind::usage, "view: one scene at a time");
    view.frame.scene = scenes.front();
  }
  if (view.frame.tile_px != kTileSize) {
    fail(ErrorKind::usage, "view: --tile-size {}: the window draws tiles of {} pixels only",
         view.frame.tile_px, kTileSize);
  }
  view.vsync = !no_vsync;
  view.interop = !no_interop;
  if (settings != "-") view.settings = settings.value_or(preferences_file());
  run_viewer(view);
  return kExitOk;
}

}  // namespace qs
