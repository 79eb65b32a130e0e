// SPDX-License-Identifier: MIT
//
// Frame times as the published script of QuadBox measures them: one mode after the other draws some
// views to warm up, and then every test view once. The script's frames per second are 1000 / the
// mean time, and for a set of scenes the arithmetic mean of the scenes' values.
#pragma once

#include <span>
#include <vector>

#include "app/session/session.h"
#include "base/progress.h"

namespace qs {

inline constexpr int kPaperWarmupViews = 5;

/// By mode and view: the time of the view's frame in ms, the mean over `rounds` runs. The warm-up
/// draws the first views, and begins again with the first if there are fewer than
/// kPaperWarmupViews.
std::vector<std::vector<double>> paper_times(Session& session, const std::vector<CullMode>& modes,
                                             std::span<const Camera> views, int rounds,
                                             const Progress& progress);

}  // namespace qs
