// SPDX-License-Identifier: MIT
//
// The plots of a study, see plot.h.
#pragma once

#include <string>
#include <vector>

#include "app/report/plot.h"
#include "app/report/scene_study.h"

namespace qs {

/// Their names: "uses", "sizes", "loads", and for every quantity "count_KEY" and "saved_KEY".
std::vector<Plot> study_plots(const SceneStudy& study, const std::string& caption);

/// "1.25-1.5", "20+", "<1.25": the label of a bin.
std::string bin_label(const GaussianQuantity& quantity, std::size_t bin);

}  // namespace qs
