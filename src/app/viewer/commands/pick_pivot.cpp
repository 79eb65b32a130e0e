// SPDX-License-Identifier: MIT
//
// Finds the point that a pixel shows, goes to it, and orbits around it from then on.
#include <glm/common.hpp>

#include "app/measure/camera_path.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"

namespace qs {
namespace {

void find_pivot(RenderContext& context, const Viewer& viewer, glm::ivec2 pixel) {
  const FrameRequest request = full_frame(viewer);
  const auto point = find_point(*context.session.renderer, request.camera, request.settings, pixel);
  if (!point) return context.report(action::notify, "nothing is under the cursor");
  context.report(action::frame_point, *point);
}

}  // namespace

void action::pick_pivot(Viewer& viewer, Host& host, glm::dvec2 pixel) {
  if (viewer.scene) start_job(viewer, host, find_pivot, glm::ivec2(glm::floor(pixel)));
}

}  // namespace qs
