// SPDX-License-Identifier: MIT
#include "app/viewer/commands/controls.h"

#include <algorithm>
#include <cmath>
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
#include "app/viewer/state/mode_numbers.h"
#include "app/viewer/state/mode_table.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/training_actions.h"
#include "app/viewer/state/zoom_actions.h"

namespace qs {
namespace {

using Now = std::optional<ControlNow>;
using enum ControlKind;

using When = std::function<bool(const Viewer&)>;

// ---- values ------------------------------------------------------------------------------------
ControlNow chosen(std::vector<std::string> choices, std::size_t index = 0) {
  ControlNow now;
  now.choices = std::move(choices);
  now.value = static_cast<double>(index);
  return now;
}

template <class Names>
std::vector<std::string> names_in(const Names& names) {
  return {std::begin(names), std::end(names)};
}

ControlNow between(double least, double most, double step = 0) { return {0, least, most, step}; }

ControlNow logarithmic(double least, double most, int decimals) {
  ControlNow now = between(least, most);
  now.is_logarithmic = true;
  now.decimals = decimals;
  return now;
}

ControlNow typed(ControlNow now) {
  now.is_typed = true;
  return now;
}

ControlNow with_text(std::string text) {
  ControlNow now;
  now.text = std::move(text);
  return now;
}

ControlNow enabled_if(bool condition, ControlNow now = {}) {
  now.is_enabled = condition;
  return now;
}

std::vector<std::string> mode_names(CullMode first, CullMode last) {
  std::vector<std::string> names;
  for (CullMode mode = first; mode <= last; ++mode) names.emplace_back(mode_name(mode));
  return names;
}

std::size_t index_of(double value) { return static_cast<std::size_t>(value); }

bool in_any_state(const Viewer&) { return true; }

// ---- rows --------------------------------------------------------------------------------------
// A part of the viewer that controls change one field at a time: an action takes the changed copy.
template <class Type>
struct Part {
  bool Panels::*panel;
  const Type& (*of)(const Viewer& viewer);
  void (*take)(Viewer& viewer, const Type& part);
};

// A control with its value now and its change of a part.
template <class Type>
Control part_row(const Part<Type>& part, std::string name, ControlKind kind,
                 std::function<Now(const Viewer&)> now,
                 std::type_identity_t<std::function<void(Type&, double)>> change,
                 std::string help = "") {
  return {part.panel,
          std::move(name),
          kind,
          std::move(now),
          [part, change = std::move(change)](const Viewer& v, double value, std::size_t) {
            Type copy = part.of(v);
            change(copy, value);
            return call(part.take, std::move(copy));
          },
          std::move(help)};
}

// A control of one field: a member, or a function that returns a reference to it. `shape`: of the
// control, without its value.
template <class Type, class Field>
Control field_row(const Part<Type>& part, std::string name, ControlKind kind, Field field,
                  ControlNow shape = {}, std::string help = "", When when = in_any_state) {
  return part_row(
      part, std::move(name), kind,
      [part, field, shape = std::move(shape), when = std::move(when)](const Viewer& v) -> Now {
        if (!when(v)) return {};
        Type copy = part.of(v);
        ControlNow now = shape;
        now.value = static_cast<double>(std::invoke(field, copy));
        return now;
      },
      [field](Type& copy, double value) {
        auto& place = std::invoke(field, copy);
        place = static_cast<std::remove_reference_t<decltype(place)>>(value);
      },
      std::move(help));
}

// A control whose value is passed to `set`, which returns the action.
Control value_row(bool Panels::*panel, std::string name, ControlKind kind,
                  std::function<Now(const Viewer&)> now,
                  std::function<Action(const Viewer& v, double value)> set, std::string help = "") {
  return {
      panel,
      std::move(name),
      kind,
      std::move(now),
      [set = std::move(set)](const Viewer& v, double value, std::size_t) { return set(v, value); },
      std::move(help)};
}

// A choice whose index is passed to an action.
Control index_row(bool Panels::*panel, const char* name, std::function<Now(const Viewer&)> now,
                  void (*choose)(Viewer& viewer, std::size_t index)) {
  return value_row(panel, name, choice, std::move(now),
                   [choose](const Viewer&, double value) { return call(choose, index_of(value)); });
}

// A switch of the viewer that an action turns over.
Control switch_row(bool Panels::*panel, const char* name, Action turn_over, When is_on,
                   When when = in_any_state, std::string help = "") {
  return value_row(
      panel, name, toggle,
      [is_on = std::move(is_on), when = std::move(when)](const Viewer& v) -> Now {
        if (!when(v)) return {};
        return ControlNow{is_on(v) ? 1.0 : 0.0};
      },
      [turn_over = std::move(turn_over)](const Viewer&, double) { return turn_over; },
      std::move(help));
}

Control button_now(bool Panels::*panel, std::string name, Action action,
                   std::function<Now(const Viewer&)> now, std::string help = "") {
  return value_row(
      panel, std::move(name), button, std::move(now),
      [action = std::move(action)](const Viewer&, double) { return action; }, std::move(help));
}

Control button_row(bool Panels::*panel, std::string name, Action action, When when = in_any_state,
                   std::string help = "") {
  return button_now(
      panel, std::move(name), std::move(action),
      [when = std::move(when)](const Viewer& v) { return when(v) ? Now(ControlNow()) : Now(); },
      std::move(help));
}

// Parts of rows of lists.
Control item_control(bool Panels::*panel, const char* name,
                     std::function<Action(const Viewer& v, double value, std::size_t index)> set,
                     std::string help = "") {
  return {panel,          name,           item, [](const Viewer&) -> Now { return ControlNow(); },
          std::move(set), std::move(help)};
}

// The function takes the row's index.
template <class Function>
Control item_row(bool Panels::*panel, const char* name, Function function) {
  return item_control(
      panel, name, [function](const Viewer&, double, std::size_t i) { return call(function, i); });
}

template <class Value>
Control item_value_row(bool Panels::*panel, const char* name,
                       void (*function)(Viewer& viewer, std::size_t index, Value value),
                       std::string help = "") {
  return item_control(
      panel, name,
      [function](const Viewer&, double value, std::size_t i) {
        return call(function, i, static_cast<Value>(value));
      },
      std::move(help));
}

using Controls = std::vector<Control>;

void add(Controls& rows, Controls more) {
  std::move(more.begin(), more.end(), std::back_inserter(rows));
}

// ---- the table of modes ------------------------------------------------------------------------
// A window copies the table, a user at another machine gets a file.
void give_table(Viewer& v, Host& host, TableFormat format) {
  if (!v.is_remote) return action::copy_table(v, host, format);
  constexpr const char* kEndings[] = {".csv", ".md", ".tex"};
  action::send_file(v, host, v.scene->name + "_modes" + kEndings[static_cast<int>(format)],
                    std::make_shared<const std::string>(table_text(v, format)));
}

void choose_mode(Viewer& v, std::size_t mode) {
  if (mode > 0 && mode <= static_cast<std::size_t>(culler_count()))
    action::set_mode(v, static_cast<CullMode>(mode));
}

Controls table_controls() {
  Controls rows = {
      index_row(
          &Panels::hud, "measure at",
          [](const Viewer& v) -> Now {
            std::vector<std::string> names;
            for (const MeasuredSize& size : kMeasuredSizes) names.emplace_back(size.name);
            const Camera camera = measured_camera(v);
            names[v.measured_size] += fmt::format(" ({} x {})", camera.width, camera.height);
            return chosen(names, v.measured_size);
          },
          action::set_measured_size),
      value_row(
          &Panels::hud, "ratios to", choice,
          [](const Viewer& v) -> Now {
            return chosen(mode_names(1, culler_count()), static_cast<std::size_t>(v.baseline - 1));
          },
          [](const Viewer&, double value) {
            return call(action::set_baseline, static_cast<CullMode>(value) + 1);
          }),
      item_row(&Panels::hud, "mode", choose_mode)};
  for (std::size_t i = 0; i < std::size(kTableFormats); ++i)
    rows.push_back(button_row(&Panels::hud, fmt::format("The table as {}", kTableFormats[i]),
                              call(give_table, static_cast<TableFormat>(i)), [](const Viewer& v) {
                                return !v.is_remote || !v.numbers.rows.empty();
                              }));
  return rows;
}

// ---- settings ----------------------------------------------------------------------------------
constexpr Part<RenderSettings> kSettings = {
    &Panels::info, [](const Viewer& v) -> const RenderSettings& { return v.settings; },
    action::change_settings};

double hex_of(glm::vec3 color) {
  double hex = 0;
  for (int c = 0; c < 3; ++c)
    hex = 256 * hex + std::round(255 * std::clamp(static_cast<double>(color[c]), 0.0, 1.0));
  return hex;
}

std::vector<std::string> backend_names() {
  std::vector<std::string> names;
  for (const Backend backend : available_backends())
    names.emplace_back(kBackendNames[static_cast<int>(backend)]);
  return names;
}

bool has_pipelines(const Viewer& v) { return pipelines_of(v.backend).size() > 1; }

Controls settings_controls() {
  return {
      part_row(
          kSettings, "SH degree", number,
          [](const Viewer& v) -> Now {
            ControlNow now = between(0, v.scene->sh_degree, 1);
            now.value = std::min(v.settings.sh_degree, v.scene->sh_degree);
            return now;
          },
          [](RenderSettings& settings, double value) {
            settings.sh_degree = static_cast<int>(value);
          }),
      field_row(kSettings, "splat scale", number, &RenderSettings::splat_scale,
                logarithmic(0.01, 3, 2), command_hint("Larger splats")),
      part_row(
          kSettings, "background", color,
          [](const Viewer& v) -> Now { return ControlNow{hex_of(v.settings.background)}; },
          [](RenderSettings& settings, double value) {
            settings.background = rgb(static_cast<std::uint32_t>(value));
          }),
      part_row(
          kSettings, "antialias", choice,
          [](const Viewer& v) -> Now {
            const auto& wish = v.settings.antialiased;
            return chosen({"as trained", "on", "off"}, wish ? (*wish ? 1 : 2) : 0);
          },
          [](RenderSettings& settings, double value) {
            settings.antialiased = value == 0 ? std::nullopt : std::optional(value == 1);
          }),
      value_row(
          &Panels::info, "backend", choice,
          [](const Viewer& v) -> Now {
            const auto& all = available_backends();
            const auto found = std::find(all.begin(), all.end(), v.backend);
            return chosen(backend_names(), static_cast<std::size_t>(found - all.begin()));
          },
          [](const Viewer&, double value) {
            return call(action::change_backend, available_backends()[index_of(value)]);
          }),
      field_row(kSettings, "pipeline", choice, &RenderSettings::pipeline,
                chosen(names_in(kPipelineNames)), "", has_pipelines),
      value_row(
          &Panels::info, "leave out what is larger than the scene", toggle,
          [](const Viewer& v) -> Now {
            if (v.is_remote || v.scene->huge + v.scene->skipped_huge == 0) return {};
            return ControlNow{v.skips_huge ? 1.0 : 0.0};
          },
          [](const Viewer&, double value) { return call(action::skip_huge, value != 0); }),
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

void choose_quantity(Viewer& v, std::size_t index) {
  v.quantity = static_cast<Quantity>(index);
  if (v.quantity != Quantity::color) {
    v.last_quantity = v.quantity;
    v.heatmap.reset();
  }
  action::picture_changed(v);
}

// The window colours its picture itself, other pictures are drawn again.
void restyle_heatmap(Viewer& v, const HeatView& view) {
  action::change_heat_view(v, view);
  if (v.is_remote) action::picture_changed(v);
}

constexpr Part<HeatView> kHeat = {
    &Panels::info, [](const Viewer& v) -> const HeatView& { return v.heat_view; }, restyle_heatmap};

Controls heat_controls() {
  const auto has_map = [](const Viewer& v) { return v.heatmap.has_value(); };
  Controls rows = {
      index_row(
          &Panels::info, "Heat map",
          [](const Viewer& v) -> Now {
            return chosen(heat_choices(), v.heatmap ? static_cast<std::size_t>(*v.heatmap) + 1 : 0);
          },
          choose_heatmap),
      part_row(
          kHeat, "opacity over the colours", number,
          [](const Viewer& v) -> Now {
            if (!v.heatmap) return {};
            ControlNow now = between(0, 100, 1);
            now.value = std::round(static_cast<double>(100 * v.heat_view.style.opacity));
            now.unit = " %";
            return now;
          },
          [](HeatView& view, double value) {
            view.style.opacity = static_cast<float>(value / 100);
          }),
      field_row(
          kHeat, "colour map", choice, [](HeatView & view) -> auto& { return view.style.colors; },
          chosen(names_in(kHeatColors)), "", has_map),
      index_row(
          &Panels::info, "Picture of",
          [](const Viewer& v) -> Now {
            return chosen(quantity_names(), static_cast<std::size_t>(v.quantity));
          },
          choose_quantity),
      value_row(
          &Panels::info, "Draw smaller while moving (CPU)", toggle,
          [](const Viewer& v) -> Now {
            return enabled_if(v.backend == Backend::cpu,
                              ControlNow{v.reduce_when_moving ? 1.0 : 0.0});
          },
          [](const Viewer&, double) {
            return call(action::toggle_option, &Viewer::reduce_when_moving);
          })};
  rows.back().without_scene = true;
  return rows;
}

// ---- split -------------------------------------------------------------------------------------
// The window moves its divider over the same frames, other pictures are drawn again.
void change_shown_split(Viewer& v, const Split& split) {
  const bool redraws = v.is_remote && split.other == v.split.other;
  action::change_split(v, split);
  if (redraws) action::picture_changed(v);
}

constexpr Part<Split> kSplit = {
    &Panels::split, [](const Viewer& v) -> const Split& { return v.split; }, change_shown_split};

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
  std::vector<std::string> names;
  std::size_t here = 0;
  for (const Variant& way : ways) {
    if (drawn_by(way) == drawn_by(v.split.other)) here = names.size();
    names.push_back(drawn_by(way));
  }
  return chosen(names, here);
}

constexpr int kAmplifications[] = {0, 1, 2, 4, 8, 16, 32, 64, 128};

Now amplification_now(const Viewer& v) {
  if (v.split.view != SplitView::difference) return {};
  std::vector<std::string> names = {fmt::format("{}, automatic", shown_amplification(v))};
  for (const int factor : std::span(kAmplifications).subspan(1))
    names.push_back(fmt::format("{}", factor));
  const auto found =
      std::find(std::begin(kAmplifications), std::end(kAmplifications), v.split.amplification);
  return chosen(names, static_cast<std::size_t>(found - std::begin(kAmplifications)) %
                           std::size(kAmplifications));
}

bool splits_sides(const Viewer& v) { return v.split.view == SplitView::sides; }

Controls split_controls() {
  return {
      value_row(
          &Panels::split, "beside", choice,
          [](const Viewer& v) -> Now {
            const CullMode first = first_beside(v);
            const CullMode shown = std::max<CullMode>(v.split.other.mode, first);
            return chosen(mode_names(first, mode_count()), static_cast<std::size_t>(shown - first));
          },
          [](const Viewer& v, double value) {
            Split split = v.split;
            split.other.mode = static_cast<CullMode>(value) + first_beside(v);
            return call(change_shown_split, split);
          }),
      part_row(kSplit, "drawn by", choice, ways_now,
               [](Split& split, double value) {
                 split.other = ways_to_draw(split.other.mode)[index_of(value)];
               }),
      field_row(kSplit, "view", choice, &Split::view, chosen(names_in(kSplitViews)),
                command_hint("Next view of the split")),
      field_row(kSplit, "divider", number, &Split::divider, between(0, 1, 0.01), "", splits_sides),
      part_row(kSplit, "differences times", choice, amplification_now,
               [](Split& split, double value) {
                 split.amplification = kAmplifications[index_of(value)];
               }),
      part_row(
          kSplit, "Flip", button,
          [](const Viewer& v) -> Now {
            if (!splits_sides(v) && v.split.view != SplitView::whole) return {};
            return ControlNow();
          },
          [](Split& split, double) { split.flipped = !split.flipped; },
          command_hint("Flip the split")),
      button_row(
          &Panels::split, "Close the scene beside", call(action::toggle_beside),
          [](const Viewer& v) { return v.beside.has_value(); },
          command_hint("Open or close a scene beside")),
  };
}

// ---- crop and clean ----------------------------------------------------------------------------
constexpr Part<CropWish> kCrop = {&Panels::crop,
                                  [](const Viewer& v) -> const CropWish& { return v.crop.wish; },
                                  action::change_crop};

bool is_boxed(const Viewer& v) { return v.crop.wish.boxed; }

Controls box_controls() {
  Controls rows = {field_row(kCrop, "Box", toggle, &CropWish::boxed)};
  constexpr const char* kAxes[] = {"x right", "y down", "z forward"};
  constexpr double kMost = 1e6;
  ControlNow shape = typed(between(-kMost, kMost));
  shape.decimals = 3;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool low : {true, false}) {
      const auto end = low ? &CropBox::low : &CropBox::high;
      rows.push_back(field_row(
          kCrop, fmt::format("{}, {}", kAxes[axis], low ? "from" : "to"), number,
          [ axis, end ](CropWish & wish) -> auto& { return (wish.box.*end)[axis]; }, shape, "",
          is_boxed));
    }
  }
  rows.push_back(button_row(&Panels::crop, "Fit", call(action::fit_crop_box), is_boxed,
                            "The box around the scene's subject"));
  rows.push_back(button_row(&Panels::crop, "Show all", call(action::show_crop_box), is_boxed,
                            "Moves the camera until the whole box is visible"));
  return rows;
}

// A criterion of floaters: its switch, and its limit while it is on.
template <class Limit>
Controls floater_controls(const char* name, bool Floaters::*is_on, const char* help,
                          const char* limit_name, Limit Floaters::*limit, ControlNow shape) {
  return {
      field_row(
          kCrop, name, toggle, [is_on](CropWish & wish) -> auto& { return wish.floaters.*is_on; },
          {}, help, [](const Viewer& v) { return v.crop.wish.cleans; }),
      field_row(
          kCrop, limit_name,
          number, [limit](CropWish & wish) -> auto& { return wish.floaters.*limit; },
          std::move(shape), "",
          [is_on](const Viewer& v) { return v.crop.wish.cleans && v.crop.wish.floaters.*is_on; })};
}

Controls crop_controls() {
  Controls rows = box_controls();
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
      {value_row(
           &Panels::crop, "Tint what goes", toggle,
           [](const Viewer& v) -> Now {
             if (v.is_remote) return {};
             return ControlNow{v.crop.marks ? 1.0 : 0.0};
           },
           [](const Viewer&, double value) { return call(action::mark_removed, value != 0); }),
       button_row(
           &Panels::crop, "Apply", call(action::apply_crop),
           [](const Viewer& v) { return !v.crop.applied; }, command_hint("Apply or undo the crop")),
       button_row(
           &Panels::crop, "Undo", call(action::undo_crop),
           [](const Viewer& v) { return v.crop.applied || !v.crop.done.empty(); },
           "The scene before the last crop"),
       // The window asks for a file.
       button_row(&Panels::crop, "Save the cropped scene",
                  call(action::save_crop, std::filesystem::path()),
                  [](const Viewer& v) { return v.is_remote && v.crop.applied; })});
  return rows;
}

// ---- the zoom recorder -------------------------------------------------------------------------
constexpr Part<ZoomPlan> kPlan = {&Panels::recorder,
                                  [](const Viewer& v) -> const ZoomPlan& { return v.zoom.plan; },
                                  action::change_zoom_plan};

std::string size_text(const Viewer& v, glm::ivec2 size) {
  if (size.x > 0) return fmt::format("{} x {}", size.x, size.y);
  return fmt::format("as the window, {} x {}", v.camera.width, v.camera.height);
}

bool records_mode(const ZoomPlan& plan, CullMode mode) {
  const std::vector<CullMode> modes = zoom_modes(plan);
  return std::find(modes.begin(), modes.end(), mode) != modes.end();
}

// The last mode cannot be switched off.
void switch_mode(ZoomPlan& plan, CullMode mode, bool is_on) {
  std::vector<CullMode> modes = zoom_modes(plan);
  if (is_on && !records_mode(plan, mode)) modes.push_back(mode);
  if (!is_on && modes.size() > 1) std::erase(modes, mode);
  plan.modes = modes;
}

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
          [](const Viewer& v) -> Now {
            std::vector<std::string> names;
            for (const glm::ivec2 size : kZoomSizes) names.push_back(size_text(v, size));
            const auto found = std::find(kZoomSizes.begin(), kZoomSizes.end(), v.zoom.plan.size);
            return chosen(names,
                          static_cast<std::size_t>(found - kZoomSizes.begin()) % kZoomSizes.size());
          },
          [](ZoomPlan& plan, double value) { plan.size = kZoomSizes[index_of(value)]; }),
      part_row(
          kPlan, "pipeline of the zoom", choice,
          [](const Viewer& v) -> Now {
            if (!has_pipelines(v)) return {};
            const Pipeline pipeline = v.zoom.plan.pipeline.value_or(v.settings.pipeline);
            ControlNow now = chosen(names_in(kPipelineNames), static_cast<std::size_t>(pipeline));
            now.text = "pipeline";
            return now;
          },
          [](ZoomPlan& plan, double value) { plan.pipeline = static_cast<Pipeline>(value); })};
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    rows.push_back(part_row(
        kPlan, fmt::format("record {}", mode_name(mode)), toggle,
        [mode](const Viewer& v) -> Now {
          return ControlNow{records_mode(v.zoom.plan, mode) ? 1.0 : 0.0};
        },
        [mode](ZoomPlan& plan, double value) { switch_mode(plan, mode, value != 0); }));
  }
  for (Control& row : rows) {
    row.now = [now = std::move(row.now)](const Viewer& v) {
      Now shown = now(v);
      if (shown) shown->is_enabled = !v.zoom.running;
      return shown;
    };
  }
  return rows;
}

void send_zoom(Viewer& v, Host& host) {
  const ZoomRecord* record = shown_zoom(v.zoom);
  if (record == nullptr) return;
  action::send_file(v, host, record->scene + "_zoom.csv",
                    std::make_shared<const std::string>(format_csv(record->rows)));
}

bool shows_saved_zoom(const Viewer& v) {
  const ZoomRecord* record = shown_zoom(v.zoom);
  return record != nullptr && !v.zoom.running && !record->folder.empty();
}

Controls recorder_controls() {
  const auto with_start = [](bool has_start) {
    return [has_start](const Viewer& v) -> Now {
      if (v.zoom.plan.start.has_value() != has_start) return {};
      return enabled_if(!v.zoom.running);
    };
  };
  Controls rows = {
      button_now(
          &Panels::recorder, "Record", call(action::toggle_zoom_recording),
          [](const Viewer& v) -> Now {
            return enabled_if(!v.zoom.starting, with_text(v.zoom.running ? "Stop" : "Record"));
          },
          command_hint("Record a zoom")),
      button_now(&Panels::recorder, "start here", call(action::start_zoom_here), with_start(false),
                 "remembers this view as the start of recordings"),
      button_now(&Panels::recorder, "this view", call(action::forget_zoom_start), with_start(true),
                 "starts at the view in the window when Record is pressed"),
      button_now(
          &Panels::recorder, "end here", call(action::end_zoom_here),
          [](const Viewer& v) -> Now { return enabled_if(v.zoom.plan.start && !v.zoom.running); },
          "ends at the distance of this view from the target"),
      value_row(
          &Panels::recorder, "chart of", choice,
          [](const Viewer& v) -> Now {
            if (shown_zoom(v.zoom) == nullptr) return {};
            std::vector<std::string> names;
            for (const ZoomQuantityRow& row : kZoomQuantities) names.emplace_back(row.name);
            return chosen(names, static_cast<std::size_t>(v.zoom.quantity));
          },
          [](const Viewer&, double value) {
            return call(action::show_zoom_quantity, static_cast<ZoomQuantity>(value));
          }),
      button_row(&Panels::recorder, "The zoom as CSV", call(send_zoom),
                 [](const Viewer& v) {
                   const ZoomRecord* record = shown_zoom(v.zoom);
                   return v.is_remote && !v.zoom.running && record != nullptr &&
                          !record->rows.empty();
                 }),
      button_row(&Panels::recorder, "Open folder", call(action::open_zoom_folder),
                 shows_saved_zoom),
      button_row(&Panels::recorder, "Copy figure", call(action::copy_zoom_figure), shows_saved_zoom,
                 "copies the path of the plot of this quantity, a PNG file"),
      item_row(&Panels::recorder, "recording", action::show_zoom),
      item_row(&Panels::recorder, "dashed recording", action::lay_zoom_beneath)};
  add(rows, plan_controls());
  return rows;
}

// ---- cameras and the path ----------------------------------------------------------------------
void go_to_keyframe(Viewer& v, std::size_t index) {
  if (index < v.keyframes.size()) action::set_camera(v, v.keyframes[index].camera);
}

void go_to_camera(Viewer& v, Host& host, std::size_t index) {
  constexpr std::size_t kMost = 1'000'000'000;
  call(action::go_to_camera, static_cast<int>(std::min(index, kMost)))(v, host);
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
      item_row(&Panels::cameras, "camera", go_to_camera),
      switch_row(
          &Panels::cameras, "in the scene", call(action::toggle_panel, &Panels::frusta),
          [](const Viewer& v) { return v.panels.frusta; }, has_cameras_here,
          command_hint("Cameras in the scene")),
      switch_row(
          &Panels::cameras, "photograph", call(action::toggle_photograph),
          [](const Viewer& v) { return v.panels.photograph; }, has_cameras_here,
          command_hint("Photograph of this camera")),
      value_row(
          &Panels::cameras, "opacity of the photograph", number,
          [](const Viewer& v) -> Now {
            if (!has_cameras_here(v) || !v.panels.photograph) return {};
            ControlNow now = between(0, 1);
            now.value = static_cast<double>(v.photograph_opacity);
            now.text = "opacity";
            return now;
          },
          [](const Viewer&, double value) {
            return call(action::set_photograph_opacity, static_cast<float>(value));
          }),
  };
}

Controls path_controls() {
  return {
      button_row(&Panels::cameras, "Set here", call(action::add_keyframe), in_any_state,
                 command_hint("Set a keyframe")),
      button_row(&Panels::cameras, "Film", call(action::film), in_any_state,
                 command_hint("Film of the path, or round the scene")),
      button_now(
          &Panels::cameras, "Play", call(action::toggle_playback),
          [](const Viewer& v) -> Now {
            if (!has_path(v)) return {};
            return with_text(v.playback.running ? "Stop" : "Play");
          },
          command_hint("Play the path")),
      button_row(&Panels::cameras, "Save", call(action::save_keyframes), has_path,
                 "Saves the path as a file"),
      switch_row(
          &Panels::cameras, "loop", call(action::toggle_option, &Viewer::loops_path),
          [](const Viewer& v) { return v.loops_path; }, has_path),
      value_row(
          &Panels::cameras, "time", number,
          [](const Viewer& v) -> Now {
            if (!has_path(v)) return {};
            ControlNow now = between(v.keyframes.front().time, v.path_end());
            now.value = std::clamp(v.playback.time, now.least, now.most);
            now.unit = " s";
            return now;
          },
          [](const Viewer&, double value) { return call(action::seek, value); }),
      item_row(&Panels::cameras, "keyframe", go_to_keyframe),
      item_row(&Panels::cameras, "remove keyframe", action::remove_keyframe),
      item_value_row(&Panels::cameras, "ease", action::ease_keyframe,
                     "the camera slows down to a stop here"),
      item_value_row(&Panels::cameras, "seconds", action::delay_keyframe),
  };
}

// ---- training ----------------------------------------------------------------------------------
bool trains(const Viewer& v) { return v.training && v.training->phase != TrainingPhase::ended; }

Controls training_controls() {
  Controls rows = {
      button_now(
          &Panels::training, "Pause training", call(action::toggle_training),
          [](const Viewer& v) -> Now {
            if (!trains(v) && !v.remote) return {};
            const bool paused =
                v.remote ? v.remote->paused : v.training->phase == TrainingPhase::paused;
            return with_text(paused ? "Resume" : "Pause");
          },
          command_hint("Pause or resume training")),
      button_row(&Panels::training, "Step", call(action::command_training, TrainingCommand::step),
                 trains, "Pauses, or trains one more iteration"),
      button_row(&Panels::training, "Save the model",
                 call(action::command_training, TrainingCommand::save), trains,
                 "Saves the model and goes on"),
      button_now(
          &Panels::training, "Stop training", call(action::command_training, TrainingCommand::stop),
          [](const Viewer& v) -> Now {
            if (!trains(v) || v.is_remote) return {};
            return with_text("Stop");
          },
          "Saves the model and ends the run; --resume continues it")};
  for (Control& row : rows) row.without_scene = true;
  return rows;
}

Controls make_controls() {
  Controls rows;
  for (const auto& make :
       {table_controls, settings_controls, heat_controls, split_controls, crop_controls,
        recorder_controls, training_controls, camera_controls, path_controls})
    add(rows, make());
  rows.push_back(item_row(&Panels::inspector, "Gaussian", inspect_row));
  return rows;
}

bool is_value_of(ControlKind kind, const ControlNow& now, double value) {
  const bool is_whole = value == std::floor(value) && value >= 0;
  switch (kind) {
    case toggle:
      return is_whole && value <= 1;
    case choice:
      return is_whole && value < static_cast<double>(now.choices.size());
    case number:
      return value >= now.least && value <= now.most &&
             (now.step != 1 || value == std::floor(value));
    case color:
      return is_whole && value <= 0xffffff;
    case button:
    case item:
      return true;
  }
  return false;
}

}  // namespace

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
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const Control& row) { return row.name == name; });
  return found == rows.end() ? nullptr : &*found;
}

std::optional<Action> set_control(const Viewer& viewer, const Control& control, double value,
                                  std::size_t index) {
  if (!std::isfinite(value)) return {};
  const std::optional<ControlNow> now = control_now(viewer, control);
  if (!now || !now->is_enabled || !is_value_of(control.kind, *now, value)) return {};
  return control.set(viewer, value, index);
}

}  // namespace qs
