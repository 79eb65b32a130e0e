// SPDX-License-Identifier: MIT
//
// Pipeline `classic` of the CPU backend: the stages in plain C++. Tests compare cpu/fast/ with it,
// and frames that ask for Outputs::used or other tile sizes run on it.
#pragma once

#include <algorithm>
#include <span>

#include "raster/cpu/common/tile_lists.h"
#include "raster/kernel/blend.h"
#include "raster/scene/activated_cloud.h"

namespace qs::cpu {

struct BoundedSplat {
  Splat splat;
  PixelBound bound;
};

/// True if one of `count` pixels side by side can have alpha >= 1/255. (dx, dy) is the first pixel
/// minus the mean.
inline bool touches(const BoundedSplat& bounded, float dx, float dy, int count) {
  const glm::vec3& conic = bounded.splat.log2_conic;
  const float x = std::clamp(bounded.bound.slope * dy, dx, dx + static_cast<float>(count - 1));
  const float xx = conic.x * x * x, yy = conic.z * dy * dy;
  const float rounding = -kFalloffRounding * (xx + yy);
  return xx + yy + conic.y * x * dy + rounding >= bounded.bound.threshold;
}

struct Visible : VisibleSlots {
  Array<BoundedSplat> splats;  ///< per slot
};

/// Stage 1: projects, culls by the frame's mode and evaluates colours. A Gaussian without tiles is
/// not visible.
void preprocess(const FrameContext& frame, const ActivatedCloud& active, Visible& visible);

/// Stage 4: composites every tile's list front to back. Fills color and evaluated of `result` if
/// requested. They already have their sizes.
void blend(const FrameContext& frame, const Visible& visible, const TileLists& lists,
           const Outputs& outputs, Frame& result);

class Classic {
 public:
  /// Activates `cloud` unless that was done. Call it before the other functions.
  void activate_once(const GaussianCloud& cloud, ThreadPool& pool);

  /// Activates Gaussians of `cloud` again.
  void update(const GaussianCloud& cloud, std::span<const std::uint32_t> changed);

  /// Fills `result`, whose maps already have their sizes, except for depth and the frame's time.
  void draw(const FrameContext& frame, const Outputs& outputs, Frame& result);

  /// Makes the tile lists of a frame that pipeline fast drew; both pipelines have the same lists.
  void list(const FrameContext& frame);

  /// Composites the lists of a frame again, after draw() or list(). Fills used, per tile the pairs
  /// that at least one pixel blends, and used_pairs.
  void count_used(const FrameContext& frame, Frame& result) const;

  /// Adds the counts of every mode for a view to `sums`; needs no frame of it.
  void count_modes(const FrameContext& counted, ModeSums& sums) const;

 private:
  ActivatedCloud active_;
  Visible visible_;
  DepthOrder order_;
  TileLists lists_;
};

}  // namespace qs::cpu
