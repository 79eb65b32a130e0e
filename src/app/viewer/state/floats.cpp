// SPDX-License-Identifier: MIT
#include "app/viewer/state/floats.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <glm/common.hpp>

namespace qs {
namespace {

struct FloatRow {
  glm::vec2 anchor;        ///< of the thing and of the picture: 0 left or top, 1 right or bottom
  float way;               ///< in which it leaves an occupied place: -1 up, 1 down, 0 none
  bool is_pinned = false;  ///< more important things leave its usual place free if they can
};

// Index = FloatKind.
constexpr FloatRow kFloatRows[] = {
    {{0.5f, 1}, -1},       // choice
    {{1, 1}, -1},          // message
    {{0.5f, 1}, -1},       // progress
    {{0.5f, 1}, -1},       // legend
    {{0.5f, 0}, 1},        // plate
    {{0, 0}, 1},           // badge
    {{0, 0}, 1},           // photograph
    {{1, 0}, 1, true},     // left_name
    {{0, 0}, 1, true},     // right_name
    {{0.5f, 0}, 1, true},  // name
    {{0, 0}, 0, true},     // cell
    {{0, 0}, 0, true},     // caption
    {{0.5f, 0.5f}, 1},     // way
    {{0.5f, 1}, -1},       // hints
};

const FloatRow& float_row(FloatKind kind) { return kFloatRows[static_cast<int>(kind)]; }

bool are_close(const Rect& a, const Rect& b, float gap) {
  gap -= 0.01f;  // rounding
  return a.low.x < b.high.x + gap && b.low.x < a.high.x + gap && a.low.y < b.high.y + gap &&
         b.low.y < a.high.y + gap;
}

// The nearest free place in one direction; empty if there is none.
Rect free_place(const Rect& area, Rect rect, float way, float gap, std::span<const Rect> taken) {
  for (;;) {
    if (rect.low.y < area.low.y || rect.high.y > area.high.y) return {};
    const auto blocks =
        std::ranges::find_if(taken, [&](const Rect& other) { return are_close(rect, other, gap); });
    if (blocks == taken.end()) return rect;
    if (way == 0) return {};
    const float height = rect.size().y;
    rect.low.y = way < 0 ? blocks->low.y - gap - height : blocks->high.y + gap;
    rect.high.y = rect.low.y + height;
  }
}

Rect place_of(const Rect& picture, float gap, const Floating& thing, glm::vec2 size,
              std::span<const Rect> taken) {
  const FloatRow& row = float_row(thing.kind);
  const float margin = row.way == 0 ? 0 : gap;
  const Rect area{picture.low + margin, picture.high - margin};
  if (size.x <= 0 || size.x > area.size().x || size.y > area.size().y) return {};
  const glm::vec2 wish = thing.at.value_or(area.low + row.anchor * area.size());
  const glm::vec2 low = glm::clamp(wish - row.anchor * size, area.low, area.high - size);
  const Rect first{low, low + size};
  const Rect found = free_place(area, first, row.way, gap, taken);
  return found.empty() ? free_place(area, first, -row.way, gap, taken) : found;
}

}  // namespace

std::vector<Rect> floats_of(const Rect& picture, float gap, std::span<const Floating> shown) {
  std::vector<Rect> places(shown.size());
  std::vector<std::size_t> order(shown.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return shown[i].kind; });
  std::vector<Rect> taken;
  for (const std::size_t i : order) {
    const Floating& thing = shown[i];
    if (thing.kind == FloatKind::cell) continue;
    // Legend and badge never cover the pictures of all modes, nor their captions.
    const auto excludes = [&](FloatKind kind) {
      return (thing.kind == FloatKind::legend || thing.kind == FloatKind::badge) &&
             (kind == FloatKind::cell || kind == FloatKind::caption);
    };
    std::vector<Rect> avoided = taken, excluded = taken;
    for (const Floating& other : shown) {
      if (other.kind <= thing.kind || !float_row(other.kind).is_pinned) continue;
      const Rect usual = place_of(picture, gap, other, other.size, {});
      if (usual.empty()) continue;
      avoided.push_back(usual);
      if (excludes(other.kind)) excluded.push_back(usual);
    }
    for (const auto& [list, size] :
         {std::pair(&avoided, thing.size), std::pair(&avoided, thing.smaller),
          std::pair(&excluded, thing.smaller), std::pair(&excluded, thing.size)}) {
      if (places[i].empty()) places[i] = place_of(picture, gap, thing, size, *list);
    }
    if (!places[i].empty()) taken.push_back(places[i]);
  }
  return places;
}

}  // namespace qs
