// SPDX-License-Identifier: MIT
//
// Measures modes on one view as every benchmark does: interleaved, after a warm-up, without copying
// images to the host. Stage times come from extra frames.
#pragma once

#include <cstdint>
#include <vector>

#include "app/measure/bench_row.h"
#include "app/measure/measure.h"
#include "app/session/session.h"

namespace qs {

inline constexpr int kMarkedFrames = 20;  ///< extra frames for stage times, at most

struct ViewPlan {
  int frames = 100, warmup = 20,
      rounds = 1;             ///< numbers per mode; rounds repeat frames and warm-up
  bool details = true;        ///< stage times and false positives, which take extra frames
  GpuClock* clock = nullptr;  ///< takes readings between the timed frames
  std::vector<Guest> guests = {};
  /// Called with the Error of a guest; the guest gets no row.
  std::function<void(const Guest& guest, const std::string& problem)> guest_failed = {};
  /// Of the view's TurnOrder: the number of the view, so that views of few frames differ.
  std::uint64_t first_round = 0;
};

/// Images stay in the backend's own memory.
Target bench_target(Backend backend);

/// One row per mode, in the order of `modes`, and one per guest. The caller sets scene, camera and
/// view of the rows.
std::vector<BenchRow> measure_view(Session& session, const std::vector<CullMode>& modes,
                                   const Camera& camera, const ViewPlan& plan,
                                   const Progress& progress);

}  // namespace qs
