// SPDX-License-Identifier: MIT
//
// Writes the picture, with its heat map if there is one, or depth or alpha by the colour map, to
// screenshots/SCENE_CAMERA_MODE_WxH_NNNN.png.
#include <fmt/format.h>

#include "app/film/film.h"
#include "app/inspect/heatmap_frame.h"
#include "app/measure/scene_facts.h"
#include "app/picture/palette.h"
#include "app/session/shot.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/hud_text.h"
#include "io/bytes/replace_file.h"

namespace qs::job {
namespace {

Image with_badge(const Viewer& viewer, const Image& picture) {
  SplitScreen screen({{mode_name(viewer.mode()), on_dark::mode_color(viewer.mode())}},
                     picture.width, picture.height);
  screen.show(0, picture);
  screen.label(0, badge_lines(viewer));
  return screen.picture();
}

}  // namespace

void save_screenshot(RenderContext& context, const Viewer& viewer) {
  const FrameRequest request = full_frame(viewer);
  const auto settings = with_settings(context.session, request.settings);
  const Camera& camera = request.camera;
  const CullMode mode = request.settings.mode;
  const std::filesystem::path scene = context.session.scene->path;
  Renderer& renderer = *context.session.renderer;
  Image picture;
  RenderStats stats;
  std::string map;      // instead of colours
  ImageMetadata shown;  // of the map
  if (request.heatmap) {
    const Scale scale = heat_scale(context, request, camera).scale;
    const HeatmapFrame mapped = render_with_heatmap(
        renderer, camera, request.settings, *request.heatmap, *context.session.pool, context.stop);
    picture = draw_heatmap(mapped.frame.color, mapped.heatmap, scale, mode_name(mode),
                           viewer.heat_view.style);
    stats = mapped.frame.stats;
    map = heatmap_row(*request.heatmap).name;
    shown = {{"Heatmap", map}, {"HeatmapTotal", fmt::format("{}", mapped.heatmap.total)}};
  } else if (request.quantity != Quantity::color) {
    const Frame& frame = renderer.render(camera, request.settings, outputs_for(request.quantity),
                                         HostImage{}, context.stop);
    const ValueMap values = map_of(frame, request.quantity, camera.width, camera.height);
    picture = with_legend(colored(values), make_legend(values, mode_name(mode)));
    stats = frame.stats;
    map = row_of(values.quantity).name;
    shown = {{"Picture", map},
             {"Colours", values.scale.text_of_ends() + row_of(values.quantity).unit}};
  } else {
    const Frame& frame = renderer.render(camera, request.settings, {}, HostImage{}, context.stop);
    picture = frame.color;
    stats = frame.stats;
  }
  if (viewer.shows_badge) picture = with_badge(viewer, picture);
  const std::filesystem::path folder = viewer.out_dir / "screenshots";
  make_folder(folder);
  // Of several pictures in the window it is one.
  const bool alone = request.other || request.grid;
  if (alone)
    shown["Split"] = fmt::format("{} alone, without the pictures beside it", mode_name(mode));
  const std::string stem = fmt::format("{}_{}_{}{}{}_{}x{}", scene_name(scene), camera_name(viewer),
                                       mode_name(mode), alone ? "_alone" : "",
                                       map.empty() ? "" : "_" + map, picture.width, picture.height);
  const std::filesystem::path path = free_name(folder, safe_file_name(stem), ".png");
  shown.merge(frame_metadata(context.session, camera, mode, stats));
  write_image(picture, path, shown);
  context.report(action::notify_file, path,
                 alone ? fmt::format(": {} alone", mode_name(mode)) : std::string());
}

}  // namespace qs::job
