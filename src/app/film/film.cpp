// SPDX-License-Identifier: MIT
#include "app/film/film.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "app/film/film_file.h"
#include "app/film/split_screen.h"
#include "app/inspect/heatmap_frame.h"
#include "app/measure/statistics.h"
#include "app/measure/turn_order.h"
#include "app/picture/palette.h"
#include "base/text.h"

namespace qs {
namespace {

// The frame times and pair counts of a strip so far.
struct Numbers {
  std::vector<double> frame_ms, tile_pairs;

  void add(const RenderStats& stats) {
    frame_ms.push_back(static_cast<double>(stats.frame_ms));
    tile_pairs.push_back(static_cast<double>(stats.tile_pairs));
  }
  double recent_ms(std::size_t most) const {
    return median(std::span(frame_ms).last(std::min(most, frame_ms.size())));
  }
};

std::vector<std::string> lines_of(const RenderStats& stats, double ms) {
  const double fps = 1000 / std::max(ms, 1e-6);
  std::vector<std::string> lines = {fmt::format("{:.{}f} FPS", fps, fps < 100 ? 1 : 0)};
  if (stats.tile_pairs > 0) lines.push_back(grouped(stats.tile_pairs) + " pairs");
  return lines;
}

std::vector<StripName> names_of(const std::vector<FilmedBy>& ways) {
  std::vector<StripName> names;
  for (const FilmedBy& way : ways)
    names.push_back({way.name, on_dark::mode_color(way.settings.mode)});
  return names;
}

Camera camera_at(const FilmPlan& plan, int index) {
  return camera_of(plan.track, index, plan.frames(), plan.size);
}

const Frame& frame_of(const FilmPlan& plan, const FilmedBy& way, int index, std::stop_token stop,
                      Quantity quantity) {
  Outputs outputs = outputs_for(quantity);
  outputs.color = quantity == Quantity::color;
  return way.renderer->render(camera_at(plan, index), way.settings, outputs, HostImage{},
                              std::move(stop));
}

// Collects values_of(index) of pictures spread over the whole film.
template <class Value, class ValuesOf>
std::vector<Value> sampled_values(const FilmPlan& plan, const Progress& progress,
                                  const ValuesOf& values_of) {
  constexpr int kMost = 16;
  const int count = std::min(plan.frames(), kMost);
  std::vector<Value> all;
  for (int i = 0; i < count; ++i) {
    progress.update(static_cast<float>(i) / static_cast<float>(count));
    const auto& values = values_of(count == 1 ? 0 : i * (plan.frames() - 1) / (count - 1));
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

/// A frame in its strip.
struct ShownWay {
  RenderStats stats;
  std::optional<Legend> legend;  ///< the legend of the frame's map
};

ShownWay show_heatmap(SplitScreen& screen, std::size_t k, const FilmPlan& plan, int index,
                      const std::stop_token& stop) {
  const FilmHeatmap& heat = *plan.heatmap;
  const FilmedBy& way = plan.ways[k];
  HeatmapFrame mapped = render_with_heatmap(*way.renderer, camera_at(plan, index), way.settings,
                                            heat.quantity, *heat.pool, stop);
  Heatmap& map = mapped.heatmap;
  screen.show(k, draw_over(mapped.frame.color, map, heat.scale, heat.style));
  map.largest = std::numeric_limits<std::uint32_t>::max();  // any picture may exceed the scale
  return {mapped.frame.stats, make_legend(map, heat.scale, "", heat.style.colors)};
}

/// Draws picture `index` of way `k` into its strip.
ShownWay show_way(SplitScreen& screen, std::size_t k, const FilmPlan& plan, int index,
                  const std::stop_token& stop) {
  if (plan.heatmap) return show_heatmap(screen, k, plan, index, stop);
  const Frame& frame = frame_of(plan, plan.ways[k], index, stop, plan.quantity);
  if (plan.quantity == Quantity::color) {
    screen.show(k, frame.color);
    return {frame.stats, std::nullopt};
  }
  ValueMap map = map_of(frame, plan.quantity, plan.size.x, plan.size.y);
  map.scale = plan.scale;
  screen.show(k, colored(map));
  return {frame.stats, make_legend(map, "")};
}

}  // namespace

ValueScale film_scale(const FilmPlan& plan, const Progress& progress) {
  if (plan.quantity == Quantity::color || plan.quantity == Quantity::alpha) return {};
  const auto values_of = [&](int index) -> const std::vector<float>& {
    const Frame& frame = frame_of(plan, plan.ways.front(), index, progress.stop, plan.quantity);
    return frame.depth.*row_of(plan.quantity).values;
  };
  return scale_for(plan.quantity, sampled_values<float>(plan, progress, values_of));
}

Scale film_heat_scale(const FilmPlan& plan, CullMode baseline, const Progress& progress) {
  const FilmHeatmap& heat = *plan.heatmap;
  const FilmedBy& way = plan.ways.front();
  RenderSettings settings = way.settings;
  settings.mode = scale_mode(heat.quantity, baseline);
  Heatmap map;
  const auto values_of = [&](int index) -> const std::vector<std::uint32_t>& {
    map = render_with_heatmap(*way.renderer, camera_at(plan, index), settings, heat.quantity,
                              *heat.pool, progress.stop)
              .heatmap;
    return map.values;
  };
  return scale_for(sampled_values<std::uint32_t>(plan, progress, values_of));
}

std::vector<FilmedNumbers> write_film(const std::filesystem::path& path, const FilmPlan& plan,
                                      const Progress& progress) {
  const int count = plan.frames();
  const auto per_second = static_cast<std::size_t>(std::max(plan.fps, 1.0));
  const bool measures = plan.numbers || plan.ways.size() > 1;
  const bool draws_colors = plan.quantity == Quantity::color && !plan.heatmap;
  std::vector<Numbers> numbers(plan.ways.size());
  SplitScreen screen(names_of(plan.ways), plan.size.x, plan.size.y);
  TurnOrder order;
  write_film_file(path, plan.size, plan.fps, [&](const AddPicture& add) {
    if (plan.numbers)  // a renderer's first frame takes longer
      for (const FilmedBy& way : plan.ways) frame_of(plan, way, 0, progress.stop, Quantity::color);
    for (int i = 0; i < count; ++i) {
      std::optional<Legend> legend;
      for (const std::size_t k : order.next(plan.ways.size())) {
        ShownWay shown = show_way(screen, k, plan, i, progress.stop);
        legend = std::move(shown.legend);
        if (measures && !draws_colors)  // maps take time that the mode does not need
          shown.stats = frame_of(plan, plan.ways[k], i, progress.stop, Quantity::color).stats;
        numbers[k].add(shown.stats);
        if (plan.numbers) screen.label(k, lines_of(shown.stats, numbers[k].recent_ms(per_second)));
      }
      Image& picture = screen.picture();
      if (legend) draw_legend_over(picture, *legend);
      add(picture);
      progress.update(static_cast<float>(i + 1) / static_cast<float>(count));
    }
  });
  std::vector<FilmedNumbers> medians;
  for (const Numbers& way : numbers)
    medians.push_back(
        {median(way.frame_ms), median(way.tile_pairs), quartile_spread(way.frame_ms)});
  return medians;
}

}  // namespace qs
