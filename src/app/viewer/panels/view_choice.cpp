// SPDX-License-Identifier: MIT
//
// The strip of pictures from which the user chooses the first view of a scene.
#include <algorithm>
#include <cstdint>

#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {

void draw_view_choice(const Viewer& viewer, const PanelState& state, Actions& actions) {
  if (!viewer.scene || viewer.view_choice.pictures == nullptr || state.candidates == 0) return;
  const Image& strip = *viewer.view_choice.pictures;
  const std::size_t count = viewer.scene->candidates.size();
  const auto columns = static_cast<float>(count);
  const Rect picture = current_layout(viewer).picture;
  const ImGuiStyle& style = ImGui::GetStyle();
  const float border = 2 * drawing_scale();
  // The pictures share the width, and none is enlarged.
  const float margins = 2 * style.WindowPadding.x + (columns - 1) * style.ItemSpacing.x;
  const float room = (picture.size().x - 28 * drawing_scale() - margins) / columns - 2 * border;
  const float words = ImGui::GetFontSize() + style.ItemSpacing.y + 2 * style.WindowPadding.y;
  const float width = std::clamp(room, 16.0f, 240 * drawing_scale());
  const float height = width * columns * static_cast<float>(strip.height) /
                       static_cast<float>(std::max(strip.width, 1));
  const float low = picture.high.y - 14 * drawing_scale();
  ImGui::SetNextWindowPos({picture.center().x, low}, ImGuiCond_Always, {0.5f, 1});
  // A window without a size is not shown in its first drawing, which may be the only one.
  ImGui::SetNextWindowSize({margins + columns * (width + 2 * border), words + height + 2 * border});
  ImGui::Begin(
      "First view", nullptr,
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing);
  ImGui::TextUnformatted("Choose the first view of this scene");
  ImGui::SameLine();
  ImGui::TextColored(palette::kFaint, "Esc keeps this one");
  const auto texture = reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(state.candidates));
  for (std::size_t i = 0; i < count; ++i) {
    const float left = static_cast<float>(i) / columns;
    ImGui::PushID(static_cast<int>(i));
    if (i > 0) ImGui::SameLine();
    if (ImGui::ImageButton(texture, {width, height}, {left, 0}, {left + 1 / columns, 1},
                           static_cast<int>(border)))
      actions.push_back(call(action::choose_first_view, i));
    ImGui::PopID();
  }
  if (pressed(ImGuiKey_Escape)) actions.push_back(call(action::close_view_choice));
  ImGui::End();
}

}  // namespace qs
