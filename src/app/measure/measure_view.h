// SPDX-License-Identifier: MIT
//
// Measures all modes on one view the way every benchmark does: interleaved, with warm-up, images
// left where they are drawn, then stage times in a marked pass.
#pragma once

#include <vector>

#include "app/measure/bench_row.h"
#include "app/measure/measure.h"
#include "app/session/session.h"

namespace qs {

struct ViewPlan {
  int frames = 100, warmup = 20, rounds = 1;  ///< per mode; rounds repeat frames and warm-up
};

/// Where a benchmark's images go: nowhere but the backend's own memory.
Target bench_target(Backend backend);

/// One row per mode, in the modes' order; scene, camera and view are left to the caller.
std::vector<BenchRow> measure_view(Session& session, const std::vector<CullMode>& modes,
                                   const Camera& camera, const ViewPlan& plan,
                                   const Progress& progress);

}  // namespace qs
