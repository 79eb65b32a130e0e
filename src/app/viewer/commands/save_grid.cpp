// SPDX-License-Identifier: MIT
//
// Writes the pictures of all modes with their numbers as a figure to figures/SCENE_modes_NNNN.png
// and .svg.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/measure/scene_facts.h"
#include "app/picture/figure.h"
#include "app/picture/grid_places.h"
#include "app/report/environment.h"
#include "app/session/shot.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/all_modes.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/host_frames.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/mode_table.h"
#include "base/text.h"
#include "io/bytes/replace_file.h"
#include "io/picture/image_file.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

constexpr int kMostWidth = 960, kFigureMargin = 36, kFigureGap = 24;
constexpr int kTitle = 30, kName = 26, kText = 21, kBar = 18;

// The colour bar of the maps with its ticks, `width` pixels wide at `at`.
void add_scale(Figure& figure, glm::ivec2 at, int width, const Viewer& viewer, const Heatmap& map,
               const Scale& scale) {
  const Legend legend = make_legend(map, scale, "", viewer.heat_view.style.colors);
  Image bar(width, kBar, 3);
  const std::vector<glm::vec3> colors = bar_colors(legend, width, kBar);
  for (int x = 0; x < width; ++x)
    fill_rect(bar, {x, 0, 1, kBar}, colors[static_cast<std::size_t>(x)]);
  figure.texts.push_back({at, kText, legend.title});
  figure.pictures.push_back({{at.x, at.y + kText + 6}, std::move(bar)});
  const Font font(kText);
  const auto placed = place_ticks(legend.ticks, width, kText / 2,
                                  [&](const std::string& text) { return font.width(text); });
  for (std::size_t i = 0; i < placed.size(); ++i)
    if (placed[i].has_text)
      figure.texts.push_back({{at.x + placed[i].text, at.y + kText + kBar + 10},
                              kText,
                              legend.ticks[i].text,
                              on_white::kFaint,
                              placed[i].align});
}

struct FigureMode {
  ModePicture picture;
  std::string quality;  // " \u00b7 PSNR 45.12 dB" against a lossless mode
};

// The pictures of all modes, at most kMostWidth wide.
std::vector<FigureMode> small_pictures(RenderContext& context, const FrameRequest& request,
                                       const Scale& scale) {
  const Camera& camera = request.camera;
  RenderSettings lossless = request.settings;
  lossless.mode = default_mode();
  const Image truth =
      context.session.renderer->render(camera, lossless, {}, HostImage{}, context.stop).color;
  const int width = std::min(camera.width, kMostWidth);
  const int height = std::max(1, camera.height * width / camera.width);
  std::vector<FigureMode> pictures;
  draw_all_modes(context, request, camera, scale, [&](ModePicture picture) {
    std::string quality = " \u00b7 lossless";
    if (picture.heatmap) {
      quality.clear();
    } else if (!row_of(picture.mode).lossless) {
      quality = fmt::format(" \u00b7 PSNR {} dB", decibels(psnr_8bit(picture.image, truth)));
    }
    picture.image = area_average(picture.image, width, height, *context.session.pool);
    pictures.push_back({std::move(picture), quality});
  });
  return pictures;
}

// FPS have the digits of the least certain mode, and ratios have two decimals. Numbers of another
// view are left out.
std::string numbers_text(const Viewer& viewer, CullMode mode, std::uint64_t pairs) {
  const std::string counted = grouped(pairs) + " pairs";
  const BenchRow* row = measured_row(viewer, mode, viewer.settings.pipeline);
  if (row == nullptr || !numbers_are_current(viewer)) return counted;
  double worst = 0;  // spread, of the median
  for (const BenchRow& each : viewer.numbers.rows)
    worst = std::max(worst, spread_ms(each).value_or(0) / each.ms_median);
  std::string text =
      fmt::format("{} FPS \u00b7 {}", rate_text(row->ms_median, worst * row->ms_median), counted);
  const auto ratio = ratio_to_baseline(viewer, row, viewer.settings.pipeline);
  if (!ratio) return text;
  text += fmt::format(" \u00b7 {:.2f}x", ratio->value);
  if (!ratio->interval) return text;
  return text + fmt::format(" \u00b1{:.2f}{}", half_interval(*ratio),
                            is_undecided(*ratio) ? " noisy" : "");
}

Figure mode_figure(const Viewer& viewer, std::vector<FigureMode> modes, const Scale& scale,
                   const std::string& maker) {
  const GridPlaces places = grid_places(static_cast<int>(modes.size()), kGridLabel);
  const ModePicture& first = modes.front().picture;
  const int width = first.image.width, height = first.image.height;
  const glm::ivec2 step{width + kFigureGap, height + kName + kText + 12 + kFigureGap};
  const int top = kFigureMargin + kTitle + kText + 8 + kFigureGap;
  const bool maps = first.heatmap.has_value();
  Figure figure;
  figure.size = {2 * kFigureMargin + places.columns * step.x - kFigureGap,
                 top + places.rows * step.y + (maps ? 2 * kText + kBar + 24 : 0) + kFigureMargin};
  figure.texts.push_back({{kFigureMargin, kFigureMargin}, kTitle, table_caption(viewer)});
  figure.texts.push_back(
      {{kFigureMargin, kFigureMargin + kTitle + 8}, kText, maker, on_white::kFaint});
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const auto index = static_cast<int>(i);
    const glm::ivec2 at = glm::ivec2(kFigureMargin, top) +
                          step * glm::ivec2(index % places.columns, index / places.columns);
    ModePicture& picture = modes[i].picture;
    const CullMode mode = picture.mode;
    figure.texts.push_back(
        {{at.x, at.y + height + 6}, kName, mode_name(mode), on_white::mode_color(mode)});
    figure.texts.push_back(
        {{at.x, at.y + height + kName + 8},
         kText,
         numbers_text(viewer, mode, picture.stats.tile_pairs) + modes[i].quality});
    figure.pictures.push_back({at, std::move(picture.image)});
  }
  if (maps)
    add_scale(figure, {kFigureMargin, top + places.rows * step.y},
              figure.size.x - 2 * kFigureMargin, viewer, *first.heatmap, scale);
  return figure;
}

}  // namespace

namespace job {

void save_grid(RenderContext& context, const Viewer& viewer) {
  const FrameRequest request = full_frame(viewer);
  const Scale scale = heat_scale(context, request, request.camera).scale;
  const auto settings = with_settings(context.session, request.settings);
  const nlohmann::ordered_json environment = environment_json(context.session);
  std::string maker = fmt::format("{}; {}", measured_on(environment), environment.value("utc", ""));
  if (numbers_are_current(viewer))
    maker += fmt::format("; medians of {} frames each", frames_behind(viewer.numbers));
  const Figure figure = mode_figure(viewer, small_pictures(context, request, scale), scale, maker);
  const std::filesystem::path folder = viewer.out_dir / "figures";
  make_folder(folder);
  const std::string stem = safe_file_name(scene_name(context.session.scene->path) + "_modes");
  const std::filesystem::path path = free_name(folder, stem, ".png");
  std::filesystem::path svg = path;
  svg.replace_extension(".svg");
  write_image(draw_figure(figure), path, altered_metadata(context.session));
  write_text(svg, figure_svg(figure, table_caption(viewer)));
  context.report(action::notify_file, path, std::string(" and .svg"));
}

}  // namespace job
}  // namespace qs
