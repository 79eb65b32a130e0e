// SPDX-License-Identifier: MIT
//
// A frame with a heat map of any quantity, also of one that takes two frames to know.
#pragma once

#include <optional>

#include "app/inspect/missed.h"

namespace qs {

struct MappedFrame {
  const Frame& frame;  ///< with color; the renderer's, valid until its next frame
  Heatmap heatmap;
  std::optional<MissedMap> missed;  ///< of HeatQuantity::missed
};

/// What kJudgeMode lists of a view: missed_contributions() judges other frames of it by this one.
Frame judging_frame(Renderer& renderer, const Camera& camera, RenderSettings settings,
                    std::stop_token stop = {});

/// Throws Error and Cancelled.
MappedFrame draw_mapped(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
                        HeatQuantity quantity, ThreadPool& pool, std::stop_token stop = {});

}  // namespace qs
