// SPDX-License-Identifier: MIT
#include "raster/cuda/classic/classic.cuh"
#include "raster/cuda/stream.cuh"

namespace qs::cuda {

void ClassicPipeline::draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                           StageClock& clock) {
  const auto timed = [&](Stage stage, const auto& work) {
    frame.throw_if_cancelled();
    work();
    clock.end(stage, frame.stream);
  };
  clock.begin(outputs.stage_times, frame.stream);
  timed(Stage::preprocess, [&] { preprocess(frame, visible_); });
  timed(Stage::bin, [&] { bin(frame, visible_, pairs_); });
  timed(Stage::sort, [&] { sort(frame, pairs_, lists_); });
  timed(Stage::blend, [&] { blend(frame, visible_, pairs_, lists_, outputs, pixels); });
  clock.finish(frame.stream);
  frame.sequel();
}

void ClassicPipeline::collect(const FrameContext& frame, const Outputs& outputs,
                              const Pixels& pixels, Frame& result) {
  copy_to_host(visible_.counters.data(), &*counters_, 1, frame.stream);
  result.stats.visible = counters_->visible;
  result.stats.tile_pairs = pairs_.count;
  result.stats.max_pairs_in_a_tile = counters_->max_pairs_in_a_tile;
  if (outputs.pairs) result.pairs = list_lengths(frame);
  if (outputs.used) result.used = pixels.used_per_tile(list_lengths(frame), frame.stream);
  if (outputs.trace) collect_trace(frame, result);
}

void ClassicPipeline::collect_trace(const FrameContext& frame, Frame& result) const {
  Trace& trace = result.trace;
  const std::size_t size = frame.cloud.count;
  const auto on_host = [&](const auto& buffer, std::size_t count) {
    return copied(buffer.data(), count, frame.stream);
  };
  const auto tiles = on_host(visible_.tile_counts, size);
  const auto depths = on_host(visible_.depths, size);
  auto means = on_host(visible_.means, size), conics = on_host(visible_.conics, size);
  auto levels = on_host(visible_.levels, size);
  const auto records = on_host(visible_.records, size);
  const FootprintPlanes footprints{means.data(), conics.data(), levels.data()};
  for (std::size_t i = 0; i < size; ++i) {
    if (tiles[i] == 0) continue;
    trace.gaussians.push_back(static_cast<std::uint32_t>(i));
    trace.footprints.push_back(footprints.load(i));
    trace.depths.push_back(depths[i]);
    trace.splats.push_back(records[i].splat());
  }
  trace.tile_begin.push_back(0);
  for (const std::uint32_t length : list_lengths(frame)) {
    trace.tile_begin.push_back(trace.tile_begin.back() + length);
  }
  trace.listed = on_host(pairs_.buffers.values, pairs_.count);
}

std::vector<std::uint32_t> ClassicPipeline::list_lengths(const FrameContext& frame) const {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  std::vector<std::uint32_t> lengths;
  for (const uint2 range : copied(lists_.ranges.data(), tiles, frame.stream)) {
    lengths.push_back(range.y - range.x);
  }
  return lengths;
}

}  // namespace qs::cuda
