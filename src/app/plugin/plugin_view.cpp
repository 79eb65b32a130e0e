// SPDX-License-Identifier: MIT
#include "app/plugin/plugin_view.h"

#include <algorithm>

namespace qs {

QsView view_of(const Camera& camera, const RenderSettings& settings, int sh_degree,
               bool antialiased) {
  QsView view = {};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      view.view_from_world[4 * row + column] = camera.view_from_world[column][row];
  }
  for (int axis = 0; axis < 2; ++axis) {
    view.focal_px[axis] = camera.focal_px[axis];
    view.center_px[axis] = camera.center_px[axis];
  }
  view.near_depth = camera.near_depth;
  view.dilation_px2 = settings.dilation;
  for (int channel = 0; channel < 3; ++channel)
    view.background[channel] = settings.background[channel];
  view.splat_scale = settings.splat_scale;
  view.width = camera.width;
  view.height = camera.height;
  view.sh_degree = std::min(settings.sh_degree, sh_degree);
  view.antialiased = settings.antialiased.value_or(antialiased) ? 1 : 0;
  return view;
}

}  // namespace qs
