// SPDX-License-Identifier: MIT
#include "app/viewer/panels/style.h"

namespace qs {

float drawing_scale() { return ImGui::GetFontSize() / kFontSize; }

void apply_style(float scale) {
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();  // the sizes of the scale before
  ImGui::StyleColorsDark();
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
  const auto tinted = [](float strength) {
    return ImVec4(palette::kAccent.x * strength, palette::kAccent.y * strength,
                  palette::kAccent.z * strength, 1);
  };
  ImVec4* colors = style.Colors;
  colors[ImGuiCol_Text] = palette::kText;
  colors[ImGuiCol_TextDisabled] = palette::kFaint;
  colors[ImGuiCol_WindowBg] = colors[ImGuiCol_PopupBg] = palette::kPanel;
  colors[ImGuiCol_MenuBarBg] = {0.07f, 0.075f, 0.085f, 1};
  colors[ImGuiCol_TitleBg] = colors[ImGuiCol_TitleBgActive] = {0.11f, 0.115f, 0.13f, 1};
  colors[ImGuiCol_TitleBgCollapsed] = {0.11f, 0.115f, 0.13f, 0.8f};
  colors[ImGuiCol_FrameBg] = {0.16f, 0.17f, 0.19f, 1};
  colors[ImGuiCol_FrameBgHovered] = {0.20f, 0.21f, 0.24f, 1};
  colors[ImGuiCol_FrameBgActive] = {0.24f, 0.25f, 0.28f, 1};
  colors[ImGuiCol_Button] = {0.18f, 0.19f, 0.22f, 1};
  colors[ImGuiCol_ButtonHovered] = tinted(0.45f);
  colors[ImGuiCol_ButtonActive] = tinted(0.60f);
  colors[ImGuiCol_Header] = tinted(0.30f);
  colors[ImGuiCol_HeaderHovered] = tinted(0.40f);
  colors[ImGuiCol_HeaderActive] = tinted(0.50f);
  colors[ImGuiCol_CheckMark] = palette::kAccent;
  // Dark enough for the slider's value, which is drawn over its grab.
  colors[ImGuiCol_SliderGrab] = tinted(0.40f);
  colors[ImGuiCol_SliderGrabActive] = tinted(0.55f);
  colors[ImGuiCol_ModalWindowDimBg] = {0, 0, 0, 0.45f};
  colors[ImGuiCol_PlotLines] = colors[ImGuiCol_PlotHistogram] = palette::kAccent;
  colors[ImGuiCol_TableHeaderBg] = {0.13f, 0.135f, 0.15f, 1};
  colors[ImGuiCol_TableRowBgAlt] = {1, 1, 1, 0.025f};
  style.ScaleAllSizes(scale);
}

}  // namespace qs
