// SPDX-License-Identifier: MIT
#include "app/viewer/panels/controls_drawer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <imgui.h>

#include "app/picture/palette.h"
#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

constexpr int kFieldStep = 10;       ///< of the buttons of a typed whole number with a wide range
constexpr double kWideRange = 500;   ///< such a range
constexpr double kDragPixels = 100;  ///< that double a typed number, about

ImGuiSliderFlags slider_flags(const ControlNow& now) {
  return now.is_logarithmic ? ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp
                            : ImGuiSliderFlags_AlwaysClamp;
}

// For printf.
std::string number_format(const ControlNow& now) {
  const std::string unit = now.unit == std::string_view(" %") ? " %%" : now.unit;
  return now.step == 1 ? "%d" + unit : fmt::format("%.{}f{}", now.decimals, unit);
}

std::optional<double> draw_whole_number(const char* label, const ControlNow& now) {
  auto value = static_cast<int>(now.value);
  const auto least = static_cast<int>(now.least), most = static_cast<int>(now.most);
  const bool changed = now.is_typed
                           ? ImGui::InputInt(label, &value, now.most > kWideRange ? kFieldStep : 1)
                           : ImGui::SliderInt(label, &value, least, most,
                                              number_format(now).c_str(), slider_flags(now));
  return changed ? std::optional<double>(std::clamp(value, least, most)) : std::nullopt;
}

std::optional<double> draw_number(const char* label, const ControlNow& now) {
  if (now.step == 1) return draw_whole_number(label, now);
  double value = now.value;
  const std::string format = number_format(now);
  const auto speed = static_cast<float>(std::max(std::abs(value), 1e-3) / kDragPixels);
  const bool changed =
      now.is_typed ? ImGui::DragScalar(label, ImGuiDataType_Double, &value, speed, &now.least,
                                       &now.most, format.c_str(), slider_flags(now))
                   : ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &now.least, &now.most,
                                         format.c_str(), slider_flags(now));
  return changed ? std::optional(std::clamp(value, now.least, now.most)) : std::nullopt;
}

std::optional<double> draw_choice(const char* label, const ControlNow& now) {
  std::optional<double> chosen;
  const auto shown = static_cast<std::size_t>(now.value);
  if (!ImGui::BeginCombo(label, now.choices[shown].c_str())) return chosen;
  for (std::size_t i = 0; i < now.choices.size(); ++i) {
    if (ImGui::Selectable(now.choices[i].c_str(), i == shown)) chosen = static_cast<double>(i);
    if (i == shown) ImGui::SetItemDefaultFocus();
  }
  ImGui::EndCombo();
  return chosen;
}

std::optional<double> draw_color(const char* label, const ControlNow& now) {
  glm::vec3 color = rgb(static_cast<std::uint32_t>(now.value));
  const bool changed = ImGui::ColorEdit3(label, &color.x, ImGuiColorEditFlags_NoInputs);
  return changed ? std::optional(hex_of(color)) : std::nullopt;
}

std::optional<double> draw_toggle(const char* label, const ControlNow& now) {
  bool is_on = now.value != 0;
  return ImGui::Checkbox(label, &is_on) ? std::optional(is_on ? 1.0 : 0.0) : std::nullopt;
}

std::optional<double> draw_value(ControlKind kind, const char* label, const ControlNow& now) {
  using enum ControlKind;
  if (kind == toggle) return draw_toggle(label, now);
  if (kind == choice) return draw_choice(label, now);
  if (kind == number) return draw_number(label, now);
  if (kind == color) return draw_color(label, now);
  return kind == button && ImGui::Button(label) ? std::optional(0.0) : std::nullopt;
}

// The width of a button or of a check box with its label.
float width_of(ControlKind kind, const std::string& label) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float text = ImGui::CalcTextSize(label.c_str()).x;
  if (kind == ControlKind::button) return text + 2 * style.FramePadding.x;
  return text + ImGui::GetFrameHeight() + style.ItemInnerSpacing.x;
}

// Panels name controls of the table only.
const Control& control_named(std::string_view name) {
  const Control* const control = find_control(name);
  assert(control != nullptr);
  return *control;
}

// The text to the left of a field.
void draw_title(const std::string& title, float width) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(palette::kFaint, "%s", title.c_str());
  same_line_if_fits(std::max(width, 0.0f));
}

}  // namespace

void ControlsDrawer::with(
    std::string_view name,
    const std::function<void(const Control& control, const ControlNow& now)>& draw) const {
  const Control& control = control_named(name);
  const std::optional<ControlNow> now = control_now(viewer_, control);
  if (!now) return;
  ImGui::PushID(control.name.c_str());
  ImGui::BeginDisabled(!now->is_enabled);
  draw(control, *now);
  ImGui::EndDisabled();
  show_tooltip(name);
  ImGui::PopID();
}

void ControlsDrawer::draw(const block::Placed& placed) const {
  if (placed.form == block::Form::radio) return draw_radio(placed.name, true);
  if (placed.form == block::Form::range) return draw_range(placed);
  with(placed.name, [&](const Control& control, const ControlNow& now) {
    const float width = placed.width * ImGui::GetFontSize();
    std::string label = placed.short_label.value_or(label_of(control, now));
    if (placed.follows) same_line_if_fits(width_of(control.kind, label));
    if (!placed.title.empty()) draw_title(placed.title, width);
    if (!placed.title.empty() || label.empty()) label = "##value";
    if (placed.width != 0) ImGui::SetNextItemWidth(width);
    if (placed.mode) ImGui::PushStyleColor(ImGuiCol_Text, palette::text_of(ink_of(*placed.mode)));
    if (placed.form == block::Form::small_button) {
      if (ImGui::SmallButton(label.c_str())) set(placed.name, 0);
    } else if (const auto value = draw_value(control.kind, label.c_str(), now)) {
      set(placed.name, *value);
    }
    if (placed.mode) ImGui::PopStyleColor();
  });
}

void ControlsDrawer::draw_radio(std::string_view name, bool in_lines) const {
  with(name, [&](const Control&, const ControlNow& now) {
    for (std::size_t i = 0; i < now.choices.size(); ++i) {
      const char* const text = now.choices[i].c_str();
      if (in_lines && i > 0)
        same_line_if_fits(ImGui::CalcTextSize(text).x + 2 * ImGui::GetFontSize());
      if (ImGui::RadioButton(text, static_cast<std::size_t>(now.value) == i))
        set(name, static_cast<double>(i));
      if (i + 1 < now.choices.size()) show_tooltip(name);  // with() shows the last one's
    }
  });
}

void ControlsDrawer::draw_range(const block::Placed& placed) const {
  const std::string ends[] = {placed.name + ", from", placed.name + ", to"};
  with(ends[0], [&](const Control&, const ControlNow& from) {
    const auto to = control_now(viewer_, control_named(ends[1]));
    float values[] = {static_cast<float>(from.value), static_cast<float>(to->value)};
    const float before[] = {values[0], values[1]};
    const std::string format = number_format(from);
    ImGui::SetNextItemWidth(placed.width * ImGui::GetFontSize());
    ImGui::DragFloatRange2(placed.name.c_str(), &values[0], &values[1],
                           static_cast<float>(placed.speed), 0, 0, format.c_str(), format.c_str());
    for (int end = 0; end < 2; ++end)
      if (values[end] != before[end])
        set(ends[end], std::clamp(static_cast<double>(values[end]), from.least, from.most));
  });
}

void ControlsDrawer::draw_menu_item(std::string_view name) const {
  with(name, [&](const Control& control, const ControlNow& now) {
    if (ImGui::MenuItem(label_of(control, now).c_str(), nullptr, now.value != 0, now.is_enabled))
      set(name, now.value == 0 ? 1 : 0);
  });
}

void ControlsDrawer::set(std::string_view name, double value, std::size_t index) const {
  if (auto action = set_control(viewer_, control_named(name), value, index))
    actions_.push_back(std::move(*action));
}

void ControlsDrawer::show_tooltip(std::string_view name) const {
  const std::string& help = control_named(name).help;
  if (!help.empty() && ImGui::IsItemHovered()) tooltip_beside(help);
}

}  // namespace qs
