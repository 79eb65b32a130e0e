// SPDX-License-Identifier: MIT
//
// The zoom recorder: the chart of all modes against the zoom, the plan of a recording, and the list
// of recordings.
#include <memory>

#include <fmt/format.h>

#include "app/viewer/panel_model/panel_model.h"
#include "app/viewer/state/charts.h"
#include "app/viewer/state/zoom_actions.h"

namespace qs {
namespace {

block::Curve zoom_curve(const ZoomChart& chart, const ZoomCurve& from) {
  block::Curve curve{mode_name(from.mode), ink_of(from.mode), {}, from.is_beneath, from.has_bars};
  curve.is_marked = !from.is_beneath;
  // quadbox-naive lists the same pairs as quadbox: its wider curve stays visible under the other.
  if (from.is_beneath) curve.width = 1.5f;
  if (!from.is_beneath && from.mode == find_culler("quadbox-naive")) curve.width = 3.5f;
  for (const ZoomPoint& point : from.points) {
    const glm::dvec2 at = chart.place(point.zoom, point.value);
    curve.points.push_back({at.x, at.y, chart.place(1, point.low).y, chart.place(1, point.high).y,
                            point.is_noisy && !from.is_beneath});
  }
  return curve;
}

std::optional<block::Reading> zoom_reading(const ZoomChart& chart, double x) {
  const auto reading = read_zoom_chart(chart, x);
  if (!reading) return std::nullopt;
  block::Reading shown{chart.place(reading->zoom, 0).x, reading->title, {}};
  for (const ZoomReading::Row& row : reading->rows)
    shown.rows.push_back({mode_name(row.mode), row.value, row.beneath, ink_of(row.mode)});
  return shown;
}

void add_chart(const ZoomChart& from, Blocks& blocks) {
  block::Chart chart{.title = from.title, .axis = kZoomAxis};
  for (const AxisTick& tick : from.zoom_ticks)
    chart.across.push_back({static_cast<float>(from.place(tick.value, 0).x), tick.text});
  for (const AxisTick& tick : from.value_ticks)
    chart.up.push_back({static_cast<float>(tick.value / from.most_value), tick.text});
  block::Keys keys;
  for (const ZoomCurve& curve : from.curves) {
    chart.curves.push_back(zoom_curve(from, curve));
    if (!curve.is_beneath) keys.keys.push_back({mode_name(curve.mode), ink_of(curve.mode)});
  }
  chart.reading = [kept = std::make_shared<const ZoomChart>(from)](double x) {
    return zoom_reading(*kept, x);
  };
  blocks.emplace_back(std::move(chart));
  blocks.emplace_back(std::move(keys));
}

void add_shown(const ZoomRecorder& zoom, Blocks& blocks) {
  const ZoomRecord* record = shown_zoom(zoom);
  if (record == nullptr) return;
  const ZoomRecord* beneath = zoom_beneath(zoom);
  const ZoomChart chart = zoom_chart(record, beneath, zoom.quantity);
  if (!chart.empty()) {
    blocks.push_back(block::Controls{{{"chart of", 0, false, block::Form::radio}}});
    add_chart(chart, blocks);
  }
  const auto add = [&](std::string text) {
    if (!text.empty()) blocks.push_back(block::Text{std::move(text), Tone::faint});
  };
  add(zoom_label(*record));
  if (beneath != nullptr) add("dashed: " + zoom_label(*beneath));
  if (zoom.quantity != ZoomQuantity::pairs) add(zoom_trust_text(*record));  // counts have no noise
  if (zoom.running) return;
  add(zoom_status(zoom));
  blocks.push_back(block::Controls{{{"Open folder", 0, false, block::Form::small_button},
                                    {"Copy figure", 0, true, block::Form::small_button},
                                    {"The zoom as CSV"}}});
}

void add_plan(const Viewer& v, Blocks& blocks) {
  constexpr auto kSmall = block::Form::small_button;
  blocks.push_back(block::Text{zoom_start_text(v.zoom.plan)});
  blocks.push_back(block::Controls{{{"start here", 0, true, kSmall},
                                    {"this view", 0, true, kSmall},
                                    {"x closer", 5},
                                    {"end here", 0, true, kSmall},
                                    {"steps", 7},
                                    {"frames per mode and step", 7},
                                    {"size", 14},
                                    {"pipeline of the zoom", 14}}});
  block::Controls modes;
  for (CullMode mode = 1; mode <= culler_count(); ++mode)
    modes.controls.push_back({.name = fmt::format("record {}", mode_name(mode)),
                              .follows = mode > 1,
                              .short_label = mode_name(mode),
                              .mode = mode});
  blocks.emplace_back(std::move(modes));
}

void add_recordings(const ZoomRecorder& zoom, Blocks& blocks) {
  if (zoom.records.empty()) return;
  blocks.push_back(block::Line{});
  blocks.push_back(block::Text{"recordings: a click shows one", Tone::faint});
  block::Table table{"recordings",
                     {{"recording", 8, 0, 0, true},
                      {"pipeline", 3.2f, 0, 0, true},
                      {"machine", 0, 1, 0, true},
                      {"dashed", 3.6f, 0, 0, true}},
                     {}};
  table.has_head = false;
  for (std::size_t i = zoom.records.size(); i-- > 0;) {
    const ZoomRecord& record = zoom.records[i];
    std::vector<block::Cell> cells(4);
    cells[0].text = zoom_title(record);
    cells[0].tooltip = zoom_label(record);
    cells[0].use = Use{"recording", 0, i};
    cells[1].text = record.pipeline;
    cells[2].text = record.machine;
    if (zoom.shown && zoom.shown != i) {
      cells[3].text = zoom.beneath == i ? "hide" : "dashed";
      cells[3].tooltip = "draws this recording dashed under the other";
      cells[3].use = Use{"dashed recording", 0, i};
      cells[3].is_button = true;
    }
    table.rows.push_back({std::move(cells), zoom.shown == i});
  }
  blocks.emplace_back(std::move(table));
}

}  // namespace

Blocks recorder_blocks(const Viewer& v) {
  const ZoomRecorder& zoom = v.zoom;
  Blocks blocks = {
      in_line({{"Record"}, {"Save as ..."}}),
      block::Text{zoom.running ? zoom_status(zoom) : zoom_plan_text(v), Tone::plain, true}};
  add_shown(zoom, blocks);
  add_plan(v, blocks);
  add_recordings(zoom, blocks);
  return blocks;
}

}  // namespace qs
