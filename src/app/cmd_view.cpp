// SPDX-License-Identifier: MIT
#include <filesystem>
#include <system_error>

#include "app/command.h"
#include "app/options.h"
#include "raster/scene/fail.h"

namespace qs {

int run_view(Arguments arguments) {
  std::filesystem::path scene;
  Options options("view", "opens a scene in a window; the command when none is named");
  options.positional("SCENE", scene, "splat file or model folder");
  options.example("quadsplat garden/", "opens a trained model");
  if (!options.parse(arguments)) return kExitOk;
  std::error_code error;
  if (!std::filesystem::exists(scene, error)) {
    fail(ErrorKind::usage, "'{}' is neither a command nor a file (see 'quadsplat --help')",
         scene.string());
  }
  fail(ErrorKind::usage,
       "this build has no viewer; 'quadsplat render {} --output picture.png' renders the scene to "
       "a file",
       scene.string());
}

}  // namespace qs
