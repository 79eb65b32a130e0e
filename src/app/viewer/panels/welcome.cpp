// SPDX-License-Identifier: MIT
//
// The window without a scene: a description of the program, the bundled scene, recent files,
// formats, and the hints of the first start.
#include <algorithm>
#include <string>
#include <vector>

#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"
#include "base/assets.h"
#include "base/text.h"
#include "io/scene/reader.h"

namespace qs {
namespace {

constexpr int kRecentShown = 6;

void draw_bundled_scene(const PanelState& state, Actions& actions) {
  const auto scene = find_asset(kBundledScene);
  if (!scene) return;
  const int frame = static_cast<int>(ImGui::GetStyle().FramePadding.y);
  const float width = ImGui::GetContentRegionAvail().x - static_cast<float>(2 * frame);
  const auto open = [&] { actions.push_back(call(action::open, *scene)); };
  if (state.thumbnail != 0) {
    if (ImGui::ImageButton(texture_id(state.thumbnail), {width, width / state.thumbnail_aspect},
                           {0, 0}, {1, 1}, frame))
      open();
  }
  if (ImGui::Button("Open the bundled scene")) open();
}

std::string formats_text() {
  std::vector<std::string> endings;
  for (const ReaderRow& row : readers())
    for (const std::string& word : separated(row.extensions, ' '))
      if (word.find('.', 1) == word.npos) add_new(endings, word);
  return "Or drop a scene here (" + joined(endings, ", ") +
         "), the folder of a trained model, or cameras.";
}

}  // namespace

void draw_welcome(const Viewer& viewer, const PanelState& state, Actions& actions) {
  const Rect picture = current_layout(viewer).picture;
  const glm::vec2 center = picture.center();
  const float letter = ImGui::GetFontSize();
  // The height follows the content, so the picture is smaller in a low window.
  const float width = std::min({30 * letter, picture.size().x, 0.8f * picture.size().y});
  ImGui::SetNextWindowPos({center.x, center.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::Begin("Welcome", nullptr, kBareWindow);
  ImGui::TextWrapped(
      "quadsplat shows 3D Gaussian splatting scenes in real time, and measures what "
      "their tile culling costs.");
  ImGui::Spacing();
  draw_bundled_scene(state, actions);
  same_line_if_fits(8 * letter);
  if (ImGui::Button("Open a file ..."))
    actions.push_back(call(action::toggle_open_dialog, Choosing::scene));
  command_tooltip("Open a file");
  if (!viewer.recent.empty()) {
    ImGui::Spacing();
    draw_wrapped(palette::kFaint, "Recent files");
  }
  for (int i = 0; i < std::min(kRecentShown, static_cast<int>(viewer.recent.size())); ++i) {
    const std::filesystem::path& path = viewer.recent[static_cast<std::size_t>(i)];
    ImGui::PushID(i);
    if (ImGui::Selectable(path.filename().c_str())) actions.push_back(call(action::open, path));
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", path.c_str());
    ImGui::PopID();
  }
  ImGui::Spacing();
  draw_wrapped(palette::kFaint, formats_text());
  ImGui::End();
}

void draw_hints(const Viewer& viewer, Floats& floats) {
  const std::vector<std::string> hints = hint_texts(viewer.hints);
  if (hints.empty() || !viewer.scene || viewer.loading) return;
  // Hints wait until the lower part of the picture is free.
  const bool covered = viewer.shown.grid || viewer.shown.heatmap || viewer.shown.values;
  if (covered || !viewer.toasts.empty() || viewer.view_choice.pictures || viewer.panels.help)
    return;
  const float room = floats.room() - ImGui::GetFontSize();
  std::string line = hints[0], text = line;
  for (std::size_t i = 1; i < hints.size(); ++i) {
    const std::string next = "   \u00b7   " + hints[i];
    const bool fits = ImGui::CalcTextSize((line + next).c_str()).x <= room;
    text += fits ? next : "\n" + hints[i];
    line = fits ? line + next : hints[i];
  }
  floats.add_plate(FloatKind::hints, text);
}

}  // namespace qs
