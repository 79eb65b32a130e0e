// SPDX-License-Identifier: MIT
#include <algorithm>
#include <map>
#include <string_view>

#include <fmt/format.h>

#include "app/picture/grid_places.h"
#include "app/picture/palette.h"
#include "app/serve/served_commands.h"
#include "app/serve/state_json.h"
#include "app/session/session.h"
#include "app/viewer/commands/controls.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/hud_text.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/mode_table.h"
#include "app/viewer/state/select_actions.h"
#include "app/viewer/state/zoom_actions.h"

namespace qs {
namespace {

using Json = nlohmann::json;

// Null for a panel of the window alone.
const KeyCommand* command_of(const PanelRow& row) {
  const auto served = served_commands();
  const auto found = std::ranges::find(served, row.open, &KeyCommand::panel);
  return found == served.end() ? nullptr : *found;
}

// Most panels need a scene.
bool is_offered(const Viewer& v, const PanelRow& row) {
  if (command_of(row) == nullptr) return false;
  return row.open == &Panels::training ? v.training.has_value() : v.scene.has_value();
}

Json panels_json(const Viewer& v, std::span<const PanelRow> panels) {
  return json_list(panels, [&](const PanelRow& row) -> Json {
    if (!is_offered(v, row)) return nullptr;
    const KeyCommand& command = *command_of(row);
    return {{"name", row.name},
            {"title", command.help},
            {"key", key_name(command.key, command.mods)},
            {"open", v.panels.*row.open}};
  });
}

// ---- controls ----------------------------------------------------------------------------------
constexpr const char* kKinds[] = {"toggle", "choice", "number", "color", "button", "item"};

Json control_json(const Control& control, const ControlNow& now, const block::Placed& placed) {
  Json row = {{"name", control.name},
              {"label", placed.title.empty() ? label_of(control, now) : placed.title},
              {"kind", kKinds[static_cast<int>(control.kind)]},
              {"value", now.value},
              {"help", control.help},
              {"enabled", now.is_enabled}};
  if (control.kind == ControlKind::number) {
    row["least"] = now.least;
    row["most"] = now.most;
    row["step"] = now.step;
    row["log"] = now.is_logarithmic;
    row["typed"] = now.is_typed;
    row["decimals"] = now.decimals;
    row["unit"] = now.unit;
  }
  if (control.kind == ControlKind::choice) row["choices"] = now.choices;
  return row;
}

void add_control(const Viewer& v, const block::Placed& placed, const std::string& name,
                 Json& rows) {
  const Control* const control = find_control(name);
  if (control == nullptr) return;
  if (const auto now = control_now(v, *control))
    rows.push_back(control_json(*control, *now, placed));
}

// ---- blocks ------------------------------------------------------------------------------------
constexpr const char* kTones[] = {"", "faint", "caution"};

Json ink_json(const Ink& ink) { return {hex_text(ink.dark), hex_text(ink.light)}; }

Json key_json(const block::Key& key) { return {{"text", key.text}, {"ink", ink_json(key.ink)}}; }

Json tick_json(const BarTick& tick) { return {tick.at, tick.text}; }

Json column_json(const block::Column& column) {
  return {{"title", column.title},
          {"letters", column.letters},
          {"rank", column.rank},
          {"orders", column.is_ordering},
          {"descends", column.descends}};
}

Json cell_json(const block::Cell& cell) {
  Json json = {
      {"text", cell.text}, {"tone", kTones[static_cast<int>(cell.tone)]}, {"value", cell.value}};
  if (!cell.tooltip.empty()) json["title"] = cell.tooltip;
  if (cell.use) json["use"] = {cell.use->control, cell.use->value, cell.use->index};
  if (const auto& bar = cell.bar)
    json["bar"] = {
        {"value", bar->value}, {"low", bar->low}, {"high", bar->high}, {"ink", ink_json(bar->ink)}};
  if (!cell.parts.empty()) json["parts"] = cell.parts;
  if (cell.swatch) json["swatch"] = hex_text(*cell.swatch);
  return json;
}

Json row_json(const block::Row& row) {
  return {{"here", row.is_here}, {"cells", json_list(row.cells, cell_json)}};
}

Json item_json(const block::Item& item) {
  return {{"kind", kKinds[static_cast<int>(item.kind)]},
          {"control", item.control},
          {"label", item.label},
          {"help", find_control(item.control)->help},
          {"value", item.value},
          {"least", item.least},
          {"most", item.most}};
}

Json reading_json(const block::Reading& reading) {
  const auto row_of = [](const auto& row) { return Json::array({row.name, row.value}); };
  return {{"at", reading.x}, {"title", reading.title}, {"rows", json_list(reading.rows, row_of)}};
}

Json curve_json(const block::Curve& curve) {
  const auto point_of = [](const auto& at) -> Json {
    return {at.x, at.y, at.low, at.high, int{at.is_noisy}};
  };
  return {{"name", curve.name},
          {"ink", ink_json(curve.ink)},
          {"dashed", curve.is_dashed},
          {"bars", curve.has_bars},
          {"marked", curve.is_marked},
          {"width", curve.width},
          {"points", json_list(curve.points, point_of)}};
}

Json chart_column_json(const block::ChartColumn& column) {
  return {column.x0, column.x1, column.y, hex_text(column.color)};
}

Json shape_json(const block::Shape& shape) {
  const auto point_of = [](glm::vec2 point) -> Json { return {point.x, point.y}; };
  return {{"points", json_list(shape.points, point_of)},
          {"ink", ink_json(shape.ink)},
          {"opacity", shape.opacity},
          {"width", shape.width},
          {"box", shape.is_box}};
}

// The content of each kind of block.
struct BlockJson {
  const Viewer& viewer;

  Json operator()(const block::Text& block) const {
    return {{"kind", "text"},
            {"text", public_text(viewer, block.text)},
            {"tone", kTones[static_cast<int>(block.tone)]}};
  }
  Json operator()(const block::Line&) const { return nullptr; }
  Json operator()(const block::Facts& block) const {
    const auto row_of = [&](const Fact& fact) {
      return Json::array({fact.label, public_text(viewer, fact.value)});
    };
    return {{"kind", "facts"}, {"facts", json_list(block.facts, row_of)}};
  }
  Json operator()(const block::Progress& block) const {
    return {{"kind", "progress"}, {"what", block.what}, {"share", block.share}};
  }
  Json operator()(const block::Controls& block) const {
    Json rows = Json::array();
    for (const block::Placed& placed : block.controls) {
      if (placed.form != block::Form::range) add_control(viewer, placed, placed.name, rows);
      if (placed.form == block::Form::range)
        for (const char* end : {", from", ", to"})
          add_control(viewer, placed, placed.name + end, rows);
    }
    return {{"kind", "controls"}, {"rows", rows}};
  }
  Json operator()(const block::Keys& block) const {
    return {{"kind", "keys"}, {"keys", json_list(block.keys, key_json)}};
  }
  Json operator()(const block::ColorBar& block) const {
    constexpr int kColors = 33;
    Json colors = Json::array();
    for (int i = 0; i < kColors; ++i)
      colors.push_back(hex_text(block.legend.color(static_cast<float>(i) / (kColors - 1))));
    return {{"kind", "colorbar"},
            {"title", block.legend.title},
            {"ticks", json_list(block.legend.ticks, tick_json)},
            {"colors", colors}};
  }
  Json operator()(const block::Table& block) const {
    return {{"kind", "table"},
            {"name", block.name},
            {"columns", json_list(block.columns, column_json)},
            {"rows", json_list(block.rows, row_json)},
            {"keys", json_list(block.keys, key_json)},
            {"caption", block.caption},
            {"head", block.has_head},
            {"scrolls", block.most_lines > 0},
            {"busy", block.is_busy}};
  }
  Json operator()(const block::List& block) const {
    constexpr std::size_t kMost = 2000;
    Json labels = Json::array();
    for (std::size_t i = 0; i < std::min(block.count, kMost); ++i) labels.push_back(block.label(i));
    return {{"kind", "list"},
            {"labels", labels},
            {"chosen", block.chosen ? Json(*block.chosen) : Json()},
            {"control", block.control}};
  }
  Json operator()(const block::Items& block) const {
    const auto row_of = [](const auto& items) { return json_list(items, item_json); };
    return {{"kind", "items"}, {"rows", json_list(block.rows, row_of)}};
  }
  Json operator()(const block::Chart& block) const {
    const auto reading_at = [&](const block::ChartPoint& point) -> Json {
      const auto reading = block.reading(point.x);
      return reading ? reading_json(*reading) : Json();
    };
    Json readings = Json::array();
    if (block.reading && !block.curves.empty())
      readings = json_list(block.curves.back().points, reading_at);
    return {{"kind", "chart"},
            {"title", block.title},
            {"axis", block.axis},
            {"letters", block.letters},
            {"across", json_list(block.across, tick_json)},
            {"up", json_list(block.up, tick_json)},
            {"curves", json_list(block.curves, curve_json)},
            {"columns", json_list(block.columns, chart_column_json)},
            {"readings", readings}};
  }
  Json operator()(const block::Figure& block) const {
    return {{"kind", "figure"},
            {"name", block.name},
            {"low", {block.low.x, block.low.y}},
            {"high", {block.high.x, block.high.y}},
            {"shapes", json_list(block.shapes, shape_json)}};
  }
  Json operator()(const block::Plot& block) const {
    return {{"kind", "plot"}, {"values", block.values}, {"caption", block.caption}};
  }
  Json operator()(block::Local) const { return nullptr; }
};

// ---- over the picture --------------------------------------------------------------------------
Json divider_json(const Viewer& v) {
  if (!v.panels.split || v.shows_grid || !v.shown.other) return nullptr;
  return {{"names", split_names(v)},
          {"view", kSplitViews[static_cast<int>(v.split.view)]},
          {"sides", v.split.view == SplitView::sides},
          {"divider", v.split.divider}};
}

Json grid_json(const Viewer& v) {
  if (!v.shown.grid) return nullptr;
  const GridPlaces places = grid_places(culler_count(), kGridLabel);
  const auto label_of = [&](CullMode mode) -> Json {
    const glm::vec2 low = places.low(mode - 1);
    return {{"mode", mode_name(mode)},
            {"color", hex_text(on_dark::mode_color(mode))},
            {"text", grid_label(v, mode)},
            {"x", low.x},
            {"y", low.y},
            {"here", mode == v.mode()}};
  };
  return {{"labels", json_list(all_modes(), label_of)},
          {"side", places.side},
          {"columns", places.columns}};
}

// A line of each ruler and a cross at each point, and their texts.
void add_rulers(const Viewer& v, std::vector<PictureLine>& lines,
                std::vector<std::pair<glm::dvec2, std::string>>& labels) {
  const auto add = [&](glm::dvec3 from, glm::dvec3 to, const std::string& text) {
    const auto line = line_in_picture(v.camera, from, to);
    if (line) labels.emplace_back(0.5 * (line->from + line->to), text);
    return line;
  };
  for (const Ruler& ruler : rulers_of(v))
    if (const auto line = add(ruler.from.position, ruler.to.position, ruler.text))
      lines.push_back(*line);
  int number = 0;
  constexpr double kArm = 7;  // pixels
  for (const auto& points : v.measures.lines)
    for (const SurfacePoint& point : points)
      if (const auto at = add(point.position, point.position, std::to_string(++number)))
        for (const glm::dvec2 arm : {glm::dvec2(kArm, 0), glm::dvec2(0, kArm)})
          lines.push_back({at->from - arm, at->from + arm});
}

// The box of the crop, the shape of a selecting tool, the cross of the arrow keys and rulers, as
// shares of the picture's width and height.
Json box_json(const Viewer& v) {
  const bool boxed = v.panels.crop && v.crop.wish.boxed;
  std::vector<PictureLine> lines = shape_lines(v);
  std::vector<std::pair<glm::dvec2, std::string>> labels;
  if (v.panels.measures) add_rulers(v, lines, labels);
  if (v.cross)
    for (const glm::dvec2 arm : {glm::dvec2(12, 0), glm::dvec2(0, 12)})
      lines.push_back({*v.cross - arm, *v.cross + arm});
  if (!boxed && lines.empty()) return nullptr;
  const Camera& camera = v.camera;
  const auto place = [&](glm::dvec2 pixel) {
    constexpr double kMost = 1e4;
    const glm::dvec2 share = (pixel + 0.5) / glm::dvec2(camera.width, camera.height);
    return Json{std::clamp(share.x, -kMost, kMost), std::clamp(share.y, -kMost, kMost)};
  };
  const auto line_of = [&](const PictureLine& line) {
    return Json{place(line.from), place(line.to)};
  };
  Json handles = Json::array();
  for (int face = 0; boxed && face < kBoxFaces; ++face) {
    const auto pixel = handle_in_picture(camera, v.crop.wish.box, face);
    handles.push_back(pixel ? place(*pixel) : Json());
  }
  if (boxed) std::ranges::copy(box_lines(camera, v.crop.wish.box), std::back_inserter(lines));
  const auto label_of = [&](const auto& label) { return Json{place(label.first), label.second}; };
  return {{"lines", json_list(lines, line_of)},
          {"handles", handles},
          {"labels", json_list(labels, label_of)}};
}

Json job_json(const Viewer& v) {
  if (v.zoom.running)
    return {{"words", "recording a zoom: " + zoom_status(v.zoom)}, {"share", nullptr}};
  if (v.zoom.starting)
    return {{"words", "recording a zoom: waits for its turn"}, {"share", nullptr}};
  if (!v.loading) return nullptr;
  return {{"words", v.loading->what}, {"share", v.loading->fraction}};
}

Json status_json(const Viewer& v) {
  const StatusLine line = status_line(v);
  return {{"numbers", line.numbers},
          {"note", line.note},
          {"faint", line.faint},
          {"caution", line.caution}};
}

// The words over a picture without the chosen heat map; they cover a picture with another map.
Json awaited_json(const Viewer& v) {
  if (!awaited_map(v)) return nullptr;
  return {{"text", fmt::format("{}: {}", awaited_title(v), kComputing)},
          {"covers", v.shown.heatmap.has_value()}};
}

// The viewer does not know that other visitors are measured before this one.
void tell_waiting(const Visitor& visitor, Json& sections) {
  const auto status = sections.find("table/text");
  if (status == sections.end() || visitor.measuring() != Measuring::waits ||
      numbers_are_current(visitor.viewer()))
    return;
  *status = {
      {"kind", "text"},
      {"text", "not measured yet: the renderer still draws pictures, and the visitors take turns"},
      {"tone", "caution"}};
}

}  // namespace

Json to_json(const Block& block, const Viewer& viewer) {
  return std::visit(BlockJson{viewer}, block);
}

Json panel_sections(const Visitor& visitor, std::span<const PanelRow> panels) {
  const Viewer& v = visitor.viewer();
  Json sections = {{"panels", panels_json(v, panels)},
                   {"divider", divider_json(v)},
                   {"grid", grid_json(v)},
                   {"box", box_json(v)},
                   {"job", job_json(v)},
                   {"awaited", awaited_json(v)},
                   {"status", status_json(v)}};
  for (const PanelRow& row : panels) {
    if (command_of(row) == nullptr) continue;  // the window's alone
    sections[row.name] = nullptr;
    if (!(v.panels.*row.open) || !is_offered(v, row)) continue;
    Json names = Json::array();
    std::map<std::string, int> counts;
    for (const Block& block : row.blocks(v)) {
      Json content = to_json(block, v);
      if (content.is_null()) continue;
      std::string name = content.at("kind");
      if (const int count = ++counts[name]; count > 1) name += fmt::format("{}", count);
      name = fmt::format("{}/{}", row.name, name);
      sections[name] = std::move(content);
      names.push_back(std::move(name));
    }
    sections[row.name] = std::move(names);
  }
  tell_waiting(visitor, sections);
  return sections;
}

std::string public_text(const Viewer& v, std::string text) {
  const std::string path = v.scene ? v.scene->path.string() : "";
  for (std::size_t at = path.empty() ? text.npos : text.find(path); at != text.npos;
       at = text.find(path, at + v.scene->name.size()))
    text.replace(at, path.size(), v.scene->name);
  constexpr std::string_view kBounds = " \t\n\"'(),:;";
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find_first_of(kBounds, begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const std::size_t slash = word.find_last_of('/');
    const bool is_path = word.size() > 1 && slash != word.npos &&
                         (word.starts_with('/') || word.starts_with('.') || word.starts_with('~'));
    result += is_path ? word.substr(slash + 1) : word;
    if (end < text.size()) result += text[end];
    begin = end + 1;
  }
  return result;
}

}  // namespace qs
