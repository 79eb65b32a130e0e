// SPDX-License-Identifier: MIT
//
// quadsplat [view]: the window.
#include <memory>
#include <system_error>

#include "app/cli/command.h"
#include "app/cli/shared_options.h"
#include "app/cli/shown_run.h"
#include "app/remote/tcp.h"
#include "app/viewer/view_options.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "io/camera/cameras.h"
#include "options/suggestion.h"

namespace qs {
namespace {

struct ViewCommand {
  ViewOptions view;
  std::vector<std::filesystem::path> scenes;
  std::optional<std::string> connect;
  bool no_vsync = false, no_interop = false;
};

// --beside names a variant, or else the file of a scene.
void take_scene_beside(ViewOptions& view) {
  if (!view.beside || find_variant(*view.beside, {})) return;
  if (!is_there(*view.beside))
    fail(ErrorKind::usage, "view: --beside: '{}' is neither a mode nor a file{}", *view.beside,
         suggestion(*view.beside, mode_list()));
  if (view.frame.scene.empty())
    fail(ErrorKind::usage, "view: --beside {}: name the scene to show it beside", *view.beside);
  view.beside_scene = *view.beside;
  view.beside.reset();
}

// A window that shows a training in another program.
void connect(ViewCommand& command) {
  ViewOptions& view = command.view;
  const std::string shows = "--connect shows a training in another program: leave out ";
  check_rules("view", {{!command.scenes.empty(), shows + "SCENE"},
                       {view.beside.has_value(), shows + "--beside"}});
  view.connect = resolve(*command.connect, "view: --connect");
  if (view.frame.cameras) {
    const CameraSet set = read_camera_set(*view.frame.cameras);
    for (const std::string& sentence : set.pinhole_sentences()) warn(sentence);
    view.remote_cameras = pinhole_cameras(set.cameras);
  }
}

int run(ViewCommand& command) {
  ViewOptions& view = command.view;
  if (command.connect) connect(command);
  if (!command.scenes.empty()) {
    view.frame.scene = command.scenes.front();
    if (!is_there(view.frame.scene))
      fail(ErrorKind::usage, "'{}' is neither a command nor a file (see 'quadsplat --help')",
           view.frame.scene.string());
    if (command.scenes.size() > 1)
      fail(ErrorKind::usage, "view: the window shows one scene: name only one");
  }
  if (view.frame.settings.tile_px != kTileSize)
    fail(ErrorKind::usage, "view: --tile-size {}: the window draws tiles of {} pixels only",
         view.frame.settings.tile_px, kTileSize);
  take_scene_beside(view);
  view.vsync = !command.no_vsync;
  view.interop = !command.no_interop;
  view.train_request = train_request_in_window;
  run_viewer(view);
  return kExitOk;
}

}  // namespace

CommandAction view_command(Options& options) {
  const auto command = std::make_shared<ViewCommand>();
  ViewOptions& view = command->view;
  view.frame.modes.clear();  // without --cull the mode of the last run
  options.positionals("SCENE", command->scenes, 0, kSceneHelp, kSceneSamples);
  declare_common_options(options, view.frame);
  declare_level_options(options, view.frame.levels, true);
  options.text("--beside", "NAME", view.beside,
               "splits the window and draws this beside the scene: a culling mode, reference, for "
               "example \"exact, cuda classic\", or another scene's file",
               {"3dgs", "reference"});
  options.text("--connect", "HOST:PORT", command->connect,
               "shows a running training of the 3DGS code or of a descendant instead of a scene; "
               "--cameras names the cameras of its data",
               {"127.0.0.1:1", "nowhere"});
  options.flag("--no-vsync", command->no_vsync, "draws without waiting for the display's refresh");
  options.flag("--no-interop", command->no_interop,
               "copies CUDA frames to the window through the host");
  declare_window_options(options, view);
  options.text("--out-dir", "DIR", view.out_dir,
               "folder of screenshots, zooms and benches (default: the current folder)", {"out"});
  options.example("quadsplat garden/", "opens a trained model");
  options.example("quadsplat view --connect localhost:6009",
                  "a training that runs on this machine, or beyond ssh -L 6009:127.0.0.1:6009");
  options.example("quadsplat view plush.spz --cameras cameras.json --cull exact --size 1600x1200",
                  "starts with its cameras, in another culling mode");
  return [command](Arguments) { return run(*command); };
}

}  // namespace qs
