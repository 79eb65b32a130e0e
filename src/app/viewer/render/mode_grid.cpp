// SPDX-License-Identifier: MIT
#include "app/viewer/render/mode_grid.h"

#include <algorithm>
#include <cmath>

#include "app/inspect/heatmap_frame.h"
#include "app/picture/canvas.h"
#include "app/picture/grid_places.h"
#include "app/picture/palette.h"
#include "app/viewer/render/host_frames.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

ModePicture draw_mode(RenderContext& context, const FrameRequest& request, const Camera& camera,
                      const RenderSettings& settings, const Scale& scale) {
  Renderer& renderer = *context.session.renderer;
  ModePicture drawn;
  drawn.mode = settings.mode;
  if (!request.heatmap) {
    const Frame& frame = renderer.render(camera, settings, {}, HostImage{}, context.stop);
    drawn.image = frame.color;
    drawn.stats = frame.stats;
    return drawn;
  }
  HeatmapFrame mapped = render_with_heatmap(renderer, camera, settings, *request.heatmap,
                                            *context.session.pool, context.stop);
  drawn.image = draw_over(mapped.frame.color, mapped.heatmap, scale, request.heat_style);
  drawn.stats = mapped.frame.stats;
  drawn.heatmap = std::move(mapped.heatmap);
  return drawn;
}

int pixels_of(float share, int size) {
  return static_cast<int>(std::lround(share * static_cast<float>(size)));
}

}  // namespace

void draw_all_modes(RenderContext& context, const FrameRequest& request, const Camera& camera,
                    const Scale& scale, const std::function<void(ModePicture)>& visit) {
  RenderSettings settings = request.settings;
  for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode)
    visit(draw_mode(context, request, camera, settings, scale));
}

RenderedFrame draw_grid(RenderContext& context, const FrameRequest& request, const Camera& camera) {
  const HeldScale scale = heat_scale(context, request, camera);
  const GridPlaces places = grid_places(culler_count(), kGridLabel);
  Image page(camera.width, camera.height, 3);
  fill_rect(page, {0, 0, page.width, page.height}, on_dark::kPanel);
  const int width = std::max(1, pixels_of(places.side, page.width));
  const int height = std::max(1, pixels_of(places.side, page.height));
  const CullMode current = std::clamp<CullMode>(request.settings.mode, 1, culler_count());
  RenderedFrame rendered;
  rendered.shown = shown_of(request, Frame());
  ShownGrid grid;
  draw_all_modes(context, request, camera, scale.scale, [&](ModePicture picture) {
    const glm::vec2 low = places.low(picture.mode - 1);
    paste(page, area_average(picture.image, width, height, *context.session.pool),
          {pixels_of(low.x, page.width), pixels_of(low.y, page.height)});
    grid.stats.push_back(picture.stats);
    if (picture.heatmap) grid.totals.push_back(picture.heatmap->total);
    if (picture.mode != current) return;
    rendered.shown.stats = picture.stats;
    if (picture.heatmap) show_map(rendered.shown, std::move(*picture.heatmap), scale);
  });
  rendered.width = page.width;
  rendered.height = page.height;
  rendered.rgba = to_rgba(page);
  rendered.shown.grid = std::move(grid);
  return rendered;
}

}  // namespace qs
