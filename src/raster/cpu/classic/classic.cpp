// SPDX-License-Identifier: MIT
#include "raster/cpu/classic/classic.h"

#include "raster/cpu/common/frame_context.h"

namespace qs::cpu {

void Classic::activate_once(const GaussianCloud& cloud, ThreadPool& pool) {
  if (active_.gaussians.size() != cloud.size()) active_ = activate(cloud, pool);
}

void Classic::update(const GaussianCloud& cloud, std::span<const std::uint32_t> changed) {
  if (active_.gaussians.empty()) return;
  for (const std::uint32_t i : changed) {
    const Activated activated = activate(cloud, i);
    active_.gaussians[i] = activated.gaussian;
    active_.opacities[i] = activated.opacity;
  }
}

void Classic::draw(const FrameContext& frame, const Outputs& outputs, Frame& result) {
  RenderStats& stats = result.stats;
  timed(Stage::preprocess, stats, [&] { preprocess(frame, active_, visible_); });
  timed(Stage::sort, stats, [&] { sort(frame, visible_, order_); });
  timed(Stage::bin, stats, [&] { bin(frame, visible_, order_, lists_); });
  if (outputs.color || outputs.evaluated)
    timed(Stage::blend, stats, [&] { blend(frame, visible_, lists_, outputs, result); });
  if (outputs.used) count_used(frame, result);
  const auto splat_of = [&](std::uint32_t slot) { return visible_.splats[slot].splat; };
  collect(frame, visible_, lists_, splat_of, outputs, result);
}

void Classic::list(const FrameContext& frame) {
  preprocess(frame, active_, visible_);
  sort(frame, visible_, order_);
  bin(frame, visible_, order_, lists_);
}

}  // namespace qs::cpu
