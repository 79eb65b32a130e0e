// SPDX-License-Identifier: MIT
//
// Toasts, progress, and the empty window's invitation.
#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoNav |
                                    ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoFocusOnAppearing;

void draw_loading(const Loading& loading, Actions& actions) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float width = 26 * ImGui::GetFontSize();
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Loading", nullptr, kPlain & ~ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::Text("%s %s", loading.what.c_str(), loading.path.filename().c_str());
  ImGui::ProgressBar(loading.fraction, {-1, 0});
  if (ImGui::Button("Cancel")) actions.push_back(call(action::cancel_loading));
  ImGui::End();
}

void draw_toasts(const Viewer& viewer) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float width = 36 * ImGui::GetFontSize();
  float bottom = display.y - 14;
  int number = 0;
  for (auto toast = viewer.toasts.rbegin(); toast != viewer.toasts.rend() && number < 5; ++toast) {
    ImGui::SetNextWindowPos({display.x - 14, bottom}, ImGuiCond_Always, {1, 1});
    const float text = ImGui::CalcTextSize(toast->text.c_str(), nullptr, false, width).x;
    ImGui::SetNextWindowSize({text + 3 * ImGui::GetStyle().WindowPadding.x, 0});
    ImGui::PushStyleColor(ImGuiCol_Border, toast->error ? palette::kError : palette::kAccent);
    ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 2);
    ImGui::Begin(fmt::format("toast {}", number++).c_str(), nullptr,
                 (kPlain & ~ImGuiWindowFlags_AlwaysAutoResize) | ImGuiWindowFlags_NoInputs);
    ImGui::PushTextWrapPos(width);
    ImGui::TextUnformatted(toast->text.c_str());
    ImGui::PopTextWrapPos();
    bottom -= ImGui::GetWindowSize().y + 8;
    ImGui::End();
    ImGui::PopStyleVar();
    ImGui::PopStyleColor();
  }
}

}  // namespace

void draw_messages(const Viewer& viewer, Actions& actions) {
  if (viewer.loading) draw_loading(*viewer.loading, actions);
  draw_toasts(viewer);
}

void draw_welcome(const Viewer& viewer, Actions& actions) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::Begin("Welcome", nullptr, kPlain);
  ImGui::TextUnformatted("Drop a splat file or the folder of a trained model here.");
  if (ImGui::Button("Open ...")) actions.push_back(call(action::toggle_panel, &Panels::open));
  command_tooltip("Open a file");
  for (const std::filesystem::path& path : viewer.recent) {
    if (ImGui::Selectable(path.c_str())) actions.push_back(call(action::open, path));
  }
  ImGui::End();
}

}  // namespace qs
