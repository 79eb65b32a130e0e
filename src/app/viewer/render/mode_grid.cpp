// SPDX-License-Identifier: MIT
#include "app/viewer/render/mode_grid.h"

#include <algorithm>
#include <cmath>

#include "app/inspect/heatmap_frame.h"
#include "app/picture/canvas.h"
#include "app/picture/grid_places.h"
#include "app/picture/palette.h"
#include "app/viewer/render/heat_scale.h"
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

std::vector<ModePicture> draw_all_modes(RenderContext& context, const FrameRequest& request,
                                        const Camera& camera) {
  const Scale scale = heat_scale(context, request, camera).scale;
  std::vector<ModePicture> pictures;
  RenderSettings settings = request.settings;
  for (settings.mode = 1; settings.mode <= culler_count(); ++settings.mode)
    pictures.push_back(draw_mode(context, request, camera, settings, scale));
  return pictures;
}

RenderedFrame draw_grid(RenderContext& context, const FrameRequest& request, const Camera& camera) {
  std::vector<ModePicture> pictures = draw_all_modes(context, request, camera);
  const GridPlaces places = grid_places(static_cast<int>(pictures.size()), kGridLabel);
  Image page(camera.width, camera.height, 3);
  fill_rect(page, {0, 0, page.width, page.height}, on_dark::kPanel);
  const int width = std::max(1, pixels_of(places.side, page.width));
  const int height = std::max(1, pixels_of(places.side, page.height));
  RenderedFrame rendered;
  ShownGrid grid;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    ModePicture& picture = pictures[i];
    const glm::vec2 low = places.low(static_cast<int>(i));
    paste(page, area_average(picture.image, width, height, *context.session.pool),
          {pixels_of(low.x, page.width), pixels_of(low.y, page.height)});
    grid.stats.push_back(picture.stats);
    if (picture.heatmap) grid.totals.push_back(picture.heatmap->total);
  }
  const auto current =
      static_cast<std::size_t>(std::clamp<CullMode>(request.settings.mode, 1, culler_count()) - 1);
  rendered.shown = shown_of(request, Frame());
  rendered.shown.stats = grid.stats[current];
  rendered.width = page.width;
  rendered.height = page.height;
  rendered.rgba = to_rgba(page);
  if (pictures[current].heatmap)
    show_map(rendered.shown, std::move(*pictures[current].heatmap),
             heat_scale(context, request, camera));
  rendered.shown.grid = std::move(grid);
  return rendered;
}

}  // namespace qs
