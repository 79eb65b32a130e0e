// SPDX-License-Identifier: MIT
//
// Measures culling modes on one view, and other renderers beside them. All are interleaved: every
// round has one frame of each, in the order of TurnOrder, so that a drifting clock, a busy machine
// and the frame before affect all of them equally.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "app/measure/turn_order.h"
#include "raster/api/renderer.h"
#include "raster/clock/gpu_clock.h"

namespace qs {

/// A renderer from outside this program. If it throws an Error, it is left out from then on.
struct Guest {
  std::string name;
  Renderer* renderer = nullptr;
};

struct ModeResult {
  CullMode mode = default_mode();  ///< meaningless for a guest
  RenderStats stats;               ///< statistics of the frame with the median time
  std::vector<double> frame_ms;    ///< times of all measured frames, in order
  float marked_frame_ms = 0;       ///< median frame time of mark_stages(), 0 if it did not run
  std::optional<double> psnr;      ///< dB against mode `reference`
  std::string problem;             ///< the Error of a guest, which has no other results then
};

struct MeasurePlan {
  std::span<const CullMode> modes;
  int warmup = 1, frames = 3;  ///< rounds over all modes; frames > 0
  Target target = HostImage{};
  Progress progress;
  GpuClock* clock = nullptr;  ///< takes readings between measured frames
  std::span<const Guest> guests =
      {};  ///< their turns are behind the modes' in `order`; they draw into DeviceImage
  TurnOrder* order = nullptr;  ///< is continued; null: begins with the order of `modes`
};

/// Renders all rounds and calls visit(mode, frame) with the modes' frames of the first round: in
/// the order of `modes`, and before the frames that are measured after a warm-up. Returns one
/// result per mode and guest. Throws Cancelled if plan.progress.stop is triggered.
std::vector<ModeResult> measure_modes(Renderer& renderer, const Camera& camera,
                                      RenderSettings settings, const Outputs& outputs,
                                      const MeasurePlan& plan,
                                      const std::function<void(CullMode, const Frame&)>& visit);

/// The extra frames that measure stages.
struct MarkedPlan {
  int frames = 1;
  Target target = HostImage{};
  std::stop_token stop = {};
};

/// Sets the stage times of `result` to the medians of extra frames in its mode, because measuring
/// stages may slow a frame down.
void mark_stages(Renderer& renderer, const Camera& camera, RenderSettings settings,
                 const MarkedPlan& plan, ModeResult& result);

/// A table with one line per mode: time, FPS, pairs, speed-up and a summary of the mode.
std::string format_mode_table(std::span<const ModeResult> results);

/// Tile pairs per visible Gaussian; 0 if none is visible.
double pairs_per_visible(const RenderStats& stats);

}  // namespace qs
