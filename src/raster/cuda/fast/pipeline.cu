// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/fast/bin.cuh"
#include "raster/cuda/fast/pipeline.cuh"
#include "raster/cuda/fast/schedule.cuh"

namespace qs::cuda::fast {
namespace {

/// Whether anybody reads what `color` writes.
bool colors(const Outputs& outputs) { return outputs.blends() || outputs.trace; }

constexpr std::uint64_t kBytesPerPair =
    2 * (sizeof(std::uint32_t) + sizeof(std::uint32_t));  // at most

/// For a frame that turned out to have more pairs than there was room for.
std::uint32_t room_for(const Counters& counters) {
  const std::uint64_t pairs = counters.tile_pairs;
  if (pairs > kMaxPairs) {
    throw Error(ErrorKind::device, "cuda: bin: this view lists " + std::to_string(pairs) +
                                       " tile pairs, at most " + std::to_string(kMaxPairs) +
                                       " can be sorted");
  }
  // Frames differ: a quarter more saves growing again, where there is plenty.
  const std::uint64_t generous = std::min(pairs + pairs / 4, kMaxPairs);
  const bool plenty = generous * kBytesPerPair < DeviceMemory::now().free / 2;
  return static_cast<std::uint32_t>(plenty ? generous : pairs);
}

}  // namespace

void FastPipeline::draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                        StageClock& clock) {
  frame.throw_if_cancelled();
  pixels.reserve(frame.camera, outputs);
  for (FrameSize size{frame.cloud.count, room_, frame.grid};; size.pairs = room_for(*counters_)) {
    reserve(size);
    pixels.reserve_used(outputs, size.pairs);
    room_ = size.pairs;
    if (outputs.stage_times) {
      clock.begin(true, frame.stream);
      run(frame, size, outputs, pixels, clock, frame.stream);
    } else {
      const Graph::Shape shape{depth_passes(frame), size.narrow(), outputs.blends(), outputs.used,
                               colors(outputs)};
      graph_.capture(frame.stream, shape, [&] { run(frame, size, outputs, pixels, clock, side_); });
      clock.begin(false, frame.stream);
      graph_.launch(frame.stream);
    }
    clock.finish(frame.stream);
    frame.sequel();
    copy_to_host(scratch_.counters, &*counters_, 1, frame.stream);
    if (counters_->tile_pairs <= room_) return;
    frame.throw_if_cancelled();
  }
}

void FastPipeline::run(const FrameContext& frame, const FrameSize& size, const Outputs& outputs,
                       Pixels& pixels, StageClock& clock, cudaStream_t side) {
  const auto mark = [&](Stage stage) {
    if (side == frame.stream) clock.end(stage, frame.stream);
  };
  project(frame, visible_, scratch_.begin(size));
  projected_.record(frame.stream);
  projected_.hold(side);
  if (colors(outputs)) color(frame, visible_, side);
  colored_.record(side);
  mark(Stage::preprocess);
  sort_by_depth(frame, size, visible_, scratch_, order_);
  mark(Stage::sort);
  bin(frame, size, visible_, order_, scratch_, pairs_);
  mark(Stage::bin);
  sort_by_tile(frame, size, pairs_, scratch_);
  schedule(frame, scratch_);
  mark(Stage::sort);
  colored_.hold(frame.stream);
  if (outputs.blends()) {
    pixels.clear_used(outputs, size.pairs, frame.stream);
    blend(frame, visible_, pairs_, scratch_, outputs, pixels);
  }
  mark(Stage::blend);
}

void FastPipeline::reserve(const FrameSize& size) {
  visible_.reserve(size.gaussians);
  order_.reserve(size.gaussians);
  pairs_.reserve(size);
  scratch_.reserve(size);
}

void FastPipeline::collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
                           Frame& result) {
  result.stats.visible = counters_->visible;
  result.stats.tile_pairs = counters_->tile_pairs;
  result.stats.max_pairs_in_a_tile = counters_->max_pairs_in_a_tile;
  if (!outputs.pairs && !outputs.used && !outputs.trace) return;
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  std::vector<std::uint32_t> lengths;
  for (const KeyRange& range : copied(scratch_.ranges, tiles, frame.stream)) {
    lengths.push_back(range.size());
  }
  if (outputs.used) result.used = pixels.used_per_tile(lengths, frame.stream);
  if (outputs.trace) collect_trace(frame, lengths, result);
  if (outputs.pairs) result.pairs = std::move(lengths);
}

void FastPipeline::collect_trace(const FrameContext& frame,
                                 const std::vector<std::uint32_t>& lengths, Frame& result) const {
  Trace& trace = result.trace;
  const auto keys = copied(visible_.depth_keys.data(), frame.cloud.count, frame.stream);
  const auto records = copied(visible_.records.data(), frame.cloud.count, frame.stream);
  const auto shapes = copied(visible_.shapes.data(), frame.cloud.count, frame.stream);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == kInvisibleKey) continue;
    trace.gaussians.push_back(static_cast<std::uint32_t>(i));
    trace.footprints.push_back(shapes[i].footprint());
    trace.depths.push_back(depth_of_key(keys[i], frame.camera));
    trace.splats.push_back(records[i].splat());
  }
  trace.tile_begin.push_back(0);
  for (const std::uint32_t length : lengths) {
    trace.tile_begin.push_back(trace.tile_begin.back() + length);
  }
  trace.listed = copied(pairs_.gaussians.data(), trace.tile_begin.back(), frame.stream);
}

}  // namespace qs::cuda::fast
