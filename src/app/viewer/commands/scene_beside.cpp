// SPDX-License-Identifier: MIT
//
// Opens and closes the second scene, which a split window shows beside the first.
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/render_context.h"

namespace qs {

void action::toggle_beside(Viewer& viewer, Host& host) {
  if (!viewer.beside) return toggle_open_dialog(viewer, Choosing::scene_beside);
  viewer.beside.reset();
  viewer.panels.split = false;
  picture_changed(viewer);
  host.run([](RenderContext& context) { context.beside.reset(); });
}

}  // namespace qs
