// SPDX-License-Identifier: MIT
//
// The facts of a scene that `quadsplat info` prints, as text and as JSON.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "app/framing/scene_box.h"
#include "io/scene/reader.h"

namespace qs {

struct Range {
  double low = 0, high = 0;
};

struct SceneReport {
  SceneBox all, core;        ///< boxes of the centres; core: 5th to 95th percentile of each axis
  Range opacity;             ///< 0..1
  Range scale;               ///< standard deviations, world units
  std::size_t huge;          ///< count_huge()
  std::string cameras = {};  ///< one line on the cameras beside the scene; empty: there are none
};

SceneReport make_report(const GaussianCloud& cloud);

std::string report_text(const Scene& scene, const SceneReport& report);
nlohmann::ordered_json report_json(const Scene& scene, const SceneReport& report);

}  // namespace qs
