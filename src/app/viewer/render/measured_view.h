// SPDX-License-Identifier: MIT
//
// The surfaces that the pixels of a view of the scene in the window show.
#pragma once

#include <optional>

#include "app/session/levels.h"
#include "app/viewer/render/render_context.h"
#include "raster/select/surface.h"

namespace qs {

/// Draws when it is made, as Gaussians in any style of the picture. Throws Error and Cancelled.
struct MeasuredView {
  Camera camera;
  DrawnView drawn;

  /// `seen`: counts as the cloud's positions do.
  MeasuredView(RenderContext& context, const Camera& seen)
      : camera(seen),
        drawn(draw_view(context.session, seen, {.color = false, .trace = true}, context.stop)) {
    camera.origin = drawn.cloud->origin;
  }
  std::optional<SurfacePoint> surface(glm::dvec2 pixel) const {
    return surface_at(drawn.frame, *drawn.cloud, camera, glm::ivec2(glm::round(pixel)));
  }
};

}  // namespace qs
