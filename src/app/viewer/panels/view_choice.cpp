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
  Rect area;                ///< of its window
  glm::vec2 picture{0.0f};  ///< size of a picture
  float frame = 0;          ///< around a picture
};

// The pictures share the width, and none is enlarged. Beside wide bars they cover a bar too.
Strip strip_of(const Viewer& viewer) {
  const Image& pictures = *viewer.view_choice.pictures;
  const auto columns = static_cast<float>(viewer.scene->candidates.size());
  const Rect picture = current_layout(viewer).picture;
  const ImGuiStyle& style = ImGui::GetStyle();
  const float by = drawing_scale(), window = ImGui::GetIO().DisplaySize.x;
  const float whole = std::max(picture.size().x, std::min(30 * ImGui::GetFontSize(), window));
  const float margins = 2 * style.WindowPadding.x + (columns - 1) * style.ItemSpacing.x;
  Strip strip;
  strip.frame = 2 * by;
  const float room = (whole - 28 * by - margins) / columns - 2 * strip.frame;
  strip.picture.x = std::clamp(room, 16.0f, 240 * by);
  strip.picture.y = strip.picture.x * columns * static_cast<float>(pictures.height) /
                    static_cast<float>(std::max(pictures.width, 1));
  const float words = ImGui::GetFontSize() + style.ItemSpacing.y + 2 * style.WindowPadding.y;
  const glm::vec2 size(margins + columns * (strip.picture.x + 2 * strip.frame),
                       words + strip.picture.y + 2 * strip.frame);
  const float center = std::clamp(picture.center().x, 0.5f * whole, window - 0.5f * whole);
  strip.area.low = {center - 0.5f * size.x, picture.high.y - 14 * by - size.y};
  strip.area.high = strip.area.low + size;
  return strip;
}

bool is_open(const Viewer& viewer) {
  return viewer.panels.all && viewer.scene && viewer.view_choice.pictures != nullptr;
}

}  // namespace

Rect view_choice_area(const Viewer& viewer) {
  return is_open(viewer) ? strip_of(viewer).area : Rect();
}

void draw_view_choice(const Viewer& viewer, const PanelState& state, Actions& actions) {
  if (!is_open(viewer) || state.candidates == 0) return;
  const Strip strip = strip_of(viewer);
  const std::size_t count = viewer.scene->candidates.size();
  ImGui::SetNextWindowPos({strip.area.low.x, strip.area.low.y});
  // A window without a size is not shown in its first drawing, which may be the only one.
  ImGui::SetNextWindowSize({strip.area.size().x, strip.area.size().y});
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

}  // namespace qs
