// SPDX-License-Identifier: MIT
//
// A study as plots, see plot.h.
#pragma once

#include <string>
#include <vector>

#include "app/report/plot.h"
#include "app/report/scene_study.h"

namespace qs {

/// NAME of the plots is the key by which the page finds their pictures: "uses", "sizes", "loads",
/// and for every quantity "many_KEY" and "saved_KEY".
std::vector<Plot> study_plots(const SceneStudy& study, const std::string& caption);

/// "1.25-1.5", "20+", "<0.004": a bin's label.
std::string bin_label(const Quantity& quantity, std::size_t bin);

}  // namespace qs
