// SPDX-License-Identifier: MIT
#include "app/viewer/panels/floats_drawing.h"

#include <glm/common.hpp>
#include <imgui.h>

#include "app/viewer/panels/style.h"

namespace qs {
namespace {

float gap_of_floats() { return 8 * drawing_scale(); }

}  // namespace

float Floats::room() const { return picture_.size().x - 2 * gap_of_floats(); }

void Floats::add(Floating thing, std::function<void(const Rect& place)> draw) {
  shown_.push_back(thing);
  draw_.push_back(std::move(draw));
}

void Floats::add_plate(FloatKind kind, const std::string& text, std::optional<glm::vec2> at) {
  const float by = drawing_scale();
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  const glm::vec2 plate(size.x + 16 * by, size.y + 8 * by);
  add({kind, glm::min(plate, {room(), plate.y}), {}, at}, [text, by](const Rect& place) {
    ImDrawList& draw = *ImGui::GetBackgroundDrawList();
    const ImVec2 low{place.low.x, place.low.y}, high{place.high.x, place.high.y};
    draw.AddRectFilled(low, high, ImGui::GetColorU32(palette::kPanel), 4 * by);
    draw.PushClipRect(low, {high.x - 4 * by, high.y}, true);
    draw.AddText({low.x + 8 * by, low.y + 4 * by}, ImGui::GetColorU32(palette::kText),
                 text.c_str());
    draw.PopClipRect();
  });
}

bool Floats::draw() const {
  const std::vector<Rect> places = floats_of(picture_, gap_of_floats(), shown_);
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  bool hovers = false;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Rect& place = places[i];
    if (place.empty()) continue;
    draw_[i](place);
    hovers |= shown_[i].kind == FloatKind::message && mouse.x >= place.low.x &&
              mouse.x < place.high.x && mouse.y >= place.low.y && mouse.y < place.high.y;
  }
  return hovers;
}

}  // namespace qs
