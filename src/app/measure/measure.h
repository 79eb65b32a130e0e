// SPDX-License-Identifier: MIT
//
// Measures culling modes on one view: modes are interleaved (A B C A B C ...) so that a drifting
// clock or a busy machine hits all of them alike.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "raster/renderer.h"

namespace qs {

struct ModeResult {
  CullMode mode = kDefaultMode;
  RenderStats stats;             ///< of the frame with the median time
  std::vector<double> frame_ms;  ///< of every measured frame, in order
  float marked_frame_ms = 0;     ///< median of mark_stages()' frames, 0 without
  std::optional<double> psnr;    ///< dB against mode `reference`
};

struct MeasurePlan {
  std::span<const CullMode> modes;
  int warmup = 1, frames = 3;  ///< rounds over all modes; frames > 0
  Target target = HostImage{};
  Progress progress;
};

/// Renders the rounds; the last one's frames go to visit(mode, frame). Results are parallel to the
/// modes. Throws Cancelled when plan.progress.stop is triggered.
std::vector<ModeResult> measure_modes(Renderer& renderer, const Camera& camera,
                                      RenderSettings settings, const Outputs& outputs,
                                      const MeasurePlan& plan,
                                      const std::function<void(CullMode, const Frame&)>& visit);

/// Takes `result`'s stage times (medians) from frames of their own, because measuring stages may
/// slow a frame.
void mark_stages(Renderer& renderer, const Camera& camera, RenderSettings settings,
                 ModeResult& result, int frames = 1, const Target& target = HostImage{},
                 std::stop_token stop = {});

/// The table that people read: one line per mode, and what the mode is.
std::string format_mode_table(std::span<const ModeResult> results);

/// Pairs per visible Gaussian; 0 when nothing is visible.
double pairs_per_visible(const RenderStats& stats);

}  // namespace qs
