// SPDX-License-Identifier: MIT
//
// Writes files of instances.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

#include "io/scene/instances.h"

namespace qs::test {

/// The text of a file of instances, in which all numbers are exact. `scene`: a name in its folder.
inline std::string format_instances(const std::string& scene,
                                    const std::vector<Instance>& instances) {
  std::string text;
  for (const auto& [p, q, scale, tint] : instances)
    text += fmt::format(
        R"({}{{"position": [{}, {}, {}], "rotation": [{}, {}, {}, {}], "scale": {}, "tint": [{}, {}, {}]}})",
        text.empty() ? "" : ",\n  ", p.x, p.y, p.z, q.w, q.x, q.y, q.z, scale, tint.r, tint.g,
        tint.b);
  return fmt::format(R"({{"version": 1, "scene": "{}", "instances": [)"
                     "\n  {}\n]}}\n",
                     scene, text);
}

}  // namespace qs::test
