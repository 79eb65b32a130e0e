// SPDX-License-Identifier: MIT
//
// The short jobs: what a pixel shows, the change of the backend, and the second scene.
#include "app/viewer/commands/jobs.h"

#include <glm/common.hpp>

#include "app/measure/camera_path.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/render/upload_scene.h"
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

/// `gaussian`: index in the cloud of the Gaussian to draw; unset: the pixel's heaviest Gaussian.
void inspect_view(RenderContext& context, const Viewer& viewer, glm::ivec2 pixel,
                  std::optional<std::uint32_t> gaussian) {
  const FrameRequest request = full_frame(viewer);
  const Frame& frame = context.session.renderer->render(
      request.camera, request.settings, inspection_outputs(), HostImage{}, context.stop);
  const glm::ivec2 size(request.camera.width, request.camera.height);
  context.report(action::pixel_inspected,
                 InspectedView{viewer.version,
                               inspect(frame, size, pixel, request.settings.background, gaussian),
                               frame.grid});
}

}  // namespace

void action::pick_pivot(Viewer& viewer, Host& host, glm::dvec2 pixel) {
  if (viewer.scene) start_job(viewer, host, find_pivot, glm::ivec2(glm::floor(pixel)));
}

void action::inspect_pixel(Viewer& viewer, Host& host, glm::dvec2 pixel) {
  const bool inside = pixel.x >= 0 && pixel.y >= 0 && pixel.x < viewer.camera.width &&
                      pixel.y < viewer.camera.height;
  if (viewer.scene && viewer.panels.inspector && inside)
    start_job(viewer, host, inspect_view, glm::ivec2(pixel), std::nullopt);
}

void action::inspect_gaussian(Viewer& viewer, Host& host, std::uint32_t gaussian) {
  if (viewer.scene && viewer.inspected && viewer.inspected->version == viewer.version)
    start_job(viewer, host, inspect_view, viewer.inspected->inspection.pixel.pixel, gaussian);
}

void action::change_backend(Viewer& viewer, Host& host, Backend backend) {
  if (backend == viewer.backend) return;
  host.run([backend](RenderContext& context) {
    const auto end = hide_progress_at_end(context);
    Session& session = context.session;
    change_renderer(session, backend, [&](Backend wanted) {
      Progress progress = upload_progress(context, *session.scene);
      if (wanted == session.backend) progress.stop = {};  // the old renderer always comes back
      return upload_to(context, session.scene, wanted, progress);
    });
    context.report(action::backend_changed, backend);
  });
}

void action::toggle_beside(Viewer& viewer, Host& host) {
  if (!viewer.beside) return toggle_open_dialog(viewer, Choosing::scene_beside);
  viewer.beside.reset();
  viewer.panels.split = false;
  picture_changed(viewer);
  host.run([](RenderContext& context) { context.beside.reset(); });
}

}  // namespace qs
