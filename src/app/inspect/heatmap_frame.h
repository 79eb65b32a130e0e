// SPDX-License-Identifier: MIT
//
// Frames with a heat map of any quantity. HeatQuantity::missed compares two frames; maps of levels
// are frames of their own; all other quantities need one frame.
// Missed are the contributions (alpha >= 1/255 before the pixel stops) that a mode drops, because
// its lists lack the Gaussian in the pixel's tile. They are found by comparing with a frame of a
// lossless mode, whose lists are complete. Mode `3dgs` drops contributions beyond three standard
// deviations, `dualbox` drops contributions in two quadrants.
#pragma once

#include <optional>
#include <stop_token>
#include <vector>

#include "app/picture/heatmap.h"
#include "base/parallel.h"

namespace qs {

struct MissedMap {
  int width = 0, height = 0;
  std::vector<std::uint32_t> counts;  ///< contributions dropped, for each pixel
  std::vector<float> alphas;          ///< the largest of their alphas, or 0, for each pixel
  std::vector<float> errors;  ///< largest error of a channel because of them, >= 0, for each pixel
  std::uint64_t total = 0;    ///< contributions
  std::uint64_t pixels = 0;   ///< pixels with at least one
  float largest_alpha = 0, largest_error = 0;
};

/// A lossless mode: its lists contain every contribution.
inline const CullMode kBaselineMode = find_culler("adr");

/// Both frames show one view of `size` pixels and were rendered with Outputs::trace, `all` in
/// kBaselineMode. Throws Cancelled.
MissedMap missed_contributions(const Frame& all, const Frame& frame, glm::ivec2 size,
                               glm::vec3 background, ThreadPool& pool, std::stop_token stop = {});

/// The counts as a heat map of HeatQuantity::missed.
Heatmap missed_heatmap(const MissedMap& map);

/// "12 contributions are missed in 3 pixels, alpha up to 0.2, colour off by up to 0.1"
std::string missed_sentence(const MissedMap& map);

struct FrameHeatmap {
  Heatmap heatmap;
  std::optional<MissedMap> missed;  ///< set for HeatQuantity::missed
};

/// Makes heat maps for frames of one view.
class HeatmapMaker {
 public:
  /// Renders a frame in kBaselineMode or of the levels if `quantity` needs it. The pool must
  /// outlive this object. Throws Error and Cancelled.
  HeatmapMaker(Renderer& renderer, const Camera& camera, const RenderSettings& settings,
               HeatQuantity quantity, ThreadPool& pool, std::stop_token stop = {});

  /// The outputs that frames given to map() must have.
  Outputs outputs() const;
  FrameHeatmap map(const Frame& frame) const;

 private:
  HeatQuantity quantity_;
  glm::ivec2 size_;
  glm::vec3 background_;
  bool is_of_faces_;
  ThreadPool& pool_;
  std::stop_token stop_;
  std::optional<Frame> baseline_;
  std::vector<std::uint32_t> levels_;  // by pixel
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
