// SPDX-License-Identifier: MIT
#include "app/viewer/commands/controls.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

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

// ---- values ------------------------------------------------------------------------------------
ControlNow on(bool value) { return {value ? 1.0 : 0.0}; }

ControlNow chosen(std::vector<std::string> choices, std::size_t index) {
  ControlNow now;
  now.choices = std::move(choices);
  now.value = static_cast<double>(index);
  return now;
}

template <class Names>
std::vector<std::string> names_in(const Names& names) {
  return {std::begin(names), std::end(names)};
}

ControlNow between(double value, double least, double most, double step = 0) {
  return {value, least, most, step};
}

ControlNow logarithmic(double value, double least, double most, int decimals) {
  ControlNow now = between(value, least, most);
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

Now if_true(bool condition) { return condition ? Now(ControlNow()) : Now(); }

std::vector<std::string> mode_names(CullMode first, CullMode last) {
  std::vector<std::string> names;
  for (CullMode mode = first; mode <= last; ++mode) names.emplace_back(mode_name(mode));
  return names;
}

std::size_t index_of(double value) { return static_cast<std::size_t>(value); }

// A change of a copy of a part of the viewer, which an action then takes.
template <class Part, class Take, class Change>
Action changed(Part part, Take take, const Change& change) {
  change(part);
  return call(take, part);
}

// ---- rows --------------------------------------------------------------------------------------
Control button_row(bool Panels::*panel, const char* name, Action action,
                   std::function<Now(const Viewer&)> now, std::string help = "") {
  return {panel,
          name,
          button,
          std::move(now),
          [action = std::move(action)](const Viewer&, double, std::size_t) { return action; },
          std::move(help)};
}

// ---- the table of modes ------------------------------------------------------------------------
std::string file_of_table(const Viewer& v, TableFormat format) {
  constexpr const char* kEndings[] = {".csv", ".md", ".tex"};
  return v.scene->name + "_modes" + kEndings[static_cast<int>(format)];
}

void send_table(Viewer& v, Host& host, TableFormat format) {
  action::send_file(v, host, file_of_table(v, format),
                    std::make_shared<const std::string>(table_text(v, format)));
}

void add_table_controls(std::vector<Control>& rows) {
  rows.push_back({&Panels::hud, "measure at", choice,
                  [](const Viewer& v) -> Now {
                    std::vector<std::string> names;
                    for (const MeasuredSize& size : kMeasuredSizes) names.emplace_back(size.name);
                    const Camera camera = measured_camera(v);
                    names[v.measured_size] +=
                        fmt::format(" ({} x {})", camera.width, camera.height);
                    return chosen(names, v.measured_size);
                  },
                  [](const Viewer&, double value, std::size_t) {
                    return call(action::set_measured_size, index_of(value));
                  }});
  rows.push_back({&Panels::hud, "ratios to", choice,
                  [](const Viewer& v) -> Now {
                    return chosen(mode_names(1, culler_count()),
                                  static_cast<std::size_t>(v.baseline - 1));
                  },
                  [](const Viewer&, double value, std::size_t) {
                    return call(action::set_baseline, static_cast<CullMode>(value) + 1);
                  }});
  for (std::size_t i = 0; i < std::size(kTableFormats); ++i) {
    Control row =
        button_row(&Panels::hud, "", call(send_table, static_cast<TableFormat>(i)),
                   [](const Viewer& v) { return if_true(v.is_remote && !v.numbers.rows.empty()); });
    row.name = fmt::format("The table as {}", kTableFormats[i]);
    rows.push_back(std::move(row));
  }
}

// ---- settings ----------------------------------------------------------------------------------
Control setting(const char* name, ControlKind kind, std::function<Now(const Viewer&)> now,
                void (*change)(RenderSettings& settings, double value), std::string help = "") {
  return {&Panels::info,
          name,
          kind,
          std::move(now),
          [change](const Viewer& v, double value, std::size_t) {
            return changed(v.settings, action::change_settings,
                           [&](RenderSettings& settings) { change(settings, value); });
          },
          std::move(help)};
}

double hex_of(glm::vec3 color) {
  double hex = 0;
  for (int c = 0; c < 3; ++c)
    hex = 256 * hex + std::round(255 * std::clamp(static_cast<double>(color[c]), 0.0, 1.0));
  return hex;
}

glm::vec3 color_of(double hex) {
  const auto bits = static_cast<std::uint32_t>(hex);
  return glm::vec3(bits >> 16 & 0xff, bits >> 8 & 0xff, bits & 0xff) / 255.0f;
}

std::vector<std::string> backend_names() {
  std::vector<std::string> names;
  for (const Backend backend : available_backends())
    names.emplace_back(kBackendNames[static_cast<int>(backend)]);
  return names;
}

std::size_t index_of(std::span<const Backend> all, Backend backend) {
  return static_cast<std::size_t>(std::find(all.begin(), all.end(), backend) - all.begin());
}

void add_settings(std::vector<Control>& rows) {
  rows.push_back(setting(
      "SH degree", number,
      [](const Viewer& v) -> Now {
        return between(std::min(v.settings.sh_degree, v.scene->sh_degree), 0, v.scene->sh_degree,
                       1);
      },
      [](RenderSettings& settings, double value) {
        settings.sh_degree = static_cast<int>(value);
      }));
  rows.push_back(setting(
      "splat scale", number,
      [](const Viewer& v) -> Now {
        return logarithmic(static_cast<double>(v.settings.splat_scale), 0.01, 3, 2);
      },
      [](RenderSettings& settings, double value) {
        settings.splat_scale = static_cast<float>(value);
      },
      command_hint("Larger splats")));
  rows.push_back(setting(
      "background", color,
      [](const Viewer& v) -> Now { return ControlNow{hex_of(v.settings.background)}; },
      [](RenderSettings& settings, double value) { settings.background = color_of(value); }));
  rows.push_back(setting(
      "antialias", choice,
      [](const Viewer& v) -> Now {
        const auto& wish = v.settings.antialiased;
        return chosen({"as trained", "on", "off"}, wish ? (*wish ? 1 : 2) : 0);
      },
      [](RenderSettings& settings, double value) {
        settings.antialiased = value == 0 ? std::nullopt : std::optional(value == 1);
      }));
  rows.push_back({&Panels::info, "backend", choice,
                  [](const Viewer& v) -> Now {
                    return chosen(backend_names(), index_of(available_backends(), v.backend));
                  },
                  [](const Viewer&, double value, std::size_t) {
                    return call(action::change_backend, available_backends()[index_of(value)]);
                  }});
  rows.push_back(setting(
      "pipeline", choice,
      [](const Viewer& v) -> Now {
        if (pipelines_of(v.backend).size() < 2) return {};
        return chosen(names_in(kPipelineNames), static_cast<std::size_t>(v.settings.pipeline));
      },
      [](RenderSettings& settings, double value) {
        settings.pipeline = static_cast<Pipeline>(value);
      }));
  rows.push_back({&Panels::info, "leave out what is larger than the scene", toggle,
                  [](const Viewer& v) -> Now {
                    if (v.is_remote || v.scene->huge + v.scene->skipped_huge == 0) return {};
                    return on(v.skips_huge);
                  },
                  [](const Viewer&, double value, std::size_t) {
                    return call(action::skip_huge, value != 0);
                  }});
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

Control heat_setting(const char* name, ControlKind kind, std::function<Now(const Viewer&)> now,
                     void (*change)(HeatView& view, double value)) {
  return {&Panels::info, name, kind,
          [now = std::move(now)](const Viewer& v) { return v.heatmap ? now(v) : Now(); },
          [change](const Viewer& v, double value, std::size_t) {
            return changed(v.heat_view, restyle_heatmap,
                           [&](HeatView& view) { change(view, value); });
          }};
}

void add_heat_controls(std::vector<Control>& rows) {
  rows.push_back({&Panels::info, "Heat map", choice,
                  [](const Viewer& v) -> Now {
                    return chosen(heat_choices(),
                                  v.heatmap ? static_cast<std::size_t>(*v.heatmap) + 1 : 0);
                  },
                  [](const Viewer&, double value, std::size_t) {
                    return call(choose_heatmap, index_of(value));
                  }});
  rows.push_back(heat_setting(
      "opacity over the colours", number,
      [](const Viewer& v) -> Now {
        ControlNow now =
            between(std::round(static_cast<double>(100 * v.heat_view.style.opacity)), 0, 100, 1);
        now.unit = " %";
        return now;
      },
      [](HeatView& view, double value) { view.style.opacity = static_cast<float>(value / 100); }));
  rows.push_back(heat_setting(
      "colour map", choice,
      [](const Viewer& v) -> Now {
        return chosen(names_in(kHeatColors), static_cast<std::size_t>(v.heat_view.style.colors));
      },
      [](HeatView& view, double value) { view.style.colors = static_cast<HeatColors>(value); }));
  rows.push_back({&Panels::info, "Picture of", choice,
                  [](const Viewer& v) -> Now {
                    return chosen(quantity_names(), static_cast<std::size_t>(v.quantity));
                  },
                  [](const Viewer&, double value, std::size_t) {
                    return call(choose_quantity, index_of(value));
                  }});
  rows.push_back({&Panels::info, "Draw smaller while moving (CPU)", toggle,
                  [](const Viewer& v) -> Now {
                    return enabled_if(v.backend == Backend::cpu, on(v.reduce_when_moving));
                  },
                  [](const Viewer&, double, std::size_t) {
                    return call(action::toggle_option, &Viewer::reduce_when_moving);
                  },
                  "", true});
}

// ---- split -------------------------------------------------------------------------------------
// The window moves its divider over the same frames, other pictures are drawn again.
void change_shown_split(Viewer& v, const Split& split) {
  const bool redraws = v.is_remote && split.other == v.split.other;
  action::change_split(v, split);
  if (redraws) action::picture_changed(v);
}

Control split_setting(const char* name, ControlKind kind, std::function<Now(const Viewer&)> now,
                      std::function<void(Split& split, double value)> change,
                      std::string help = "") {
  return {&Panels::split,
          name,
          kind,
          std::move(now),
          [change = std::move(change)](const Viewer& v, double value, std::size_t) {
            return changed(v.split, change_shown_split,
                           [&](Split& split) { change(split, value); });
          },
          std::move(help)};
}

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

constexpr int kAmplifications[] = {0, 1, 2, 4, 8, 16, 32, 64, 128};

void add_split_controls(std::vector<Control>& rows) {
  rows.push_back({&Panels::split, "beside", choice,
                  [](const Viewer& v) -> Now {
                    const CullMode first = first_beside(v);
                    const CullMode shown = std::max<CullMode>(v.split.other.mode, first);
                    return chosen(mode_names(first, mode_count()),
                                  static_cast<std::size_t>(shown - first));
                  },
                  [](const Viewer& v, double value, std::size_t) {
                    Split split = v.split;
                    split.other.mode = static_cast<CullMode>(value) + first_beside(v);
                    return call(change_shown_split, split);
                  }});
  rows.push_back(split_setting(
      "drawn by", choice,
      [](const Viewer& v) -> Now {
        const std::vector<Variant> ways = ways_to_draw(v.split.other.mode);
        if (ways.size() < 2 || v.split.other.mode == kReferenceMode) return {};
        std::vector<std::string> names;
        std::size_t here = 0;
        for (const Variant& way : ways) {
          if (drawn_by(way) == drawn_by(v.split.other)) here = names.size();
          names.push_back(drawn_by(way));
        }
        return chosen(names, here);
      },
      [](Split& split, double value) {
        split.other = ways_to_draw(split.other.mode)[index_of(value)];
      }));
  rows.push_back(split_setting(
      "view", choice,
      [](const Viewer& v) -> Now {
        return chosen(names_in(kSplitViews), static_cast<std::size_t>(v.split.view));
      },
      [](Split& split, double value) { split.view = static_cast<SplitView>(value); },
      command_hint("Next view of the split")));
  rows.push_back(split_setting(
      "divider", number,
      [](const Viewer& v) -> Now {
        if (v.split.view != SplitView::sides) return {};
        return between(static_cast<double>(v.split.divider), 0, 1, 0.01);
      },
      [](Split& split, double value) { split.divider = static_cast<float>(value); }));
  rows.push_back(split_setting(
      "differences times", choice,
      [](const Viewer& v) -> Now {
        if (v.split.view != SplitView::difference) return {};
        std::vector<std::string> names = {fmt::format("{}, automatic", shown_amplification(v))};
        for (const int factor : kAmplifications) {
          if (factor > 0) names.push_back(fmt::format("{}", factor));
        }
        const auto found = std::find(std::begin(kAmplifications), std::end(kAmplifications),
                                     v.split.amplification);
        return chosen(names, static_cast<std::size_t>(found - std::begin(kAmplifications)) %
                                 std::size(kAmplifications));
      },
      [](Split& split, double value) { split.amplification = kAmplifications[index_of(value)]; }));
  rows.push_back(split_setting(
      "Flip", button,
      [](const Viewer& v) {
        return if_true(v.split.view == SplitView::sides || v.split.view == SplitView::whole);
      },
      [](Split& split, double) { split.flipped = !split.flipped; },
      command_hint("Flip the split")));
}

// ---- crop and clean ----------------------------------------------------------------------------
Control crop_setting(std::string name, ControlKind kind, std::function<Now(const Viewer&)> now,
                     std::function<void(CropWish& wish, double value)> change,
                     std::string help = "") {
  return {&Panels::crop,
          std::move(name),
          kind,
          std::move(now),
          [change = std::move(change)](const Viewer& v, double value, std::size_t) {
            return changed(v.crop.wish, action::change_crop,
                           [&](CropWish& wish) { change(wish, value); });
          },
          std::move(help)};
}

void add_box_controls(std::vector<Control>& rows) {
  rows.push_back(crop_setting(
      "Box", toggle, [](const Viewer& v) -> Now { return on(v.crop.wish.boxed); },
      [](CropWish& wish, double value) { wish.boxed = value != 0; }));
  constexpr const char* kAxes[] = {"x right", "y down", "z forward"};
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool low : {true, false}) {
      const auto end = low ? &CropBox::low : &CropBox::high;
      rows.push_back(crop_setting(
          fmt::format("{}, {}", kAxes[axis], low ? "from" : "to"), number,
          [axis, end](const Viewer& v) -> Now {
            if (!v.crop.wish.boxed) return {};
            constexpr double kMost = 1e6;
            ControlNow now =
                between(static_cast<double>((v.crop.wish.box.*end)[axis]), -kMost, kMost);
            now.decimals = 3;
            return typed(now);
          },
          [axis, end](CropWish& wish, double value) {
            (wish.box.*end)[axis] = static_cast<float>(value);
          }));
    }
  }
  const auto boxed = [](const Viewer& v) { return if_true(v.crop.wish.boxed); };
  rows.push_back(button_row(&Panels::crop, "Fit", call(action::fit_crop_box), boxed,
                            "The box around the scene's subject"));
  rows.push_back(button_row(&Panels::crop, "Show all", call(action::show_crop_box), boxed,
                            "Moves the camera until the whole box is visible"));
}

// A criterion of floaters: its switch, and its limit while it is on.
void add_floaters(std::vector<Control>& rows, const char* name, bool Floaters::*is_on,
                  const char* help, Control limit) {
  rows.push_back(crop_setting(
      name, toggle,
      [is_on](const Viewer& v) -> Now {
        if (!v.crop.wish.cleans) return {};
        return on(v.crop.wish.floaters.*is_on);
      },
      [is_on](CropWish& wish, double value) { wish.floaters.*is_on = value != 0; }, help));
  limit.now = [is_on, now = limit.now](const Viewer& v) {
    return v.crop.wish.cleans && v.crop.wish.floaters.*is_on ? now(v) : Now();
  };
  rows.push_back(std::move(limit));
}

void add_crop_controls(std::vector<Control>& rows) {
  add_box_controls(rows);
  rows.push_back(crop_setting(
      "Floaters", toggle, [](const Viewer& v) -> Now { return on(v.crop.wish.cleans); },
      [](CropWish& wish, double value) { wish.cleans = value != 0; }));
  add_floaters(rows, "faint", &Floaters::faint, "less opaque than this",
               crop_setting(
                   "opacity", number,
                   [](const Viewer& v) -> Now {
                     const float limit = v.crop.wish.floaters.least_opacity;
                     return logarithmic(static_cast<double>(limit), 0.004, 1, 3);
                   },
                   [](CropWish& wish, double value) {
                     wish.floaters.least_opacity = static_cast<float>(value);
                   }));
  add_floaters(rows, "large", &Floaters::large,
               "a standard deviation longer than this part of the scene's core",
               crop_setting(
                   "of the core", number,
                   [](const Viewer& v) -> Now {
                     const float limit = v.crop.wish.floaters.largest_size;
                     return logarithmic(static_cast<double>(limit), 0.005, 2, 3);
                   },
                   [](CropWish& wish, double value) {
                     wish.floaters.largest_size = static_cast<float>(value);
                   }));
  add_floaters(rows, "isolated", &Floaters::isolated, "fewer neighbours than this around it",
               crop_setting(
                   "neighbours", number,
                   [](const Viewer& v) -> Now {
                     return between(v.crop.wish.floaters.fewest_neighbours, 1, 200, 1);
                   },
                   [](CropWish& wish, double value) {
                     wish.floaters.fewest_neighbours = static_cast<int>(value);
                   }));
  rows.push_back({&Panels::crop, "Tint what goes", toggle,
                  [](const Viewer& v) -> Now {
                    if (v.is_remote) return {};
                    return on(v.crop.marks);
                  },
                  [](const Viewer&, double value, std::size_t) {
                    return call(action::mark_removed, value != 0);
                  }});
  rows.push_back(button_row(
      &Panels::crop, "Apply", call(action::apply_crop),
      [](const Viewer& v) { return if_true(!v.crop.applied); },
      command_hint("Apply or undo the crop")));
  rows.push_back(button_row(
      &Panels::crop, "Undo", call(action::undo_crop),
      [](const Viewer& v) { return if_true(v.crop.applied || !v.crop.done.empty()); },
      "The scene before the last crop"));
  rows.push_back(button_row(&Panels::crop, "Save the cropped scene",
                            call(action::save_crop, std::filesystem::path()),
                            [](const Viewer& v) { return if_true(v.crop.applied); }));
}

// ---- the zoom recorder -------------------------------------------------------------------------
Control plan_setting(std::string name, ControlKind kind, std::function<Now(const Viewer&)> now,
                     std::function<void(ZoomPlan& plan, double value)> change,
                     std::string help = "") {
  return {&Panels::recorder,
          std::move(name),
          kind,
          [now = std::move(now)](const Viewer& v) {
            Now setting = now(v);
            if (setting) setting->is_enabled = !v.zoom.running;
            return setting;
          },
          [change = std::move(change)](const Viewer& v, double value, std::size_t) {
            return changed(v.zoom.plan, action::change_zoom_plan,
                           [&](ZoomPlan& plan) { change(plan, value); });
          },
          std::move(help)};
}

std::string size_text(const Viewer& v, glm::ivec2 size) {
  if (size.x > 0) return fmt::format("{} x {}", size.x, size.y);
  return fmt::format("as the window, {} x {}", v.camera.width, v.camera.height);
}

// The last mode cannot be switched off.
void switch_mode(ZoomPlan& plan, CullMode mode, bool is_on) {
  std::vector<CullMode> modes = zoom_modes(plan);
  const auto found = std::find(modes.begin(), modes.end(), mode);
  if (is_on && found == modes.end()) modes.push_back(mode);
  if (!is_on && found != modes.end() && modes.size() > 1) modes.erase(found);
  plan.modes = modes;
}

void send_zoom(Viewer& v, Host& host) {
  const ZoomRecord* record = shown_zoom(v.zoom);
  if (record == nullptr) return;
  action::send_file(v, host, record->scene + "_zoom.csv",
                    std::make_shared<const std::string>(format_csv(record->rows)));
}

void add_plan_controls(std::vector<Control>& rows) {
  rows.push_back(plan_setting(
      "x closer", number,
      [](const Viewer& v) -> Now {
        return typed(logarithmic(v.zoom.plan.closer, kLeastCloser, kMostCloser, 1));
      },
      [](ZoomPlan& plan, double value) { plan.closer = value; },
      "the camera moves straight to the point in the middle of the first picture"));
  rows.push_back(plan_setting(
      "steps", number,
      [](const Viewer& v) -> Now {
        return typed(between(v.zoom.plan.steps, kFewestZoomSteps, kMostZoomSteps, 1));
      },
      [](ZoomPlan& plan, double value) { plan.steps = static_cast<int>(value); }));
  rows.push_back(plan_setting(
      "frames per mode and step", number,
      [](const Viewer& v) -> Now {
        return typed(between(v.zoom.plan.frames, kFewestZoomFrames, kMostZoomFrames, 1));
      },
      [](ZoomPlan& plan, double value) { plan.frames = static_cast<int>(value); }));
  rows.push_back(plan_setting(
      "size", choice,
      [](const Viewer& v) -> Now {
        std::vector<std::string> names;
        for (const glm::ivec2 size : kZoomSizes) names.push_back(size_text(v, size));
        const auto found = std::find(kZoomSizes.begin(), kZoomSizes.end(), v.zoom.plan.size);
        return chosen(names,
                      static_cast<std::size_t>(found - kZoomSizes.begin()) % kZoomSizes.size());
      },
      [](ZoomPlan& plan, double value) { plan.size = kZoomSizes[index_of(value)]; }));
  rows.push_back(plan_setting(
      "pipeline of the zoom", choice,
      [](const Viewer& v) -> Now {
        if (pipelines_of(v.backend).size() < 2) return {};
        const Pipeline pipeline = v.zoom.plan.pipeline.value_or(v.settings.pipeline);
        ControlNow now = chosen(names_in(kPipelineNames), static_cast<std::size_t>(pipeline));
        now.text = "pipeline";
        return now;
      },
      [](ZoomPlan& plan, double value) { plan.pipeline = static_cast<Pipeline>(value); }));
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    rows.push_back(plan_setting(
        fmt::format("record {}", mode_name(mode)), toggle,
        [mode](const Viewer& v) -> Now {
          const std::vector<CullMode> modes = zoom_modes(v.zoom.plan);
          return on(std::find(modes.begin(), modes.end(), mode) != modes.end());
        },
        [mode](ZoomPlan& plan, double value) { switch_mode(plan, mode, value != 0); }));
  }
}

void add_recorder_controls(std::vector<Control>& rows) {
  rows.push_back(button_row(
      &Panels::recorder, "Record", call(action::toggle_zoom_recording),
      [](const Viewer& v) -> Now {
        return enabled_if(!v.zoom.starting, with_text(v.zoom.running ? "Stop" : "Record"));
      },
      command_hint("Record a zoom")));
  const auto with_start = [](bool has_start) {
    return [has_start](const Viewer& v) -> Now {
      if (v.zoom.plan.start.has_value() != has_start) return {};
      return enabled_if(!v.zoom.running);
    };
  };
  rows.push_back(button_row(&Panels::recorder, "start here", call(action::start_zoom_here),
                            with_start(false), "remembers this view as the start of recordings"));
  rows.push_back(button_row(&Panels::recorder, "this view", call(action::forget_zoom_start),
                            with_start(true),
                            "starts at the view in the window when Record is pressed"));
  rows.push_back(button_row(
      &Panels::recorder, "end here", call(action::end_zoom_here),
      [](const Viewer& v) -> Now { return enabled_if(v.zoom.plan.start && !v.zoom.running); },
      "ends at the distance of this view from the target"));
  add_plan_controls(rows);
  rows.push_back({&Panels::recorder, "chart of", choice,
                  [](const Viewer& v) -> Now {
                    if (shown_zoom(v.zoom) == nullptr) return {};
                    std::vector<std::string> names;
                    for (const ZoomQuantityRow& row : kZoomQuantities) names.emplace_back(row.name);
                    return chosen(names, static_cast<std::size_t>(v.zoom.quantity));
                  },
                  [](const Viewer&, double value, std::size_t) {
                    return call(action::show_zoom_quantity, static_cast<ZoomQuantity>(value));
                  }});
  rows.push_back(
      button_row(&Panels::recorder, "The zoom as CSV", call(send_zoom), [](const Viewer& v) {
        const ZoomRecord* record = shown_zoom(v.zoom);
        return if_true(v.is_remote && !v.zoom.running && record != nullptr &&
                       !record->rows.empty());
      }));
}

// ---- lists, cameras and the path ---------------------------------------------------------------
Control item_row(bool Panels::*panel, const char* name,
                 std::function<Action(const Viewer&, double, std::size_t)> set,
                 std::string help = "") {
  return {panel,          name,           item, [](const Viewer&) -> Now { return ControlNow(); },
          std::move(set), std::move(help)};
}

void go_to_keyframe(Viewer& v, std::size_t index) {
  if (index < v.keyframes.size()) action::set_camera(v, v.keyframes[index].camera);
}

void inspect_row(Viewer& v, Host& host, std::size_t gaussian) {
  if (gaussian <= ~std::uint32_t{0})
    action::inspect_gaussian(v, host, static_cast<std::uint32_t>(gaussian));
}

void add_path_controls(std::vector<Control>& rows) {
  const auto always = [](const Viewer&) -> Now { return ControlNow(); };
  const auto has_path = [](const Viewer& v) { return if_true(v.keyframes.size() >= 2); };
  rows.push_back(button_row(&Panels::cameras, "Set here", call(action::add_keyframe), always,
                            command_hint("Set a keyframe")));
  rows.push_back(button_row(&Panels::cameras, "Film", call(action::film), always,
                            command_hint("Film of the path, or round the scene")));
  rows.push_back(button_row(
      &Panels::cameras, "Play", call(action::toggle_playback),
      [](const Viewer& v) -> Now {
        if (v.keyframes.size() < 2) return {};
        return with_text(v.playback.running ? "Stop" : "Play");
      },
      command_hint("Play the path")));
  rows.push_back(button_row(&Panels::cameras, "Save", call(action::save_keyframes), has_path,
                            "Saves the path as a file"));
  rows.push_back({&Panels::cameras, "loop", toggle,
                  [](const Viewer& v) -> Now {
                    if (v.keyframes.size() < 2) return {};
                    return on(v.loops_path);
                  },
                  [](const Viewer&, double, std::size_t) {
                    return call(action::toggle_option, &Viewer::loops_path);
                  }});
  rows.push_back(
      {&Panels::cameras, "time", number,
       [](const Viewer& v) -> Now {
         if (v.keyframes.size() < 2) return {};
         const double begin = v.keyframes.front().time;
         ControlNow now =
             between(std::clamp(v.playback.time, begin, v.path_end()), begin, v.path_end());
         now.unit = " s";
         return now;
       },
       [](const Viewer&, double value, std::size_t) { return call(action::seek, value); }});
  rows.push_back(item_row(&Panels::cameras, "keyframe", [](const Viewer&, double, std::size_t i) {
    return call(go_to_keyframe, i);
  }));
  rows.push_back(item_row(
      &Panels::cameras, "remove keyframe",
      [](const Viewer&, double, std::size_t i) { return call(action::remove_keyframe, i); }));
  rows.push_back(item_row(
      &Panels::cameras, "ease",
      [](const Viewer&, double value, std::size_t i) {
        return call(action::ease_keyframe, i, value != 0);
      },
      "the camera slows down to a stop here"));
  rows.push_back(
      item_row(&Panels::cameras, "seconds", [](const Viewer&, double value, std::size_t i) {
        return call(action::delay_keyframe, i, value);
      }));
}

void add_training_controls(std::vector<Control>& rows) {
  const auto trains = [](const Viewer& v) {
    return v.training && v.training->phase != TrainingPhase::ended;
  };
  const auto if_training = [trains](const Viewer& v) { return if_true(trains(v)); };
  rows.push_back(button_row(
      &Panels::training, "Pause training", call(action::toggle_training),
      [trains](const Viewer& v) -> Now {
        if (!trains(v) && !v.remote) return {};
        const bool paused =
            v.remote ? v.remote->paused : v.training->phase == TrainingPhase::paused;
        return with_text(paused ? "Resume" : "Pause");
      },
      command_hint("Pause or resume training")));
  rows.push_back(button_row(&Panels::training, "Step",
                            call(action::command_training, TrainingCommand::step), if_training,
                            "Pauses, or trains one more iteration"));
  rows.push_back(button_row(&Panels::training, "Save the model",
                            call(action::command_training, TrainingCommand::save), if_training,
                            "Saves the model and goes on"));
  rows.push_back(button_row(
      &Panels::training, "Stop training", call(action::command_training, TrainingCommand::stop),
      [trains](const Viewer& v) -> Now {
        if (!trains(v) || v.is_remote) return {};
        return with_text("Stop");
      },
      "Saves the model and ends the run; --resume continues it"));
  for (Control& row : rows) row.without_scene |= row.panel == &Panels::training;
}

std::vector<Control> make_controls() {
  std::vector<Control> rows;
  add_table_controls(rows);
  add_settings(rows);
  add_heat_controls(rows);
  add_split_controls(rows);
  add_crop_controls(rows);
  add_recorder_controls(rows);
  add_training_controls(rows);
  rows.push_back(item_row(&Panels::inspector, "Gaussian", [](const Viewer&, double, std::size_t i) {
    return call(inspect_row, i);
  }));
  rows.push_back(item_row(&Panels::cameras, "camera", [](const Viewer&, double, std::size_t i) {
    constexpr std::size_t kMost = 1'000'000'000;
    return call(action::go_to_camera, static_cast<int>(std::min(i, kMost)));
  }));
  add_path_controls(rows);
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
