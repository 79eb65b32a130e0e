// SPDX-License-Identifier: MIT
#include "app/viewer/render/candidate_pictures.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/layout.h"

namespace qs {
namespace {

// Pictures of these views side by side, each `width` > 0 pixels wide and 9/16 as high.
Image draw_candidates(RenderContext& context, const std::vector<Framing>& views,
                      const RenderSettings& settings, int width) {
  const int height = std::max(1, width * 9 / 16);
  Image strip(width * static_cast<int>(views.size()), height, 3);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Camera camera = framed_camera(views[i], width, height);
    const Frame& frame =
        context.session.renderer->render(camera, settings, {}, HostImage{}, context.stop);
    for (int y = 0; y < height; ++y) {
      const float* from = frame.color.row(y);
      std::copy(from, from + 3 * width, strip.row(y) + i * static_cast<std::size_t>(3 * width));
    }
  }
  return strip;
}

}  // namespace

void action::follow_view_choice(Viewer& viewer, Host& host) {
  const bool shows_scene = viewer.scene && viewer.shown.version == viewer.version &&
                           viewer.shown.divisor == 1 && viewer.still();
  if (!viewer.view_choice.wanted || viewer.view_choice.asked || !shows_scene) return;
  viewer.view_choice.asked = true;
  RenderSettings settings = viewer.settings;
  settings.mode = viewer.mode();
  constexpr float kPictureWidth = 240;  // screen units at 100 %
  const int width = static_cast<int>(std::lround(kPictureWidth * interface_scale(viewer)));
  host.run([scene = viewer.scene->path, views = viewer.scene->candidates, settings,
            width](RenderContext& context) {
    context.report(action::candidates_drawn, scene,
                   std::make_shared<const Image>(draw_candidates(context, views, settings, width)));
  });
}

}  // namespace qs
