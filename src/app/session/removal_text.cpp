// SPDX-License-Identifier: MIT
#include "app/session/removal_text.h"

#include <vector>

#include "base/fail.h"
#include "base/text.h"

namespace qs {

CropBox parse_crop_box(std::string_view what, std::string_view text, const glm::dvec3& origin) {
  constexpr double kMost = 1e9;
  const std::vector<std::string> words = separated(text);
  if (words.size() != 6) fail(ErrorKind::usage, "{}: '{}' is not X0,Y0,Z0,X1,Y1,Z1", what, text);
  CropBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    box.low[axis] = static_cast<float>(parse_real(what, words[at], -kMost, kMost) - origin[axis]);
    box.high[axis] =
        static_cast<float>(parse_real(what, words[at + 3], -kMost, kMost) - origin[axis]);
    if (box.low[axis] > box.high[axis])
      fail(ErrorKind::usage, "{}: '{}' begins at {} {} and ends before it at {}", what, text,
           "xyz"[axis], words[at], words[at + 3]);
  }
  return box;
}

std::string format_crop_box(const CropBox& box, const glm::dvec3& origin) {
  if (origin != glm::dvec3(0)) {
    const glm::dvec3 low = origin + glm::dvec3(box.low), high = origin + glm::dvec3(box.high);
    return fmt::format("{:.10g},{:.10g},{:.10g},{:.10g},{:.10g},{:.10g}", low.x, low.y, low.z,
                       high.x, high.y, high.z);
  }
  return fmt::format("{},{},{},{},{},{}", box.low.x, box.low.y, box.low.z, box.high.x, box.high.y,
                     box.high.z);
}

std::string removal_text(const RemovalCounts& removal, std::string_view verb) {
  constexpr const char* kReasons[kRemovedReasons] = {"",          "outside of the box", "too faint",
                                                     "too large", "isolated",           "selected"};
  std::vector<std::string> reasons;
  for (std::size_t i = 1; i < kRemovedReasons; ++i)
    if (removal.counts[i] > 0)
      reasons.push_back(fmt::format("{} {}", grouped(removal.counts[i]), kReasons[i]));
  std::string text = fmt::format("{} of {} {}", grouped(removal.going()),
                                 counted(removal.all(), "Gaussian"), verb);
  return reasons.empty() ? text : text + ": " + joined(reasons, ", ");
}

}  // namespace qs
