// SPDX-License-Identifier: MIT
//
// Measures modes on one view as every benchmark does: interleaved, after a warm-up, without copying
// images to the host. Stage times come from extra frames.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "app/measure/bench_row.h"
#include "app/measure/measure.h"
#include "app/session/session.h"
#include "base/progress.h"
#include "raster/api/renderer.h"

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

/// One row per mode, in the order of `modes`, and one per guest. The caller sets scene, camera and
/// view of the rows.
std::vector<BenchRow> measure_view(Session& session, const std::vector<CullMode>& modes,
                                   const Camera& camera, const ViewPlan& plan,
                                   const Progress& progress);

/// Frame times as the published script of QuadBox measures them: one mode after the other draws
/// some views to warm up, and then every test view once. The script's frames per second are 1000 /
/// the mean time, and for a set of scenes the arithmetic mean of the scenes' values. By mode and
/// view: the time of the view's frame in ms, the mean over `rounds` runs. The warm-up draws the
/// first five views, and begins again with the first if there are fewer.
std::vector<std::vector<double>> paper_times(Session& session, const std::vector<CullMode>& modes,
                                             std::span<const Camera> views, int rounds,
                                             const Progress& progress);

/// Renders the view twice and sets the columns of `row` that compare the images: with `truth`, the
/// fp64 reference, and with each other. Throws what the renderer throws.
void judge_quality(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                   const Image& truth, ThreadPool& pool, BenchRow& row);

}  // namespace qs
