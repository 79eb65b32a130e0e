// SPDX-License-Identifier: MIT
#include "app/viewer/state/layout.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/viewer/state/actions.h"

namespace qs {
namespace {

constexpr float kDefaultShare = 0.35f;                     ///< of the window's width
constexpr float kLeastDefault = 27.2f, kMostDefault = 46;  ///< letters' heights
constexpr float kLeastLetters = 14;                        ///< a bar's width
constexpr float kMostShare = 0.4f;                         ///< all bars, of the width
constexpr float kLeftShare = 0.6f;                         ///< of all bars, unless the user sets it

bool any_open(const Panels& panels, std::span<bool Panels::*const> switches) {
  return std::ranges::any_of(switches, [&](bool Panels::*which) { return panels.*which; });
}

// `letters`: the user's setting, 0 if unset.
float bar_width(float letters, float most, const WindowMetrics& window) {
  const float usual = std::clamp(kDefaultShare * window.size.x, kLeastDefault * window.letter,
                                 kMostDefault * window.letter);
  const float least = std::min(kLeastLetters * window.letter, most);
  return std::round(std::clamp(letters > 0 ? letters * window.letter : usual, least, most));
}

constexpr float kUnscaledHeight = 1296;  ///< of the screen: letters grow with higher screens
constexpr float kMostGuessed = 2;

std::ptrdiff_t nearest_scale(float scale) {
  const auto distance = [&](float each) { return std::abs(each - scale); };
  return std::ranges::min_element(kInterfaceScales, {}, distance) - kInterfaceScales;
}

}  // namespace

Layout layout_of(const Viewer& viewer, const WindowMetrics& window) {
  const glm::vec2 size = window.size;
  Layout layout;
  layout.picture = {{0, 0}, size};
  if (!viewer.panels.all || size.y < 4 * window.line) return layout;
  layout.menu = {{0, 0}, {size.x, window.line}};
  layout.picture.low.y = window.line;
  layout.picture.high.y -= window.line;
  layout.status = {{0, layout.picture.high.y}, size};
  if (!viewer.scene) return layout;
  const bool left = any_open(viewer.panels, kLeftPanels);
  const bool right = any_open(viewer.panels, kRightPanels);
  const float most = kMostShare * size.x, least = kLeastLetters * window.letter;
  // In a narrow window one bar has all panels.
  const bool both = left && right && most >= 2 * least;
  const float share = viewer.bars.left > 0 ? 1 : kLeftShare;
  const float most_left = both ? std::min(share * most, most - least) : most;
  layout.left = layout.right = layout.picture;
  layout.left.high.x = left ? bar_width(viewer.bars.left, most_left, window) : 0;
  const float rest = most - layout.left.high.x;
  const bool shows_right = right && (both || !left);
  layout.right.low.x = size.x - (shows_right ? bar_width(viewer.bars.right, rest, window) : 0);
  layout.picture.low.x = layout.left.high.x;
  layout.picture.high.x = layout.right.low.x;
  return layout;
}

float interface_scale(const Viewer& v) {
  return v.interface_scale > 0 ? v.interface_scale : v.screen_scale;
}

float guessed_scale(float declared, glm::ivec2 screen) {
  const float by_size =
      std::clamp(static_cast<float>(screen.y) / kUnscaledHeight, 1.0f, kMostGuessed);
  return kInterfaceScales[nearest_scale(declared > 1 ? declared : by_size)];
}

glm::ivec2 first_window_size(glm::ivec2 screen) {
  return glm::max(screen * 4 / 5, glm::min(screen, glm::ivec2(640, 400)));
}

void action::step_interface_scale(Viewer& v, int step) {
  const std::ptrdiff_t last = std::ssize(kInterfaceScales) - 1;
  const std::ptrdiff_t next = nearest_scale(interface_scale(v)) + step;
  set_interface_scale(v, kInterfaceScales[std::clamp<std::ptrdiff_t>(next, 0, last)]);
}

void action::set_interface_scale(Viewer& v, float scale) {
  v.interface_scale = std::clamp(scale, kInterfaceScales[0], *std::rbegin(kInterfaceScales));
  notify(v, fmt::format("interface at {:.0f} %", 100 * v.interface_scale));
}

}  // namespace qs
