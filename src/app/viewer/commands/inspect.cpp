// SPDX-License-Identifier: MIT
//
// The inspector's job: the Gaussians of a pixel, and the tiles of one of them in every mode.
#include "app/viewer/commands/jobs.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"

namespace qs {
namespace {

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

}  // namespace qs
