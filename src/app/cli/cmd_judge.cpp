// SPDX-License-Identifier: MIT
//
// quadsplat judge: pictures of many views against the true pictures -> PSNR, SSIM and FLIP per
// view.
#include <memory>

#include "app/cli/command.h"
#include "app/cli/judging.h"

namespace qs {

CommandAction judge_command(Options& options) {
  const auto judge = std::make_shared<JudgeOptions>();
  options.positional("TRUTH", judge->frame.scene, "folder of pictures, splat file or model folder",
                     {"images", "scene.ply"});
  options.positional("JUDGED", judge->judged, "folder of pictures, splat file or model folder",
                     {"scene.ply", "images"});
  declare_common_options(options, judge->frame);
  declare_camera_choice(options, judge->cameras);
  declare_judge_options(options, *judge);
  options.overwrite();
  options.example("quadsplat judge photographs/ renders/ --out-dir out",
                  "pictures with equal names, the worst first");
  options.example("quadsplat judge renders/ plush.spz",
                  "another program's pictures, named as the cameras, against this one's");
  return [judge](Arguments) {
    run_judging(*judge);
    return kExitOk;
  };
}

}  // namespace qs
