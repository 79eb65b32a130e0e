// SPDX-License-Identifier: MIT
//
// Compares the view, or the part around the cursor, with the fp64 reference. This takes seconds.
// The reference's image is kept, and shown beside the view if the split window asks for it.
#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"

namespace qs::job {
namespace {

constexpr int kTolerance = 2;  ///< of 8-bit values
constexpr int kSide = 256;     ///< of the part around the cursor, pixels

void compare(RenderContext& context, const Viewer& viewer, std::optional<PixelBox> region) {
  const FrameRequest request = full_frame(viewer);
  const auto end = hide_progress_at_end(context);
  Outputs outputs{.trace = true};
  const Frame frame = context.session.renderer->render(request.camera, request.settings, outputs,
                                                       HostImage{}, context.stop);
  Renderer& cpu = renderer_on(context, Backend::cpu);
  const Progress progress = shown_progress(
      context.session.scene->path, "computing the reference of", context.stop, context.reports);
  progress.update(0);
  const CheckedView view{request.camera, request.settings, region};
  Image truth = render_reference(cpu, view, progress);
  const ReferenceCheck verdict =
      check_against_reference(cpu, view, frame, truth, kTolerance, progress);
  context.reference = ReferenceImage{viewer.view_version, verdict.region, std::move(truth)};
  context.report(action::compared_with_reference,
                 ReferenceComparison{viewer.view_version, viewer.variant(), kTolerance, verdict,
                                     fmt::format("{}: {}", mode_name(request.settings.mode),
                                                 check_sentence(verdict, kTolerance))});
  if (request.other) context.show(request);
}

}  // namespace

void compare_with_reference(RenderContext& context, const Viewer& viewer) {
  compare(context, viewer, std::nullopt);
}

void compare_around_cursor(RenderContext& context, const Viewer& viewer) {
  const glm::ivec2 size(viewer.camera.width, viewer.camera.height);
  const glm::ivec2 at = glm::clamp(glm::ivec2(glm::floor(viewer.cursor)), glm::ivec2(0), size - 1);
  const glm::ivec2 low = glm::max(at - kSide / 2, glm::ivec2(0));
  const glm::ivec2 high = glm::min(at + kSide / 2, size);
  compare(context, viewer, PixelBox{low.x, low.y, high.x, high.y});
}

}  // namespace qs::job
