// SPDX-License-Identifier: MIT
//
// Toasts, progress, and the log of messages.
#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "app/viewer/state/camera_actions.h"
#include "app/viewer/state/edit_actions.h"
#include "app/viewer/state/panel_text.h"
#include "app/viewer/state/zoom_actions.h"

namespace qs {
namespace {

void draw_loading(const Viewer& viewer, const Rect& place, Actions& actions) {
  const std::string runs = running_text(viewer);
  const float room = ImGui::CalcTextSize(runs.c_str()).x + ImGui::GetFontSize();
  ImGui::SetNextWindowPos({place.low.x, place.low.y});
  ImGui::SetNextWindowSize({place.size().x, place.size().y});
  ImGui::Begin("Loading", nullptr, kBareWindow);
  const std::string name = viewer.loading->path.filename().string();
  ImGui::TextUnformatted(fitted(name, ImGui::GetContentRegionAvail().x - room).c_str());
  ImGui::SameLine();
  right_aligned(runs);
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
  const bool both = offer == ToastOffer::turn_over;
  if ((both || offer == ToastOffer::next_axes) && ImGui::Button("Turn it"))
    actions.push_back(call(action::next_axes));
  if (both) ImGui::SameLine();
  if (both && ImGui::Button("Turn it over")) actions.push_back(call(action::turn_over));
  if (offer == ToastOffer::apply_edits && ImGui::Button("Apply the edits"))
    actions.push_back([](Viewer& v, Host& host) {
      if (v.scene) action::open_edits(v, host, kept_edits_file(v.scene->path));
    });
  if (offer == ToastOffer::save_results && ImGui::Button("Save as ..."))
    actions.push_back(call(action::toggle_open_dialog, Choosing::results));
}

bool has_buttons(const Toast& toast) {
  return !toast.path.empty() || toast.offer != ToastOffer::none;
}

// Draws a message, counted from the newest.
void draw_toast(const Viewer& viewer, std::size_t number, const std::string& shown,
                const Rect& place, Actions& actions) {
  const std::size_t index = viewer.toasts.size() - 1 - number;
  const Toast& toast = viewer.toasts[index];
  ImGui::SetNextWindowPos({place.low.x, place.low.y});
  ImGui::SetNextWindowSize({place.size().x, place.size().y});
  ImGui::PushStyleColor(ImGuiCol_Border, toast.error ? palette::kError : palette::kAccent);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 2 * drawing_scale());
  // A click of a tool is the picture's, unless there are buttons.
  const int inputs = viewer.has_tool() && !has_buttons(toast) ? ImGuiWindowFlags_NoMouseInputs : 0;
  ImGui::Begin(fmt::format("toast {}", number).c_str(), nullptr, kBareWindow | inputs);
  const bool hovered = ImGui::IsWindowHovered();
  ImGui::PushTextWrapPos(place.size().x - ImGui::GetStyle().WindowPadding.x);
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
  ImGui::End();
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
}

void add_toasts(const Viewer& viewer, Floats& floats, Actions& actions) {
  constexpr std::size_t kMostShown = 5;
  const ImGuiStyle& style = ImGui::GetStyle();
  const float letter = ImGui::GetFontSize();
  const glm::vec2 padding(3 * style.WindowPadding.x, 2 * style.WindowPadding.y);
  const float width = std::min(floats.room() - padding.x, 36 * letter);
  for (std::size_t number = 0; number < std::min(viewer.toasts.size(), kMostShown); ++number) {
    const Toast& toast = viewer.toasts[viewer.toasts.size() - 1 - number];
    const std::string shown = fitted_text(toast, width);
    const ImVec2 text = ImGui::CalcTextSize(shown.c_str(), nullptr, false, width);
    const bool buttons = has_buttons(toast);
    const float least = buttons ? std::min(8 * letter, width) : 0;
    const float more = buttons ? style.ItemSpacing.y + ImGui::GetFrameHeight() : 0;
    const glm::vec2 size = glm::vec2(std::max(text.x, least), text.y + more) + padding;
    // The end of a text that is higher than the picture is missing.
    const float most = floats.picture().size().y - padding.x;
    floats.add({FloatKind::message, glm::min(size, {size.x, most})},
               [=, &viewer, &actions](const Rect& place) {
                 draw_toast(viewer, number, shown, place, actions);
               });
  }
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

void draw_messages(const Viewer& viewer, Floats& floats, Actions& actions) {
  if (viewer.loading) {
    const ImGuiStyle& style = ImGui::GetStyle();
    const float letter = ImGui::GetFontSize();
    const float height = 1.5f * letter + ImGui::GetFrameHeight() + 2 * style.ItemSpacing.y +
                         2 * style.WindowPadding.y;
    floats.add({FloatKind::progress, {std::min(26 * letter, floats.room()), height}},
               [&](const Rect& place) { draw_loading(viewer, place, actions); });
  }
  add_toasts(viewer, floats, actions);
}

}  // namespace qs
