// SPDX-License-Identifier: MIT
//
// The arrow to the scene's subject in a view that shows next to nothing.
#include "app/viewer/state/lost.h"

#include <algorithm>

#include <glm/common.hpp>
#include <imgui.h>

#include "app/viewer/panels/panels.h"
#include "app/viewer/panels/style.h"

namespace qs {
namespace {

// An arrow whose tip is at `tip`.
void draw_arrow(ImDrawList& draw, glm::vec2 tip, glm::vec2 direction, float size) {
  const glm::vec2 aside(-direction.y, direction.x);
  const auto at = [&](float back, float side) {
    const glm::vec2 place = tip - back * size * direction + side * size * aside;
    return ImVec2(place.x, place.y);
  };
  const ImVec2 outline[] = {at(0, 0),        at(1, 0.8f),  at(1, 0.3f), at(2.2f, 0.3f),
                            at(2.2f, -0.3f), at(1, -0.3f), at(1, -0.8f)};
  const float by = drawing_scale();
  draw.AddTriangleFilled(outline[0], outline[1], outline[6], color_of(kSkyBlue));
  draw.AddQuadFilled(at(0.9f, 0.3f), outline[3], outline[4], at(0.9f, -0.3f), color_of(kSkyBlue));
  draw.AddPolyline(outline, 7, IM_COL32(0, 0, 0, 200), ImDrawFlags_Closed, 1.5f * by);
}

}  // namespace

void draw_lost(const Viewer& viewer) {
  const auto way = way_to_subject(viewer);
  const Rect picture = current_layout(viewer).picture;
  if (!way || picture.empty()) return;
  const float letter = ImGui::GetFontSize();
  const glm::vec2 per_pixel = picture.size() / glm::vec2(viewer.camera.width, viewer.camera.height);
  const glm::vec2 tip = picture.low + (glm::vec2(way->tip) + 0.5f) * per_pixel;
  const glm::vec2 direction(way->direction);
  const float size = 1.4f * letter;  // of the arrow's head
  draw_arrow(*ImGui::GetBackgroundDrawList(), tip, direction, size);
  // The words are behind the arrow, inside of the picture.
  const ImVec2 text = ImGui::CalcTextSize(kWayBack);
  const glm::vec2 plate = glm::vec2(text.x, text.y) + glm::vec2(16, 8) * drawing_scale();
  const glm::vec2 tail = tip - (2.2f * size + 0.7f * letter) * direction;
  const glm::vec2 center = tail - 0.5f * plate * direction;
  const glm::vec2 most = glm::max(picture.high - plate, picture.low);
  const glm::vec2 low = glm::clamp(center - 0.5f * plate, picture.low, most);
  draw_plate(kWayBack, low.x, low.y, 0);
}

}  // namespace qs
