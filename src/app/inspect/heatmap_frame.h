// SPDX-License-Identifier: MIT
//
// Frames with a heat map of any quantity. HeatQuantity::missed compares two frames; all other
// quantities need one frame.
#pragma once

#include <optional>

#include "app/inspect/missed_contributions.h"

namespace qs {

struct FrameHeatmap {
  Heatmap heatmap;
  std::optional<MissedMap> missed;  ///< set for HeatQuantity::missed
};

/// Makes heat maps for frames of one view.
class HeatmapMaker {
 public:
  /// Renders a frame in kBaselineMode if `quantity` needs it. The pool must outlive this object.
  /// Throws Error and Cancelled.
  HeatmapMaker(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
               HeatQuantity quantity, ThreadPool& pool, std::stop_token stop = {});

  /// The outputs that frames given to map() must have.
  Outputs outputs() const;
  FrameHeatmap map(const Frame& frame) const;

 private:
  HeatQuantity quantity_;
  glm::ivec2 size_;
  glm::vec3 background_;
  ThreadPool& pool_;
  std::stop_token stop_;
  std::optional<Frame> baseline_;
};

/// The mode whose map gives heat maps of commands their scale.
inline const CullMode kScaleMode = find_culler("3dgs");

/// The mode whose map gives all modes of a view their scale: `baseline`; for missed contributions
/// the first mode that drops them by its boxes, because a lossless baseline misses none.
CullMode scale_mode(HeatQuantity quantity, CullMode baseline);

/// The scale of a quantity in a view, from a frame in scale_mode(quantity, settings.mode). Throws
/// Error and Cancelled.
Scale scale_of_view(Renderer& renderer, const Camera& camera, RenderSettings settings,
                    HeatQuantity quantity, ThreadPool& pool, std::stop_token stop = {});

struct HeatmapFrame : FrameHeatmap {
  const Frame& frame;  ///< has color; owned by the renderer, valid until its next frame
};

/// Renders a view and its heat map. Throws Error and Cancelled.
HeatmapFrame render_with_heatmap(Renderer& renderer, const Camera& camera,
                                 const RenderSettings& settings, HeatQuantity quantity,
                                 ThreadPool& pool, std::stop_token stop = {});

}  // namespace qs
