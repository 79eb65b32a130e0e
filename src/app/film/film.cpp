// SPDX-License-Identifier: MIT
#include "app/film/film.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "app/base/text.h"
#include "app/film/film_file.h"
#include "app/film/split_screen.h"
#include "app/measure/statistics.h"
#include "app/picture/palette.h"

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

const Frame& frame_of(const FilmPlan& plan, const FilmedBy& way, int index, std::stop_token stop) {
  const Camera camera = camera_of(plan.track, index, plan.frames(), plan.size);
  Outputs outputs = outputs_for(plan.quantity);
  outputs.color = plan.quantity == Quantity::color;
  return way.renderer->render(camera, way.settings, outputs, HostImage{}, std::move(stop));
}

/// `frame` by the plan's scale.
Image colored_frame(const FilmPlan& plan, const Frame& frame) {
  ValueMap map = map_of(frame, plan.quantity, plan.size.x, plan.size.y);
  map.scale = plan.scale;
  return colored(map);
}

}  // namespace

ValueScale film_scale(const FilmPlan& plan, const Progress& progress) {
  constexpr int kMost = 16;  // pictures
  if (plan.quantity == Quantity::color || plan.quantity == Quantity::alpha) return {};
  const int count = std::min(plan.frames(), kMost);
  std::vector<float> all;
  for (int i = 0; i < count; ++i) {
    progress.update(0);
    const int index = count == 1 ? 0 : i * (plan.frames() - 1) / (count - 1);
    const Frame& frame = frame_of(plan, plan.ways.front(), index, progress.stop);
    const std::vector<float>& values = frame.depth.*row_of(plan.quantity).values;
    all.insert(all.end(), values.begin(), values.end());
  }
  return scale_for(plan.quantity, all);
}

int FilmPlan::frames() const { return std::max(static_cast<int>(std::lround(seconds * fps)), 1); }

std::vector<FilmedNumbers> write_film(const std::filesystem::path& path, const FilmPlan& plan,
                                      const Progress& progress) {
  const int count = plan.frames();
  const auto per_second = static_cast<std::size_t>(std::max(plan.fps, 1.0));
  std::vector<Numbers> numbers(plan.ways.size());
  SplitScreen screen(names_of(plan.ways), plan.size.x, plan.size.y);
  write_film_file(path, plan.size, plan.fps, [&](const AddPicture& add) {
    if (plan.numbers)  // a renderer's first frame takes longer
      for (const FilmedBy& way : plan.ways) frame_of(plan, way, 0, progress.stop);
    for (int i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < plan.ways.size(); ++k) {
        const Frame& frame = frame_of(plan, plan.ways[k], i, progress.stop);
        numbers[k].add(frame.stats);
        if (plan.quantity == Quantity::color) {
          screen.show(k, frame.color);
        } else {
          screen.show(k, colored_frame(plan, frame));
        }
        if (plan.numbers) screen.label(k, lines_of(frame.stats, numbers[k].recent_ms(per_second)));
      }
      add(screen.picture());
      progress.update(static_cast<float>(i + 1) / static_cast<float>(count));
    }
  });
  std::vector<FilmedNumbers> medians;
  for (const Numbers& way : numbers)
    medians.push_back({median(way.frame_ms), median(way.tile_pairs)});
  return medians;
}

}  // namespace qs
