// SPDX-License-Identifier: MIT
//
// Toasts, progress, and the log of messages.
#include <algorithm>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

constexpr ImGuiWindowFlags kPlain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoNav |
                                    ImGuiWindowFlags_AlwaysAutoResize |
                                    ImGuiWindowFlags_NoFocusOnAppearing;

void draw_loading(const Loading& loading, const Rect& picture, Actions& actions) {
  const float width = std::min(26 * ImGui::GetFontSize(), picture.size().x);
  // The progress is at the lower edge of the picture.
  const float low = picture.high.y - ImGui::GetFontSize();
  ImGui::SetNextWindowPos({picture.center().x, low}, ImGuiCond_Always, {0.5f, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Loading", nullptr, kPlain & ~ImGuiWindowFlags_AlwaysAutoResize);
  ImGui::Text("%s %s", loading.what.c_str(), loading.path.filename().c_str());
  ImGui::SameLine();
  right_aligned(fmt::format("{:.0f} %", 100 * loading.fraction));
  ImGui::ProgressBar(loading.fraction, {-1, 0.5f * ImGui::GetFontSize()}, "");
  if (ImGui::Button("Cancel")) actions.push_back(call(action::cancel_loading));
  ImGui::End();
}

void draw_toasts(const Viewer& viewer, const Rect& picture) {
  const float width = std::min(36 * ImGui::GetFontSize(), picture.size().x - 60);
  float bottom = picture.high.y - 14;
  int number = 0;
  for (auto toast = viewer.toasts.rbegin(); toast != viewer.toasts.rend() && number < 5; ++toast) {
    ImGui::SetNextWindowPos({picture.high.x - 14, bottom}, ImGuiCond_Always, {1, 1});
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

void draw_log(const Viewer& viewer, PanelState&, Actions&) {
  if (viewer.log.empty()) ImGui::TextColored(palette::kFaint, "There are no messages yet.");
  for (auto entry = viewer.log.rbegin(); entry != viewer.log.rend(); ++entry) {
    ImGui::TextColored(palette::kFaint, "%s", log_time(*entry).c_str());
    ImGui::SameLine();
    ImGui::PushStyleColor(ImGuiCol_Text, entry->error ? palette::kError : palette::kText);
    ImGui::TextWrapped("%s", entry->text.c_str());
    ImGui::PopStyleColor();
  }
}

void draw_messages(const Viewer& viewer, Actions& actions) {
  const Rect picture = current_layout(viewer).picture;
  if (viewer.loading) draw_loading(*viewer.loading, picture, actions);
  draw_toasts(viewer, picture);
}

}  // namespace qs
