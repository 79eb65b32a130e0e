// SPDX-License-Identifier: MIT
#include "raster/cpu/classic/classic.h"

#include "raster/cpu/classic/mode_pairs.h"
#include "raster/cpu/common/collect.h"
#include "raster/cpu/common/stage_clock.h"

namespace qs::cpu {

void Classic::activate_once(const GaussianCloud& cloud, ThreadPool& pool) {
  if (active_.gaussians.size() != cloud.size()) active_ = activate(cloud, pool);
}

void Classic::draw(const FrameContext& frame, const Outputs& outputs, Frame& result) {
  RenderStats& stats = result.stats;
  timed(Stage::preprocess, stats, [&] { preprocess(frame, active_, visible_); });
  timed(Stage::sort, stats, [&] { sort(frame, visible_, order_); });
  timed(Stage::bin, stats, [&] { bin(frame, visible_, order_, lists_); });
  if (outputs.color || outputs.evaluated) {
    timed(Stage::blend, stats, [&] { blend(frame, visible_, lists_, outputs, result); });
  }
  if (outputs.used) cpu::count_used(frame, visible_, lists_, result);
  const auto splat_of = [&](std::uint32_t slot) { return visible_.splats[slot].splat; };
  collect(visible_, lists_, splat_of, outputs, result);
}

void Classic::list(const FrameContext& frame) {
  preprocess(frame, active_, visible_);
  sort(frame, visible_, order_);
  bin(frame, visible_, order_, lists_);
}

void Classic::count_used(const FrameContext& frame, Frame& result) const {
  cpu::count_used(frame, visible_, lists_, result);
  result.stats.used_pairs = sum_of(result.used);
}

void Classic::draw_depth(const FrameContext& frame, Frame& result) const {
  cpu::draw_depth(frame, visible_, lists_, result);
}

void Classic::count_modes(const FrameContext& counted, ModeSums& sums) const {
  cpu::count_modes(counted, active_, sums);
}

}  // namespace qs::cpu
