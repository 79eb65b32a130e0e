// SPDX-License-Identifier: MIT
//
// The strip of pictures from which the user chooses the first view of a scene.
#include <algorithm>
#include <cstdint>

#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

struct Strip {
  glm::vec2 size{0.0f};     ///< of its window
  glm::vec2 picture{0.0f};  ///< size of a picture
  float frame = 0;          ///< around a picture
};

// The pictures share the width, and none is enlarged.
Strip strip_of(const Viewer& viewer, float room) {
  const Image& pictures = *viewer.view_choice.pictures;
  const auto columns = static_cast<float>(viewer.scene->candidates.size());
  const ImGuiStyle& style = ImGui::GetStyle();
  const float by = drawing_scale();
  const float margins = 2 * style.WindowPadding.x + (columns - 1) * style.ItemSpacing.x;
  Strip strip;
  strip.frame = 2 * by;
  strip.picture.x = std::clamp((room - margins) / columns - 2 * strip.frame, 16.0f, 240 * by);
  strip.picture.y = strip.picture.x * columns * static_cast<float>(pictures.height) /
                    static_cast<float>(std::max(pictures.width, 1));
  const float words = ImGui::GetFontSize() + style.ItemSpacing.y + 2 * style.WindowPadding.y;
  strip.size = {margins + columns * (strip.picture.x + 2 * strip.frame),
                words + strip.picture.y + 2 * strip.frame};
  return strip;
}

void draw_strip(const Viewer& viewer, const PanelState& state, const Strip& strip,
                const Rect& place, Actions& actions) {
  const std::size_t count = viewer.scene->candidates.size();
  ImGui::SetNextWindowPos({place.low.x, place.low.y});
  ImGui::SetNextWindowSize({place.size().x, place.size().y});
  ImGui::PushStyleColor(ImGuiCol_Border, palette::kAccent);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 0.5f * strip.frame);
  ImGui::Begin("First view", nullptr, kBareWindow);
  ImGui::TextUnformatted("Choose the first view of this scene");
  ImGui::SameLine();
  ImGui::TextColored(palette::kFaint, "Esc keeps this one");
  for (std::size_t i = 0; i < count; ++i) {
    const float left = static_cast<float>(i) / static_cast<float>(count);
    const float right = static_cast<float>(i + 1) / static_cast<float>(count);
    ImGui::PushID(static_cast<int>(i));
    if (i > 0) ImGui::SameLine();
    if (ImGui::ImageButton(texture_id(state.candidates), {strip.picture.x, strip.picture.y},
                           {left, 0}, {right, 1}, static_cast<int>(strip.frame)))
      actions.push_back(call(action::choose_first_view, i));
    ImGui::PopID();
  }
  ImGui::End();
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
}

}  // namespace

void draw_view_choice(const Viewer& viewer, const PanelState& state, Floats& floats,
                      Actions& actions) {
  if (!viewer.scene || viewer.view_choice.pictures == nullptr || state.candidates == 0) return;
  const Strip strip = strip_of(viewer, floats.room());
  floats.add({FloatKind::choice, strip.size},
             [&, strip](const Rect& place) { draw_strip(viewer, state, strip, place, actions); });
}

}  // namespace qs
