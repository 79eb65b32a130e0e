// SPDX-License-Identifier: MIT
//
// The surfaces that the pixels of a view of the scene in the window show.
#pragma once

#include <optional>

#include "app/viewer/render/render_context.h"
#include "raster/select/surface.h"

namespace qs {

/// Draws when it is made, as Gaussians in any style of the picture. Throws Error and Cancelled.
struct MeasuredView {
  const GaussianCloud& cloud;
  Camera camera;
  const Frame& frame;

  /// `seen`: counts as the cloud's positions do.
  MeasuredView(RenderContext& context, const Camera& seen)
      : cloud(context.session.scene->cloud),
        camera(seen),
        frame(context.session.renderer->render(seen, {}, {.color = false, .trace = true},
                                               HostImage{}, context.stop)) {
    camera.origin = cloud.origin;
  }
  std::optional<SurfacePoint> surface(glm::dvec2 pixel) const {
    return surface_at(frame, cloud, camera, glm::ivec2(glm::round(pixel)));
  }
};

}  // namespace qs
