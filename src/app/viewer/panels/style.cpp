// SPDX-License-Identifier: MIT
#include "app/viewer/panels/style.h"

#include <algorithm>
#include <utility>

namespace qs {
namespace {

constexpr Ink themed(std::uint32_t dark, std::uint32_t light) { return {rgb(dark), rgb(light)}; }

// Texts have a contrast of at least 4.5 : 1 on their backgrounds; a test compares them.

// Index = palette::tones.
constexpr Ink kTones[] = {{on_dark::kPanel, on_white::kWhite},
                          {on_dark::kText, on_white::kInk},
                          {on_dark::kFaint, rgb(0x5C616C)},
                          {kSkyBlue, kBlue},
                          {kOrange, rgb(0x8A5A00)},
                          themed(0xE65C38, 0xB3261E)};

constexpr std::pair<ImGuiCol, Ink> kStyleColors[] = {
    {ImGuiCol_Text, kTones[1]},
    {ImGuiCol_TextDisabled, kTones[2]},
    {ImGuiCol_WindowBg, kTones[0]},
    {ImGuiCol_PopupBg, kTones[0]},
    {ImGuiCol_CheckMark, kTones[3]},
    {ImGuiCol_PlotLines, kTones[3]},
    {ImGuiCol_MenuBarBg, themed(0x121316, 0xF0F1F3)},
    {ImGuiCol_TitleBg, themed(0x1C1D21, 0xE6E8EC)},
    {ImGuiCol_TitleBgActive, themed(0x1C1D21, 0xE6E8EC)},
    {ImGuiCol_TitleBgCollapsed, themed(0x1C1D21, 0xE6E8EC)},
    {ImGuiCol_FrameBg, themed(0x292B30, 0xDDE0E6)},
    {ImGuiCol_FrameBgHovered, themed(0x33363D, 0xD3D7DE)},
    {ImGuiCol_FrameBgActive, themed(0x3D4047, 0xC9CED6)},
    {ImGuiCol_Button, themed(0x2E3038, 0xDFE3E9)},
    {ImGuiCol_ButtonHovered, themed(0x275169, 0xB3DDF5)},
    {ImGuiCol_ButtonActive, themed(0x346C8C, 0x9AD2F2)},
    {ImGuiCol_Header, themed(0x152B38, 0xD6EDFA)},
    {ImGuiCol_HeaderHovered, themed(0x1B3848, 0xCAE8F8)},
    {ImGuiCol_HeaderActive, themed(0x2B5A75, 0xAADAF4)},
    // A slider draws its value over its grab, a progress bar its text over the bar.
    {ImGuiCol_SliderGrab, themed(0x22485D, 0xBBE1F6)},
    {ImGuiCol_SliderGrabActive, themed(0x2F6380, 0xA2D6F3)},
    {ImGuiCol_PlotHistogram, themed(0x2F6380, 0xA2D6F3)},
    {ImGuiCol_TableHeaderBg, themed(0x212226, 0xF0F1F3)},
    {ImGuiCol_TableRowBgAlt, themed(0x1B1C20, 0xF9F9FA)}};

}  // namespace

float drawing_scale() { return ImGui::GetFontSize() / kFontSize; }

void apply_style(float scale, bool is_light) {
  palette::is_light = is_light;
  std::ranges::transform(kTones, palette::tones,
                         [](const Ink& tone) { return palette::with_opacity(tone); });
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();  // the sizes of the scale before
  if (is_light) {
    ImGui::StyleColorsLight();
  } else {
    ImGui::StyleColorsDark();
  }
  style.WindowRounding = 6;
  style.FrameRounding = 4;
  style.GrabRounding = 4;
  style.PopupRounding = 4;
  style.WindowBorderSize = 0;
  style.WindowPadding = {12, 10};
  style.FramePadding = {8, 4};
  style.ItemSpacing = {8, 6};
  style.CellPadding = {6, 3};
  style.WindowTitleAlign = {0, 0.5f};
  for (const auto& [which, color] : kStyleColors)
    style.Colors[which] = palette::with_opacity(color);
  style.Colors[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, 0.45f};
  style.ScaleAllSizes(scale);
}

}  // namespace qs
