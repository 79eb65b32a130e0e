// SPDX-License-Identifier: MIT
#include "app/viewer/panels/controls_drawer.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"

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
  }
  ImGui::EndCombo();
  return chosen;
}

std::optional<double> draw_color(const char* label, const ControlNow& now) {
  const auto bits = static_cast<std::uint32_t>(now.value);
  float color[3];
  for (int c = 0; c < 3; ++c) color[c] = static_cast<float>(bits >> (16 - 8 * c) & 0xff) / 255;
  if (!ImGui::ColorEdit3(label, color, ImGuiColorEditFlags_NoInputs)) return {};
  double hex = 0;
  for (const float part : color)
    hex = 256 * hex + std::round(255 * std::clamp(static_cast<double>(part), 0.0, 1.0));
  return hex;
}

std::optional<double> draw_toggle(const char* label, const ControlNow& now) {
  bool is_on = now.value != 0;
  return ImGui::Checkbox(label, &is_on) ? std::optional(is_on ? 1.0 : 0.0) : std::nullopt;
}

std::optional<double> draw_value(ControlKind kind, const char* label, const ControlNow& now) {
  switch (kind) {
    case ControlKind::toggle:
      return draw_toggle(label, now);
    case ControlKind::choice:
      return draw_choice(label, now);
    case ControlKind::number:
      return draw_number(label, now);
    case ControlKind::color:
      return draw_color(label, now);
    case ControlKind::button:
      return ImGui::Button(label) ? std::optional(0.0) : std::nullopt;
    case ControlKind::item:
      break;
  }
  return {};
}

float button_width(const std::string& label) {
  return ImGui::CalcTextSize(label.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
}

}  // namespace

void ControlsDrawer::with(
    std::string_view name,
    const std::function<void(const Control& control, const ControlNow& now)>& draw) const {
  const Control* const control = find_control(name);
  assert(control != nullptr);
  if (control == nullptr) return;
  const std::optional<ControlNow> now = control_now(viewer_, *control);
  if (!now) return;
  ImGui::PushID(control->name.c_str());
  ImGui::BeginDisabled(!now->is_enabled);
  draw(*control, *now);
  ImGui::EndDisabled();
  show_tooltip(name);
  ImGui::PopID();
}

void ControlsDrawer::draw(std::string_view name, const char* label) const {
  with(name, [&](const Control& control, const ControlNow& now) {
    const std::string text = label == nullptr ? label_of(control, now) : label;
    const auto value = draw_value(control.kind, text.empty() ? "##value" : text.c_str(), now);
    if (value) set(name, *value);
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

void ControlsDrawer::draw_radio_buttons(std::string_view name) const { draw_radio(name, true); }
void ControlsDrawer::draw_radio_list(std::string_view name) const { draw_radio(name, false); }

void ControlsDrawer::draw_button(std::string_view name, bool is_small) const {
  with(name, [&](const Control& control, const ControlNow& now) {
    const std::string& label = label_of(control, now);
    same_line_if_fits(button_width(label));
    if (is_small ? ImGui::SmallButton(label.c_str()) : ImGui::Button(label.c_str())) set(name, 0);
  });
}

void ControlsDrawer::draw_button_after(std::string_view name) const { draw_button(name, true); }
void ControlsDrawer::draw_after(std::string_view name) const { draw_button(name, false); }

void ControlsDrawer::draw_range(const char* name, double speed) const {
  const std::string ends[] = {fmt::format("{}, from", name), fmt::format("{}, to", name)};
  with(ends[0], [&](const Control&, const ControlNow& from) {
    const auto to = control_now(viewer_, *find_control(ends[1]));
    float values[] = {static_cast<float>(from.value), static_cast<float>(to->value)};
    const float before[] = {values[0], values[1]};
    const std::string format = number_format(from);
    ImGui::DragFloatRange2(name, &values[0], &values[1], static_cast<float>(speed), 0, 0,
                           format.c_str(), format.c_str());
    for (int end = 0; end < 2; ++end) {
      if (values[end] != before[end])
        set(ends[end], std::clamp(static_cast<double>(values[end]), from.least, from.most));
    }
  });
}

void ControlsDrawer::draw_menu_item(std::string_view name) const {
  with(name, [&](const Control& control, const ControlNow& now) {
    if (ImGui::MenuItem(label_of(control, now).c_str(), nullptr, now.value != 0, now.is_enabled))
      set(name, now.value == 0 ? 1 : 0);
  });
}

void ControlsDrawer::set(std::string_view name, double value, std::size_t index) const {
  const Control* const control = find_control(name);
  assert(control != nullptr);
  if (control == nullptr) return;
  if (auto action = set_control(viewer_, *control, value, index))
    actions_.push_back(std::move(*action));
}

void ControlsDrawer::show_tooltip(std::string_view name) const {
  const Control* const control = find_control(name);
  assert(control != nullptr);
  if (control != nullptr && !control->help.empty() && ImGui::IsItemHovered())
    ImGui::SetTooltip("%s", control->help.c_str());
}

}  // namespace qs
