// SPDX-License-Identifier: MIT
#include "raster/cuda/classic/classic.cuh"
#include "raster/cuda/common/depth.cuh"
#include "raster/cuda/common/pixels.cuh"

namespace qs::cuda::classic {
namespace {

__global__ void empty() {}

}  // namespace

void ClassicPipeline::draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                           StageClock& clock) {
  const auto timed = [&](Stage stage, const auto& work) {
    frame.throw_if_cancelled();
    work();
    clock.end(stage, frame.stream);
  };
  // If processes take turns on a GPU, the first kernel of a turn starts 0.14 ms late (H200). This
  // empty kernel absorbs the delay before the frame is timed.
  launch("frame", empty, blocks_for(1), frame.stream);
  clock.begin(outputs.stage_times, frame.stream);
  timed(Stage::preprocess, [&] { preprocess(frame, visible_); });
  timed(Stage::bin, [&] { bin(frame, visible_, pairs_); });
  timed(Stage::sort, [&] { sort(frame, pairs_); });
  timed(Stage::blend, [&] { blend(frame, visible_, pairs_, outputs, pixels); });
  clock.finish(frame.stream);
  frame.enqueue_behind();
}

void ClassicPipeline::collect(const FrameContext& frame, const Outputs& outputs,
                              const Pixels& pixels, Frame& result) {
  copy_to_host(visible_.counters.data(), &*counters_, 1, frame.stream);
  result.stats.visible = counters_->visible;
  result.stats.tile_pairs = result.stats.listed = pairs_.count;
  constexpr std::uint64_t kSortedEach = sizeof(std::uint64_t) + sizeof(std::uint32_t);
  result.stats.sort_bytes = pairs_.count * kSortedEach;
  result.stats.max_pairs_in_a_tile = counters_->max_pairs_in_a_tile;
  collect_lists(
      frame, outputs, pixels, pairs_.ranges.data(), pairs_.buffers.values.data(),
      [&](Trace& trace) { append_gaussians(frame, trace); }, result);
}

BlendInput<LogSplat> ClassicPipeline::lists(const FrameContext& frame) const {
  return BlendInput<LogSplat>::of(frame, pairs_.ranges.data(), pairs_.buffers.values.data(),
                                  visible_.splats.data());
}

void ClassicPipeline::draw_depth(const FrameContext& frame, Pixels& pixels) const {
  cuda::draw_depth(frame, lists(frame), visible_.depths.data(), pixels);
}

void ClassicPipeline::append_gaussians(const FrameContext& frame, Trace& trace) const {
  const std::size_t size = frame.cloud.count;
  const auto on_host = [&](const auto& buffer) {
    return copied(buffer.data(), size, frame.stream);
  };
  const auto tiles = on_host(visible_.tile_counts);
  const auto depths = on_host(visible_.depths);
  auto means = on_host(visible_.footprints.means), conics = on_host(visible_.footprints.conics);
  auto levels = on_host(visible_.footprints.levels);
  const auto splats = on_host(visible_.splats);
  const FootprintArrays footprints{means.data(), conics.data(), levels.data()};
  for (std::size_t i = 0; i < size; ++i)
    if (tiles[i] > 0) append_visible(trace, i, footprints.load(i), depths[i], splats[i].splat());
}

}  // namespace qs::cuda::classic
