// SPDX-License-Identifier: MIT
#include "app/viewer/render/heat_scale.h"

#include "app/inspect/heatmap_frame.h"

namespace qs {

HeldScale heat_scale(RenderContext& context, const FrameRequest& request, const Camera& camera) {
  if (!request.heatmap) return {};
  const HeatQuantity quantity = *request.heatmap;
  if (request.heat_maximum > 0)
    return {quantity, request.baseline, request.view_version, exact_scale(request.heat_maximum)};
  const bool final = !request.moving && request.divisor == 1;
  std::optional<HeldScale>& held = context.heat_scale;
  const bool same_kind = held && held->quantity == quantity && held->baseline == request.baseline;
  if (same_kind && (!final || held->view_version == request.view_version)) return *held;
  RenderSettings settings = request.settings;
  settings.mode = request.baseline;
  const Scale scale = scale_of_view(*context.session.renderer, camera, settings, quantity,
                                    *context.session.pool, context.stop);
  held = {quantity, request.baseline, final ? request.view_version : -1, scale};
  return *held;
}

void show_map(ShownFrame& shown, Heatmap map, const HeldScale& scale) {
  shown.heatmap = std::move(map);
  shown.map_scale = scale.scale;
  shown.scale_version = scale.view_version;
}

}  // namespace qs
