// SPDX-License-Identifier: MIT
#include "app/viewer/commands/controls.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <iterator>
#include <span>
#include <type_traits>

#include <fmt/format.h>

#include "app/picture/palette.h"
#include "app/report/bench_report.h"
#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/crop_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/kept_work.h"
#include "app/viewer/state/measure_actions.h"
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/mode_table.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/select_actions.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/zoom_actions.h"
#include "base/list_of.h"

namespace qs {
namespace {

using enum ControlKind;

using Now = std::optional<ControlNow>;
using NowOf = std::function<Now(const Viewer&)>;
using When = std::function<bool(const Viewer&)>;
using Controls = std::vector<Control>;

// ---- values ------------------------------------------------------------------------------------
template <class Value>
ControlNow at(Value value, ControlNow shape = {}) {
  shape.value = static_cast<double>(value);
  return shape;
}

template <class Index = int>
ControlNow chosen(std::vector<std::string> choices, Index index = {}) {
  return {.value = static_cast<double>(index), .choices = std::move(choices)};
}

ControlNow between(double least, double most, double step = 0) { return {0, least, most, step}; }

ControlNow logarithmic(double least, double most, int decimals) {
  return {.least = least, .most = most, .is_logarithmic = true, .decimals = decimals};
}

ControlNow typed(ControlNow now) {
  now.is_typed = true;
  return now;
}

template <class Names>
std::vector<std::string> names_in(const Names& names) {
  return {std::begin(names), std::end(names)};
}

std::vector<std::string> mode_names(CullMode first, CullMode last) {
  std::vector<std::string> names;
  for (CullMode mode = first; mode <= last; ++mode) names.emplace_back(mode_name(mode));
  return names;
}

std::size_t index_of(double value) { return static_cast<std::size_t>(value); }

// The index of a value in a list; 0 for other values.
template <class Values, class Value>
std::size_t index_in(const Values& values, const Value& value) {
  const auto found = std::ranges::find(values, value);
  return static_cast<std::size_t>(found - std::begin(values)) % std::size(values);
}

// ---- rows --------------------------------------------------------------------------------------
// A control whose value is passed to `set`, a function that call() takes.
template <class Value, class Function>
Control value_row(std::string name, ControlKind kind, NowOf now, Function set,
                  std::string help = "") {
  return {std::move(name), kind, std::move(now),
          [set](double value, std::size_t) { return call(set, static_cast<Value>(value)); },
          std::move(help)};
}

// A part of the viewer that controls change one field at a time.
template <class Type>
struct Part {
  const Type& (*of)(const Viewer& viewer);
  void (*take)(Viewer& viewer, const Type& part);
};

// A control with its value now and its change of a part.
template <class Type>
Control part_row(const Part<Type>& part, std::string name, ControlKind kind, NowOf now,
                 std::type_identity_t<std::function<void(Type&, double)>> change,
                 std::string help = "") {
  const auto set = [part, change = std::move(change)](Viewer& v, double value) {
    Type copy = part.of(v);
    change(copy, value);
    part.take(v, copy);
  };
  return value_row<double>(std::move(name), kind, std::move(now), set, std::move(help));
}

// A control of one field: a member, or a function that returns a reference to it. `shape`: of the
// control, without its value.
template <class Type, class Field>
Control field_row(const Part<Type>& part, std::string name, ControlKind kind, Field field,
                  ControlNow shape = {}, std::string help = "") {
  return part_row(
      part, std::move(name), kind,
      [part, field, shape = std::move(shape)](const Viewer& v) {
        Type copy = part.of(v);
        return at(std::invoke(field, copy), shape);
      },
      [field](Type& copy, double value) {
        auto& place = std::invoke(field, copy);
        place = static_cast<std::remove_reference_t<decltype(place)>>(value);
      },
      std::move(help));
}

// A switch. `set` takes its new state.
template <class Function>
Control switch_row(std::string name, When is_on, Function set, std::string help = "") {
  return value_row<bool>(
      std::move(name), toggle, [is_on = std::move(is_on)](const Viewer& v) { return at(is_on(v)); },
      set, std::move(help));
}

Control button_row(std::string name, Action action, std::string help = "") {
  return {std::move(name), button, [](const Viewer&) { return ControlNow(); },
          [action = std::move(action)](double, std::size_t) { return action; }, std::move(help)};
}

// A button that does what a command does.
Control command_row(std::string name, const char* command) {
  return button_row(std::move(name), find_command(command)->action, command_hint(command));
}

// A part of rows of lists. `set` takes the row's index, and the value if the part has one.
template <class... Value>
Control item_row(const char* name, auto set, std::string help = "") {
  return {name, item, [](const Viewer&) { return ControlNow(); },
          [set]([[maybe_unused]] double value, std::size_t i) {
            return call(set, i, static_cast<Value>(value)...);
          },
          std::move(help)};
}

// The control is of no use in other states.
Control only_if(When when, Control row) {
  row.now = [when = std::move(when), now = std::move(row.now)](const Viewer& v) {
    return when(v) ? now(v) : Now();
  };
  return row;
}

// Changes the appearance of a control that is of use.
template <class Change>
Control shown(Change change, Control row) {
  row.now = [change, now = std::move(row.now)](const Viewer& v) {
    Now result = now(v);
    if (result) change(*result, v);
    return result;
  };
  return row;
}

Control gray_unless(When when, Control row) {
  return shown(
      [when = std::move(when)](ControlNow& now, const Viewer& v) { now.is_enabled = when(v); },
      std::move(row));
}

// The label in place of the name.
Control labelled(std::function<const char*(const Viewer&)> label, Control row) {
  return shown(
      [label = std::move(label)](ControlNow& now, const Viewer& v) { now.text = label(v); },
      std::move(row));
}

void add(Controls& rows, Controls more) {
  std::move(more.begin(), more.end(), std::back_inserter(rows));
}

// ---- the table of modes ------------------------------------------------------------------------
// A window copies the table, a user at another machine gets a file.
void give_table(Viewer& v, Host& host, TableFormat format) {
  if (v.is_remote) {
    constexpr const char* kEndings[] = {".csv", ".md", ".tex"};
    return host.send_file(v.scene->name + "_modes" + kEndings[static_cast<int>(format)],
                          std::make_shared<const std::string>(table_text(v, format)));
  }
  if (v.numbers.rows.empty())
    return action::notify(v, "there is nothing to copy: no mode is measured yet");
  host.set_clipboard(table_text(v, format));
  action::notify(v, fmt::format("copied the table of modes as {}: {}",
                                kTableFormats[static_cast<int>(format)], table_caption(v)));
}

// Measures all modes at another size, an index into kMeasuredSizes.
void set_measured_size(Viewer& v, std::size_t index) {
  if (index == v.measured_size) return;
  v.measured_size = index;
  v.numbers = {};
  v.counts = {};
  action::picture_changed(v);  // the next frame counts at this size
}

void choose_mode(Viewer& v, std::size_t mode) {
  if (mode > 0 && mode <= static_cast<std::size_t>(culler_count()))
    action::set_mode(v, static_cast<CullMode>(mode));
}

Controls table_controls() {
  Controls rows = {
      value_row<std::size_t>(
          "measure at", choice,
          [](const Viewer& v) {
            std::vector<std::string> names =
                list_of<std::string>(kMeasuredSizes, &MeasuredSize::name);
            for (std::size_t i = 0; i < names.size(); ++i) {
              const glm::ivec2 size = measured_size(v, i);
              if (kMeasuredSizes[i].pixels.x == 0 && size.x > 0)
                names[i] += fmt::format(" ({} x {})", size.x, size.y);
            }
            return chosen(names, v.measured_size);
          },
          set_measured_size),
      value_row<CullMode>(
          "ratios to", choice,
          [](const Viewer& v) { return chosen(mode_names(1, culler_count()), v.baseline - 1); },
          [](Viewer& v, CullMode index) { action::set_baseline(v, index + 1); }),
      item_row("mode", choose_mode)};
  for (std::size_t i = 0; i < std::size(kTableFormats); ++i)
    rows.push_back(only_if([](const Viewer& v) { return !v.is_remote || !v.numbers.rows.empty(); },
                           button_row(fmt::format("The table as {}", kTableFormats[i]),
                                      call(give_table, static_cast<TableFormat>(i)))));
  return rows;
}

// ---- settings ----------------------------------------------------------------------------------
constexpr Part<RenderSettings> kSettings = {
    [](const Viewer& v) -> const RenderSettings& { return v.settings; }, action::change_settings};

bool has_pipelines(const Viewer& v) { return pipelines_of(v.backend).size() > 1; }

bool has_huge(const Viewer& v) { return !v.is_remote && v.scene->huge + v.scene->skipped_huge > 0; }

Controls settings_controls() {
  return {
      part_row(
          kSettings, "SH degree", number,
          [](const Viewer& v) {
            const int most = v.scene->sh_degree;
            return at(std::min(v.settings.sh_degree, most), between(0, most, 1));
          },
          [](RenderSettings& part, double value) { part.sh_degree = static_cast<int>(value); }),
      field_row(kSettings, "splat scale", number, &RenderSettings::splat_scale,
                logarithmic(0.01, 3, 2), command_hint("Larger splats")),
      field_row(kSettings, "style", choice, &RenderSettings::style,
                chosen(names_in(kDrawStyleNames)), "the shape that stands for a Gaussian"),
      part_row(
          kSettings, "background", color,
          [](const Viewer& v) { return at(hex_of(v.settings.background)); },
          [](RenderSettings& part, double value) {
            part.background = rgb(static_cast<std::uint32_t>(value));
          }),
      part_row(
          kSettings, "antialias", choice,
          [](const Viewer& v) {
            const auto& wish = v.settings.antialiased;
            return chosen({"as trained", "on", "off"}, wish ? (*wish ? 1 : 2) : 0);
          },
          [](RenderSettings& part, double value) {
            part.antialiased = value == 0 ? std::nullopt : std::optional(value == 1);
          }),
      value_row<std::size_t>(
          "backend", choice,
          [](const Viewer& v) {
            const auto all = available_backends();
            const auto name = [](Backend each) { return kBackendNames[static_cast<int>(each)]; };
            return chosen(list_of<std::string>(all, name), index_in(all, v.backend));
          },
          [](Viewer& v, Host& host, std::size_t index) {
            action::change_backend(v, host, available_backends()[index]);
          }),
      only_if(has_pipelines, field_row(kSettings, "pipeline", choice, &RenderSettings::pipeline,
                                       chosen(names_in(kPipelineNames)))),
      only_if(has_huge, switch_row(
                            "leave out what is larger than the scene",
                            [](const Viewer& v) { return v.skips_huge; }, action::skip_huge)),
  };
}

// ---- heat maps ---------------------------------------------------------------------------------
std::vector<std::string> heat_choices() {
  std::vector<std::string> names = {"none"};
  for (std::size_t i = 0; i < kHeatQuantities; ++i)
    names.push_back(
        fmt::format(fmt::runtime(heatmap_row(static_cast<HeatQuantity>(i)).title), kTileSize));
  return names;
}

void choose_heatmap(Viewer& v, std::size_t index) {
  if (index > 0) return action::show_heatmap(v, static_cast<HeatQuantity>(index - 1));
  v.heatmap.reset();
  action::picture_changed(v);
}

// The window colours its picture itself, other pictures are drawn again.
void restyle_heatmap(Viewer& v, const HeatView& view) {
  action::change_heat_view(v, view);
  if (v.is_remote) action::picture_changed(v);
}

constexpr Part<HeatView> kHeat = {[](const Viewer& v) -> const HeatView& { return v.heat_view; },
                                  restyle_heatmap};

ControlNow opacity_now(const Viewer& v) {
  const float percent = 100 * v.heat_view.style.opacity;
  return at(std::round(percent), {.most = 100, .step = 1, .unit = " %"});
}

bool has_heatmap(const Viewer& v) { return v.heatmap.has_value(); }

Controls heat_controls() {
  Controls rows = {
      value_row<std::size_t>(
          "Heat map", choice,
          [](const Viewer& v) {
            return chosen(heat_choices(), v.heatmap ? static_cast<int>(*v.heatmap) + 1 : 0);
          },
          choose_heatmap),
      only_if(has_heatmap, part_row(kHeat, "opacity over the colours", number, opacity_now,
                                    [](HeatView& view, double value) {
                                      view.style.opacity = static_cast<float>(value / 100);
                                    })),
      only_if(has_heatmap, field_row(
                               kHeat, "colour map", choice,
                               [](HeatView & view) -> auto& { return view.style.colors; },
                               chosen(names_in(kHeatColors)))),
      value_row<Quantity>(
          "Picture of", choice,
          [](const Viewer& v) { return chosen(quantity_names(), v.quantity); },
          action::show_quantity),
      gray_unless([](const Viewer& v) { return v.backend == Backend::cpu; },
                  switch_row(
                      "Draw smaller while moving (CPU)",
                      [](const Viewer& v) { return v.reduce_when_moving; },
                      [](Viewer& v, bool is_on) { v.reduce_when_moving = is_on; })),
      gray_unless(
          [](const Viewer& v) { return v.backend == Backend::cuda; },
          switch_row(
              "Leave out hidden Gaussians (GPU)", [](const Viewer& v) { return v.occlusion; },
              [](Viewer& v, bool is_on) {
                v.occlusion = is_on;
                ++v.version;
              },
              "In views of many millions of Gaussians the picture is the same, and drawn "
              "sooner. The table of modes is always measured with all Gaussians."))};
  for (Control& row : std::span(rows).last(2)) row.without_scene = true;
  return rows;
}

// ---- split -------------------------------------------------------------------------------------
// The window moves its divider over the same frames, other pictures are drawn again.
void change_shown_split(Viewer& v, const Split& split) {
  const bool redraws = v.is_remote && split.other == v.split.other;
  action::change_split(v, split);
  if (redraws) action::picture_changed(v);
}

constexpr Part<Split> kSplit = {[](const Viewer& v) -> const Split& { return v.split; },
                                change_shown_split};

// The window computes the reference on demand.
CullMode first_beside(const Viewer& v) { return v.is_remote ? 1 : kReferenceMode; }

// All ways to draw a mode.
std::vector<Variant> ways_to_draw(CullMode mode) {
  std::vector<Variant> ways;
  for (const Backend backend : available_backends()) {
    for (const Pipeline pipeline : pipelines_of(backend)) ways.push_back({mode, pipeline, backend});
  }
  return ways;
}

Now ways_now(const Viewer& v) {
  const std::vector<Variant> ways = ways_to_draw(v.split.other.mode);
  if (ways.size() < 2 || v.split.other.mode == kReferenceMode) return {};
  const std::vector<std::string> names = list_of<std::string>(ways, drawn_by);
  return chosen(names, index_in(names, drawn_by(v.split.other)));
}

constexpr int kAmplifications[] = {0, 1, 2, 4, 8, 16, 32, 64, 128};

ControlNow amplification_now(const Viewer& v) {
  std::vector<std::string> names =
      list_of<std::string>(kAmplifications, [](int factor) { return std::to_string(factor); });
  names[0] = fmt::format("{}, automatic", shown_amplification(v));
  return chosen(names, index_in(kAmplifications, v.split.amplification));
}

When shows_as(SplitView view) {
  return [view](const Viewer& v) { return v.split.view == view; };
}

Controls split_controls() {
  return {
      value_row<CullMode>(
          "beside", choice,
          [](const Viewer& v) {
            const CullMode first = first_beside(v);
            return chosen(mode_names(first, mode_count()),
                          std::max<CullMode>(v.split.other.mode - first, 0));
          },
          [](Viewer& v, CullMode index) {
            Split split = v.split;
            split.other.mode = index + first_beside(v);
            change_shown_split(v, split);
          }),
      part_row(kSplit, "drawn by", choice, ways_now,
               [](Split& split, double value) {
                 split.other = ways_to_draw(split.other.mode)[index_of(value)];
               }),
      field_row(kSplit, "view", choice, &Split::view, chosen(names_in(kSplitViews)),
                command_hint("Next view of the split")),
      only_if(shows_as(SplitView::sides),
              field_row(kSplit, "divider", number, &Split::divider, between(0, 1, 0.01))),
      only_if(shows_as(SplitView::difference),
              part_row(kSplit, "differences times", choice, amplification_now,
                       [](Split& split, double value) {
                         split.amplification = kAmplifications[index_of(value)];
                       })),
      only_if(
          [](const Viewer& v) {
            return v.split.view == SplitView::sides || v.split.view == SplitView::whole;
          },
          part_row(
              kSplit, "Flip", button, [](const Viewer&) { return ControlNow(); },
              [](Split& split, double) { split.flipped = !split.flipped; },
              command_hint("Flip the split"))),
      only_if([](const Viewer& v) { return v.beside.has_value(); },
              command_row("Close the scene beside", "Open or close a scene beside")),
  };
}

// ---- crop and clean ----------------------------------------------------------------------------
constexpr Part<CropWish> kCrop = {[](const Viewer& v) -> const CropWish& { return v.crop.wish; },
                                  action::change_crop};

bool is_boxed(const Viewer& v) { return v.crop.wish.boxed; }

Controls box_controls() {
  Controls rows = {field_row(kCrop, "Box", toggle, &CropWish::boxed)};
  constexpr const char* kAxes[] = {"x right", "y down", "z forward"};
  constexpr double kMost = 1e6;
  const ControlNow shape{.least = -kMost, .most = kMost, .is_typed = true, .decimals = 3};
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool low : {true, false}) {
      const auto end = low ? &CropBox::low : &CropBox::high;
      rows.push_back(only_if(
          is_boxed,
          field_row(
              kCrop, fmt::format("{}, {}", kAxes[axis], low ? "from" : "to"), number,
              [ axis, end ](CropWish & wish) -> auto& { return (wish.box.*end)[axis]; }, shape)));
    }
  }
  add(rows, {only_if(is_boxed, button_row("Fit", call(action::fit_crop_box),
                                          "The box around the scene's subject")),
             only_if(is_boxed, button_row("Show all", call(action::show_crop_box),
                                          "Moves the camera until the whole box is visible"))});
  return rows;
}

// A criterion of floaters: its switch, and its limit while it is on.
template <class Limit>
Controls floater_controls(const char* name, bool Floaters::*is_on, const char* help,
                          const char* limit_name, Limit Floaters::*limit, ControlNow shape) {
  return {
      only_if([](const Viewer& v) { return v.crop.wish.cleans; },
              field_row(
                  kCrop, name,
                  toggle, [is_on](CropWish & wish) -> auto& { return wish.floaters.*is_on; }, {},
                  help)),
      only_if(
          [is_on](const Viewer& v) { return v.crop.wish.cleans && v.crop.wish.floaters.*is_on; },
          field_row(
              kCrop, limit_name,
              number, [limit](CropWish & wish) -> auto& { return wish.floaters.*limit; }, shape))};
}

// ---- selecting ---------------------------------------------------------------------------------
constexpr Part<Selecting> kSelecting = {
    [](const Viewer& v) -> const Selecting& { return v.selecting; },
    [](Viewer& v, const Selecting& selecting) { v.selecting = selecting; }};

bool has_selection(const Viewer& v) { return v.editing.selected != nullptr; }

bool has_tool(const Viewer& v) { return v.selecting.tool.has_value(); }

bool draws(const Viewer& v) { return has_tool(v) && draws_in_picture(*v.selecting.tool); }

// The limits of a value, and the button that selects by it.
Controls value_controls(const char* value, ValueRange Selecting::*range, SelectTool tool,
                        double most, const char* help) {
  Controls rows;
  for (const bool low : {true, false}) {
    const auto end = low ? &ValueRange::low : &ValueRange::high;
    rows.push_back(field_row(
        kSelecting, fmt::format("by {}, {}", value, low ? "from" : "to"), number,
        [ range, end ](Selecting & selecting) -> auto& { return selecting.*range.*end; },
        typed({.most = most, .decimals = 4}), help));
  }
  rows.push_back(
      button_row(fmt::format("Select by {}", value), call(action::select_by_value, tool), help));
  return rows;
}

Controls select_controls() {
  std::vector<std::string> tools = {"nothing: drags move the view"};
  for (const SelectTool tool : kPictureTools)
    tools.emplace_back(kSelectToolNames[static_cast<std::size_t>(tool)]);
  const auto tool_now = [tools](const Viewer& v) {
    const double at = v.selecting.tool
                          ? 1.0 + static_cast<double>(index_in(kPictureTools, *v.selecting.tool))
                          : 0;
    return ControlNow{.value = at, .choices = tools};
  };
  const auto choose = [](Viewer& v, int chosen) {
    action::choose_tool(v, chosen == 0 ? std::nullopt : std::optional(kPictureTools[chosen - 1]));
  };
  const auto by = [](const char* name, SelectTool tool, const char* help) {
    return button_row(name, call(action::select_by, tool), help);
  };
  Controls rows = {
      value_row<int>("Select with", choice, tool_now, choose, "drag over the picture"),
      only_if(has_tool, field_row(kSelecting, "how", choice, &Selecting::way,
                                  {.choices = names_in(kSelectHowNames)},
                                  "Shift adds, Ctrl takes away, both keep the common part")),
      only_if(draws, field_row(kSelecting, "selects", choice, &Selecting::kind,
                               {.choices = names_in(kSelectKindNames)},
                               "visible: at least this weight at a pixel; touching: any "
                               "weight; through: by the centre, hidden ones too")),
      only_if([](const Viewer& v) { return draws(v) && v.selecting.kind == SelectKind::visible; },
              field_row(kSelecting, "weight", number, &Selecting::weight, logarithmic(0.004, 1, 3),
                        "alpha times the transmittance in front")),
      only_if([](const Viewer& v) { return v.selecting.tool == SelectTool::brush; },
              field_row(kSelecting, "brush", number, &Selecting::brush_px, logarithmic(1, 500, 0),
                        "radius in pixels")),
      by("All", SelectTool::all, "Select all Gaussians"),
      by("Nothing", SelectTool::none, "Select no Gaussian"),
      by("Invert", SelectTool::invert, "Select the other Gaussians"),
      by("Grow", SelectTool::grow, "Adds the neighbours of the selection"),
      by("Shrink", SelectTool::shrink, "Takes away the border of the selection"),
      only_if(
          [](const Viewer& v) { return v.selecting.tool == SelectTool::color || has_selection(v); },
          field_row(kSelecting, "tolerance", number, &Selecting::tolerance,
                    logarithmic(0.5, 100, 1), "of colours, in CIELAB")),
      by("Same colour", SelectTool::flood, "Grows through Gaussians of the selection's colour"),
      gray_unless(has_selection, command_row("Remove", "Remove the selected Gaussians")),
      gray_unless(has_selection, command_row("Keep only", "Keep only the selected Gaussians")),
      gray_unless(has_selection, command_row("Hide", "Hide the selected Gaussians")),
      gray_unless(
          [](const Viewer& v) {
            return v.editing.pages || !v.editing.history.state().hidden.empty();
          },
          command_row("Show hidden", "Show hidden Gaussians again")),
      gray_unless([](const Viewer& v) { return v.editing.history.can_undo(); },
                  command_row("Undo", "Undo")),
      gray_unless([](const Viewer& v) { return v.editing.history.can_redo(); },
                  command_row("Redo", "Redo")),
      only_if([](const Viewer& v) { return v.editing.history.has_steps(); },
              command_row("Save the edits", "Save the edits"))};
  add(rows, value_controls("opacity", &Selecting::opacity, SelectTool::opacity, 1, "0 to 1"));
  add(rows, value_controls("size", &Selecting::size, SelectTool::size, 1e7,
                           "the longest standard deviation, world units"));
  add(rows, value_controls("distance", &Selecting::distance, SelectTool::distance, 1e7,
                           "of the centres from the last measured point, world units"));
  return rows;
}

// ---- measuring ---------------------------------------------------------------------------------
constexpr Part<PointMeasures> kMeasuring = {
    [](const Viewer& v) -> const PointMeasures& { return v.measures; },
    [](Viewer& v, const PointMeasures& measuring) { v.measures = measuring; }};

Controls measure_controls() {
  const auto points = [](std::size_t least) {
    return [least](const Viewer& v) { return v.measures.points() >= least; };
  };
  return {
      switch_row(
          "Set points", [](const Viewer& v) { return v.measures.picks; }, action::pick_points,
          "a click in the picture sets a point on the surface there"),
      gray_unless(
          points(1),
          switch_row(
              "Second view", [](const Viewer& v) { return v.measures.again; }, action::pick_again,
              "the next click shows the last point in another view: both lines of sight "
              "cross there")),
      gray_unless(points(1), button_row("New line", call(action::end_line),
                                        "the next point begins a new line")),
      gray_unless(points(1), button_row("Remove the last point", call(action::remove_last_point))),
      gray_unless(points(1), button_row("Clear", call(action::clear_measures))),
      gray_unless(points(1), command_row("Copy", "Copy the measures")),
      gray_unless(points(1), button_row("Save the measures", call(action::save_measures, Action()),
                                        "as a file that the window and the page read")),
      gray_unless(has_selection,
                  button_row("Measure the selection", call(action::measure_selection),
                             "the sides of the box of the selected Gaussians")),
      field_row(kMeasuring, "known length", number, &PointMeasures::known,
                typed({.least = 1e-6, .most = 1e6, .decimals = 4}), "of the last two points"),
      field_row(kMeasuring, "unit", choice, &PointMeasures::unit, chosen(names_in(kLengthUnits))),
      gray_unless(points(2), button_row("Set the scale", call(action::set_scale),
                                        "lengths are shown in the unit; the scene stays as it is")),
      gray_unless(points(3), button_row("Set the ground", call(action::set_ground),
                                        "the last three points are level: up is their side"))};
}

Controls crop_controls() {
  Controls rows = box_controls();
  add(rows, select_controls());
  rows.push_back(field_row(kCrop, "Floaters", toggle, &CropWish::cleans));
  add(rows, floater_controls("faint", &Floaters::faint, "less opaque than this", "opacity",
                             &Floaters::least_opacity, logarithmic(0.004, 1, 3)));
  add(rows, floater_controls("large", &Floaters::large,
                             "a standard deviation longer than this part of the scene's core",
                             "of the core", &Floaters::largest_size, logarithmic(0.005, 2, 3)));
  add(rows,
      floater_controls("isolated", &Floaters::isolated, "fewer neighbours than this around it",
                       "neighbours", &Floaters::fewest_neighbours, between(1, 200, 1)));
  add(rows,
      {switch_row(
           "Tint what goes", [](const Viewer& v) { return v.crop.marks; }, action::mark_removed),
       gray_unless(
           [](const Viewer& v) { return v.crop.wish.removes(); },
           button_row("Apply", call(action::apply_crop), command_hint("Apply or undo the crop"))),
       // The window asks for a file.
       only_if([](const Viewer& v) { return v.is_remote && v.editing.gone; },
               button_row("Save the cropped scene",
                          call(action::save_crop, std::filesystem::path(), Action())))});
  return rows;
}

// ---- the zoom recorder -------------------------------------------------------------------------
constexpr Part<ZoomPlan> kPlan = {[](const Viewer& v) -> const ZoomPlan& { return v.zoom.plan; },
                                  action::change_zoom_plan};

std::string size_text(const Viewer& v, glm::ivec2 size) {
  if (size.x > 0) return fmt::format("{} x {}", size.x, size.y);
  const Camera camera = measured_camera(v);
  return fmt::format("as the table, {} x {}", camera.width, camera.height);
}

bool records_mode(const ZoomPlan& plan, CullMode mode) {
  return std::ranges::count(zoom_modes(plan), mode) > 0;
}

// The last mode cannot be switched off.
void switch_mode(ZoomPlan& plan, CullMode mode, bool is_on) {
  std::vector<CullMode> modes = zoom_modes(plan);
  if (is_on && !records_mode(plan, mode)) modes.push_back(mode);
  if (!is_on && modes.size() > 1) std::erase(modes, mode);
  plan.modes = modes;
}

bool records_nothing(const Viewer& v) { return !v.zoom.running; }

Controls plan_controls() {
  Controls rows = {
      field_row(kPlan, "x closer", number, &ZoomPlan::closer,
                typed(logarithmic(kLeastCloser, kMostCloser, 1)),
                "the camera moves straight to the point in the middle of the first picture"),
      field_row(kPlan, "steps", number, &ZoomPlan::steps,
                typed(between(kFewestZoomSteps, kMostZoomSteps, 1))),
      field_row(kPlan, "frames per mode and step", number, &ZoomPlan::frames,
                typed(between(kFewestZoomFrames, kMostZoomFrames, 1))),
      part_row(
          kPlan, "size", choice,
          [](const Viewer& v) {
            const auto name = [&](glm::ivec2 size) { return size_text(v, size); };
            return chosen(list_of<std::string>(kZoomSizes, name),
                          index_in(kZoomSizes, v.zoom.plan.size));
          },
          [](ZoomPlan& plan, double value) { plan.size = kZoomSizes[index_of(value)]; }),
      only_if(has_pipelines, labelled([](const Viewer&) { return "pipeline"; },
                                      part_row(
                                          kPlan, "pipeline of the zoom", choice,
                                          [](const Viewer& v) {
                                            return chosen(
                                                names_in(kPipelineNames),
                                                v.zoom.plan.pipeline.value_or(v.settings.pipeline));
                                          },
                                          [](ZoomPlan& plan, double value) {
                                            plan.pipeline = static_cast<Pipeline>(value);
                                          })))};
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    rows.push_back(part_row(
        kPlan, fmt::format("record {}", mode_name(mode)), toggle,
        [mode](const Viewer& v) { return at(records_mode(v.zoom.plan, mode)); },
        [mode](ZoomPlan& plan, double value) { switch_mode(plan, mode, value != 0); }));
  }
  for (Control& row : rows) row = gray_unless(records_nothing, std::move(row));
  return rows;
}

void send_zoom(Viewer& v, Host& host) {
  if (const ZoomRecord* record = shown_zoom(v.zoom))
    host.send_file(record->scene + "_zoom.csv",
                   std::make_shared<const std::string>(format_csv(record->rows)));
}

bool shows_saved_zoom(const Viewer& v) {
  const ZoomRecord* record = shown_zoom(v.zoom);
  return record != nullptr && !v.zoom.running && !record->folder.empty();
}

bool shows_remote_zoom(const Viewer& v) {
  const ZoomRecord* record = shown_zoom(v.zoom);
  return v.is_remote && !v.zoom.running && record != nullptr && !record->rows.empty();
}

Controls recorder_controls() {
  const auto has_start = [](const Viewer& v) { return v.zoom.plan.start.has_value(); };
  Controls rows = {
      gray_unless([](const Viewer& v) { return !v.zoom.starting; },
                  labelled([](const Viewer& v) { return v.zoom.running ? "Stop" : "Record"; },
                           command_row("Record", "Record a zoom"))),
      only_if(std::not_fn(has_start),
              gray_unless(records_nothing,
                          button_row("start here", call(action::start_zoom_here),
                                     "remembers this view as the start of recordings"))),
      only_if(has_start,
              gray_unless(records_nothing,
                          button_row("this view", call(action::forget_zoom_start),
                                     "starts at the view in the window when Record is pressed"))),
      gray_unless([](const Viewer& v) { return v.zoom.plan.start && !v.zoom.running; },
                  button_row("end here", call(action::end_zoom_here),
                             "ends at the distance of this view from the target")),
      only_if([](const Viewer& v) { return shown_zoom(v.zoom) != nullptr; },
              value_row<ZoomQuantity>(
                  "chart of", choice,
                  [](const Viewer& v) {
                    return chosen(list_of<std::string>(kZoomQuantities, &ZoomQuantityRow::name),
                                  v.zoom.quantity);
                  },
                  action::show_zoom_quantity)),
      only_if(shows_remote_zoom, button_row("The zoom as CSV", call(send_zoom))),
      only_if([](const Viewer& v) { return !v.unsaved_results.empty(); },
              button_row("Save as ...", call(action::toggle_open_dialog, Choosing::results),
                         "writes the results that could not be written into another folder")),
      only_if(shows_saved_zoom, button_row("Open folder", call(action::open_zoom_folder))),
      only_if(shows_saved_zoom,
              button_row("Copy figure", call(action::copy_zoom_figure),
                         "copies the path of the plot of this quantity, a PNG file")),
      item_row("recording", action::show_zoom),
      item_row("dashed recording", action::lay_zoom_beneath)};
  add(rows, plan_controls());
  return rows;
}

// ---- cameras and the path ----------------------------------------------------------------------
void go_to_keyframe(Viewer& v, std::size_t index) {
  if (index < v.keyframes.size()) action::set_camera(v, v.keyframes[index].camera);
}

void go_to_camera(Viewer& v, Host& host, std::size_t index) {
  constexpr std::size_t kMost = 1'000'000'000;
  action::go_to_camera(v, host, static_cast<int>(std::min(index, kMost)));
}

void inspect_row(Viewer& v, Host& host, std::size_t gaussian) {
  if (gaussian <= ~std::uint32_t{0})
    action::inspect_gaussian(v, host, static_cast<std::uint32_t>(gaussian));
}

// A page has neither the photographs nor a drawing of the cameras.
bool has_cameras_here(const Viewer& v) { return !v.is_remote && !v.scene->cameras.empty(); }

bool has_path(const Viewer& v) { return v.keyframes.size() >= 2; }

Controls camera_controls() {
  return {
      item_row("camera", go_to_camera),
      command_row("Bookmark", "Bookmark this view"),
      item_row("bookmark", action::go_to_bookmark),
      item_row("remove bookmark", action::remove_bookmark),
      only_if(has_cameras_here, switch_row(
                                    "in the scene", [](const Viewer& v) { return v.panels.frusta; },
                                    [](Viewer& v, bool is_on) { v.panels.frusta = is_on; },
                                    command_hint("Cameras in the scene"))),
      only_if(has_cameras_here,
              switch_row(
                  "photograph", [](const Viewer& v) { return v.panels.photograph; },
                  [](Viewer& v, Host& host, bool) { action::toggle_photograph(v, host); },
                  command_hint("Photograph of this camera"))),
      only_if([](const Viewer& v) { return has_cameras_here(v) && v.panels.photograph; },
              value_row<float>(
                  "opacity of the photograph", number,
                  [](const Viewer& v) {
                    return at(v.photograph_opacity, {.most = 1, .text = "opacity"});
                  },
                  action::set_photograph_opacity)),
  };
}

ControlNow time_now(const Viewer& v) {
  const double begin = v.keyframes.front().time, end = v.path_end();
  return at(std::clamp(v.playback.time, begin, end), {.least = begin, .most = end, .unit = " s"});
}

Controls path_controls() {
  return {
      command_row("Set here", "Set a keyframe"),
      command_row("Film", "Film of the path, or round the scene"),
      only_if(has_path,
              labelled([](const Viewer& v) { return v.playback.running ? "Stop" : "Play"; },
                       command_row("Play", "Play the path"))),
      only_if(has_path,
              button_row("Save", call(action::save_keyframes), "Saves the path as a file")),
      only_if(has_path, switch_row(
                            "loop", [](const Viewer& v) { return v.loops_path; },
                            [](Viewer& v, bool is_on) { v.loops_path = is_on; })),
      only_if(has_path, value_row<double>("time", number, time_now, action::seek)),
      item_row("keyframe", go_to_keyframe),
      item_row("remove keyframe", action::remove_keyframe),
      item_row<bool>("ease", action::ease_keyframe, "the camera slows down to a stop here"),
      item_row<double>("seconds", action::delay_keyframe),
  };
}

// ---- training ----------------------------------------------------------------------------------
bool trains(const Viewer& v) { return v.training && v.training->phase != TrainingPhase::ended; }

Controls training_controls() {
  using enum TrainingCommand;
  const auto pause_label = [](const Viewer& v) {
    const bool paused = v.remote ? v.remote->paused : v.training->phase == TrainingPhase::paused;
    return paused ? "Resume" : "Pause";
  };
  Controls rows = {
      only_if([](const Viewer& v) { return trains(v) || v.remote; },
              labelled(pause_label, button_row("Pause training", call(action::toggle_training),
                                               command_hint("Pause or resume training")))),
      only_if(trains, button_row("Step", call(action::command_training, step),
                                 "Pauses, or trains one more iteration")),
      only_if(trains, button_row("Save the model", call(action::command_training, save),
                                 "Saves the model and goes on")),
      only_if([](const Viewer& v) { return trains(v) && !v.is_remote; },
              labelled([](const Viewer&) { return "Stop"; },
                       button_row("Stop training", call(action::command_training, stop),
                                  "Saves the model and ends the run; --resume continues it")))};
  for (Control& row : rows) row.without_scene = true;
  return rows;
}

Controls make_controls() {
  Controls rows;
  for (const auto& make :
       {table_controls, settings_controls, heat_controls, split_controls, crop_controls,
        measure_controls, recorder_controls, training_controls, camera_controls, path_controls})
    add(rows, make());
  rows.push_back(item_row("Gaussian", inspect_row));
  return rows;
}

bool is_value_of(ControlKind kind, const ControlNow& now, double value) {
  const bool is_whole = value == std::floor(value) && value >= 0;
  if (kind == toggle) return is_whole && value <= 1;
  if (kind == choice) return is_whole && value < static_cast<double>(now.choices.size());
  if (kind == color) return is_whole && value <= 0xffffff;
  if (kind == button || kind == item) return true;
  return value >= now.least && value <= now.most && (now.step != 1 || value == std::floor(value));
}

}  // namespace

double hex_of(glm::vec3 color) {
  double hex = 0;
  for (int c = 0; c < 3; ++c)
    hex = 256 * hex + std::round(255 * std::clamp(static_cast<double>(color[c]), 0.0, 1.0));
  return hex;
}

std::optional<ControlNow> control_now(const Viewer& viewer, const Control& control) {
  if (!viewer.scene && !control.without_scene) return {};
  return control.now(viewer);
}

const std::string& label_of(const Control& control, const ControlNow& now) {
  return now.text.empty() ? control.name : now.text;
}

std::span<const Control> controls() {
  static const std::vector<Control> kControls = make_controls();
  return kControls;
}

const Control* find_control(std::string_view name) {
  const auto rows = controls();
  const auto found = std::ranges::find(rows, name, &Control::name);
  return found == rows.end() ? nullptr : &*found;
}

std::optional<Action> set_control(const Viewer& viewer, const Control& control, double value,
                                  std::size_t index) {
  if (!std::isfinite(value)) return {};
  const std::optional<ControlNow> now = control_now(viewer, control);
  if (!now || !now->is_enabled || !is_value_of(control.kind, *now, value)) return {};
  return control.set(value, index);
}

std::vector<NamedUse> find_uses(const std::string& text, const Viewer& viewer) {
  const std::string last = text.substr(text.find_last_of(' ') + 1);
  double typed = NAN;
  const auto end = std::from_chars(last.data(), last.data() + last.size(), typed).ptr;
  if (end != last.data() + last.size()) typed = NAN;
  std::vector<NamedUse> found;
  for (const Control& control : controls()) {
    const std::optional<ControlNow> now = control_now(viewer, control);
    if (text.empty() || !now) continue;
    const auto add = [&](const std::string& value_text, double value) {
      const std::string label = label_of(control, *now) + value_text;
      if (!has_words(label, text)) return;
      if (auto action = set_control(viewer, control, value, 0)) found.push_back({label, *action});
    };
    if (control.kind == ControlKind::button) add("", 0);
    if (control.kind == ControlKind::toggle)
      add(now->value != 0 ? ": off" : ": on", now->value != 0 ? 0 : 1);
    if (control.kind == ControlKind::number) add(": " + last, typed);
    for (std::size_t i = 0; i < now->choices.size(); ++i)
      add(": " + now->choices[i], static_cast<double>(i));
  }
  return found;
}

}  // namespace qs
