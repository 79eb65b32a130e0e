// SPDX-License-Identifier: MIT
#include "app/viewer/state/mode_glance.h"

#include <cmath>

#include <fmt/format.h>

#include "app/viewer/state/mode_table.h"
#include "base/text.h"

namespace qs {
namespace {

ModeGlance glance_of_row(const BenchRow& row) { return {row.fps_median, row.pairs}; }

ModeGlance glance_of_seen(const Viewer& viewer, CullMode mode) {
  ModeGlance glance;
  const auto found = viewer.seen.stats.find(mode);
  if (viewer.seen.view_version != viewer.view_version || found == viewer.seen.stats.end())
    return glance;
  const RenderStats& stats = found->second;
  if (stats.frame_ms > 0) glance.fps = 1000 / static_cast<double>(stats.frame_ms);
  glance.pairs = stats.tile_pairs;
  return glance;
}

// FPS to three digits: one decimal below 100.
std::string fps_glance(const std::optional<double>& fps) {
  if (!fps) return "-";
  if (*fps < 100) return fmt::format("{:.1f}", *fps);
  return grouped(static_cast<std::uint64_t>(std::llround(*fps)));
}

std::string pairs_glance(const std::optional<std::uint64_t>& pairs) {
  return pairs ? grouped(*pairs) : "-";
}

}  // namespace

GlancePair glances_of(const Viewer& viewer, CullMode from, CullMode to) {
  const Pipeline pipeline = viewer.settings.pipeline;
  const BenchRow* a = measured_row(viewer, from, pipeline);
  const BenchRow* b = measured_row(viewer, to, pipeline);
  if (numbers_are_current(viewer) && a != nullptr && b != nullptr)
    return {glance_of_row(*a), glance_of_row(*b)};
  return {glance_of_seen(viewer, from), glance_of_seen(viewer, to)};
}

std::string switch_text(const Viewer& viewer) {
  const auto [from, to] = glances_of(viewer, viewer.mode_switch->from, viewer.mode_switch->to);
  if (!from.pairs && !to.pairs) return "";
  return fmt::format("FPS {} -> {}, pairs {} -> {}", fps_glance(from.fps), fps_glance(to.fps),
                     pairs_glance(from.pairs), pairs_glance(to.pairs));
}

std::string grid_label(const Viewer& viewer, CullMode mode) {
  const std::optional<ShownGrid>& grid = viewer.shown.grid;
  if (!grid || viewer.shown.divisor > 1) return mode_label(viewer, mode, std::nullopt);
  return mode_label(viewer, mode, grid->stats[static_cast<std::size_t>(mode - 1)].tile_pairs);
}

std::string mode_label(const Viewer& viewer, CullMode mode, std::optional<std::uint64_t> counted) {
  const HudRow row = hud_rows(viewer)[static_cast<std::size_t>(mode - 1)];
  const bool current = numbers_are_current(viewer);
  std::string pairs = current ? row.pairs.text : "-";
  if (pairs == "-") pairs = pairs_glance(counted);
  return fmt::format("{} FPS \u00b7 {} pairs \u00b7 {}", current ? row.fps.text : "-", pairs,
                     current ? row.ratio.text : "-");
}

std::vector<std::string> badge_lines(const Viewer& viewer) {
  const ModeGlance glance = glances_of(viewer, viewer.mode(), viewer.mode()).to;
  std::vector<std::string> lines;
  if (glance.fps) lines.push_back(fps_glance(glance.fps) + " FPS");
  if (glance.pairs) lines.push_back(pairs_glance(glance.pairs) + " pairs");
  return lines;
}

}  // namespace qs
