// SPDX-License-Identifier: MIT
//
// Toasts, progress, and the log of messages.
#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/zoom_actions.h"

namespace qs {
namespace {

void draw_loading(const Viewer& viewer, const Rect& picture, Actions& actions) {
  const float width = std::min(26 * ImGui::GetFontSize(), picture.size().x);
  // The progress is at the lower edge of the picture.
  const float low = picture.high.y - ImGui::GetFontSize();
  ImGui::SetNextWindowPos({picture.center().x, low}, ImGuiCond_Always, {0.5f, 1});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Loading", nullptr, kBareWindow);
  ImGui::TextUnformatted(viewer.loading->path.filename().c_str());
  ImGui::SameLine();
  right_aligned(running_text(viewer));
  ImGui::ProgressBar(viewer.loading->fraction, {-1, 0.5f * ImGui::GetFontSize()}, "");
  if (ImGui::Button("Cancel")) actions.push_back(call(action::cancel_loading));
  ImGui::End();
}

// The text with its path shortened so that a line of this width holds it.
std::string fitted_text(const Toast& toast, float width) {
  const std::string path = toast.path.string();
  const std::size_t at = path.empty() ? std::string::npos : toast.text.find(path);
  if (at == std::string::npos) return toast.text;
  const auto with = [&](const std::string& shown) {
    return toast.text.substr(0, at) + shown + toast.text.substr(at + path.size());
  };
  std::string text = toast.text;
  for (std::size_t letters = letters_of(path); letters > 12; --letters) {
    text = with(shortened_middle(path, letters));
    if (ImGui::CalcTextSize(text.c_str()).x <= width) break;
  }
  return text;
}

void draw_file_buttons(const std::filesystem::path& path, Actions& actions) {
  if (ImGui::Button("Open")) actions.push_back(call(&Host::open_with_desktop, path));
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("In the desktop's program for it");
  ImGui::SameLine();
  if (ImGui::Button("Copy")) actions.push_back(call(action::copy_text, path.string()));
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("Its path to the clipboard");
}

void draw_offer(ToastOffer offer, Actions& actions) {
  if (offer == ToastOffer::skip_huge && ImGui::Button("Leave them out"))
    actions.push_back(call(action::skip_huge, true));
  if (offer == ToastOffer::next_axes && ImGui::Button("Turn it"))
    actions.push_back(call(action::next_axes));
  if (offer == ToastOffer::turn_over && ImGui::Button("Turn it over"))
    actions.push_back(call(action::turn_over));
  if (offer == ToastOffer::save_results && ImGui::Button("Save as ..."))
    actions.push_back(call(action::toggle_open_dialog, Choosing::results));
}

// Draws a message, counted from the newest, with its lower right corner at `corner`, and moves the
// corner above it. True if the mouse is over the message.
bool draw_toast(const Viewer& viewer, std::size_t number, glm::vec2& corner, float width,
                Actions& actions) {
  const std::size_t index = viewer.toasts.size() - 1 - number;
  const Toast& toast = viewer.toasts[index];
  const std::string shown = fitted_text(toast, width);
  const ImGuiStyle& style = ImGui::GetStyle();
  const ImVec2 text = ImGui::CalcTextSize(shown.c_str(), nullptr, false, width);
  const bool buttons = !toast.path.empty() || toast.offer != ToastOffer::none;
  const float least = buttons ? 8 * ImGui::GetFontSize() : 0;
  const float more = buttons ? style.ItemSpacing.y + ImGui::GetFrameHeight() : 0;
  ImGui::SetNextWindowPos({corner.x, corner.y}, ImGuiCond_Always, {1, 1});
  // A window without a height is not shown in its first drawing, which may be the only one.
  ImGui::SetNextWindowSize({std::max(text.x, least) + 3 * style.WindowPadding.x,
                            text.y + more + 2 * style.WindowPadding.y});
  ImGui::PushStyleColor(ImGuiCol_Border, toast.error ? palette::kError : palette::kAccent);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 2 * drawing_scale());
  ImGui::Begin(fmt::format("toast {}", number).c_str(), nullptr, kBareWindow);
  const bool hovered = ImGui::IsWindowHovered();
  ImGui::PushTextWrapPos(style.WindowPadding.x + width);
  ImGui::TextUnformatted(shown.c_str());
  ImGui::PopTextWrapPos();
  draw_offer(toast.offer, actions);
  if (!toast.path.empty()) {
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", toast.path.c_str());
    draw_file_buttons(toast.path, actions);
  }
  // A click beside the buttons takes the message away from the picture.
  if (hovered && ImGui::IsMouseClicked(ImGuiMouseButton_Left) && !ImGui::IsAnyItemHovered())
    actions.push_back(call(action::dismiss_toast, index));
  corner.y -= ImGui::GetWindowSize().y + 8 * drawing_scale();
  ImGui::End();
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
  return hovered;
}

void draw_toasts(const Viewer& viewer, const Rect& picture, Actions& actions) {
  constexpr std::size_t kMostShown = 5;
  const float by = drawing_scale();
  const float letter = ImGui::GetFontSize(), margins = 60 * by;
  // Beside wide bars the messages cover a bar too.
  const float least = std::min(18 * letter, ImGui::GetIO().DisplaySize.x - margins);
  const float width = std::clamp(picture.size().x - margins, least, 36 * letter);
  glm::vec2 corner = picture.high - 14 * by;
  const Rect strip = view_choice_area(viewer);
  if (!strip.empty()) corner.y = strip.low.y - 8 * by;
  bool hovered = false;
  for (std::size_t number = 0; number < std::min(viewer.toasts.size(), kMostShown); ++number)
    hovered |= draw_toast(viewer, number, corner, width, actions);
  if (hovered != viewer.toasts_held) actions.push_back(call(action::hold_toasts, hovered));
}

// The menu of a right click on the message that was drawn last.
void draw_entry_menu(const LogEntry& entry, Actions& actions) {
  if (!ImGui::BeginPopupContextItem("entry")) return;
  if (!entry.path.empty()) {
    if (ImGui::MenuItem("Open the file"))
      actions.push_back(call(&Host::open_with_desktop, entry.path));
    if (ImGui::MenuItem("Copy the path"))
      actions.push_back(call(action::copy_text, entry.path.string()));
  }
  if (ImGui::MenuItem("Copy the message")) actions.push_back(call(action::copy_text, entry.text));
  ImGui::EndPopup();
}

}  // namespace

void draw_log(const Viewer& viewer, Actions& actions) {
  if (viewer.log.empty()) ImGui::TextColored(palette::kFaint, "There are no messages yet.");
  for (std::size_t i = viewer.log.size(); i-- > 0;) {
    const LogEntry& entry = viewer.log[i];
    ImGui::PushID(static_cast<int>(i));
    ImGui::TextColored(palette::kFaint, "%s", log_time(entry).c_str());
    ImGui::SameLine();
    draw_wrapped(entry.error ? palette::kError : palette::kText, entry.text);
    draw_entry_menu(entry, actions);
    ImGui::PopID();
  }
}

void draw_messages(const Viewer& viewer, Actions& actions) {
  const Rect picture = current_layout(viewer).picture;
  if (viewer.loading) draw_loading(viewer, picture, actions);
  draw_toasts(viewer, picture, actions);
}

}  // namespace qs
