// SPDX-License-Identifier: MIT
#include "app/viewer/state/interface_scale.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "app/viewer/state/actions.h"

namespace qs {
namespace {

constexpr float kUnscaledHeight = 1296;  ///< of the screen: letters grow with higher screens
constexpr float kMostGuessed = 2;

std::ptrdiff_t nearest_scale(float scale) {
  const auto nearest =
      std::min_element(std::begin(kInterfaceScales), std::end(kInterfaceScales),
                       [&](float a, float b) { return std::abs(a - scale) < std::abs(b - scale); });
  return nearest - std::begin(kInterfaceScales);
}

}  // namespace

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

namespace action {

void step_interface_scale(Viewer& v, int step) {
  const std::ptrdiff_t last = std::ssize(kInterfaceScales) - 1;
  const std::ptrdiff_t next = nearest_scale(interface_scale(v)) + step;
  set_interface_scale(v, kInterfaceScales[std::clamp<std::ptrdiff_t>(next, 0, last)]);
}

void set_interface_scale(Viewer& v, float scale) {
  v.interface_scale = std::clamp(scale, kInterfaceScales[0], *std::rbegin(kInterfaceScales));
  notify(v, fmt::format("interface at {:.0f} %", 100 * v.interface_scale));
}

}  // namespace action
}  // namespace qs
