// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/collect.cuh"
#include "raster/cuda/fast/bin.cuh"
#include "raster/cuda/fast/pipeline.cuh"
#include "raster/cuda/fast/schedule.cuh"

namespace qs::cuda::fast {
namespace {

/// True if the output of the `color` kernel is used.
bool needs_color(const Outputs& outputs) { return outputs.blends() || outputs.trace; }

constexpr std::uint64_t kBytesPerPair =
    2 * (sizeof(std::uint32_t) + sizeof(std::uint32_t));  // upper bound

/// The capacity with which a frame that exceeded the buffers is redrawn.
std::uint32_t larger_capacity(std::uint64_t tile_pairs) {
  require_indexable(tile_pairs, kMaxPairs);
  return with_headroom(tile_pairs, kMaxPairs, 0,
                       [](std::uint64_t pairs) { return pairs * kBytesPerPair; });
}

/// The capacity with which a frame of too many segments is redrawn.
std::uint32_t with_half(std::uint32_t segments) { return segments + segments / 2; }

}  // namespace

void FastPipeline::draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                        StageClock& clock) {
  frame.throw_if_cancelled();
  pixels.reserve(frame.camera, outputs);
  for (FrameSize size{frame.cloud.count, pair_capacity_, segment_capacity_, frame.grid};;) {
    reserve(size);
    pixels.reserve_used(outputs, size.pair_capacity);
    pair_capacity_ = size.pair_capacity;
    segment_capacity_ = size.segment_capacity;
    if (outputs.stage_times) {
      clock.begin(true, frame.stream);
      run(frame, size, outputs, pixels, clock, frame.stream);
    } else {
      const Graph::Topology topology{depth_passes(frame),  size.uses_16_bit_keys(),
                                     outputs.blends(),     outputs.used,
                                     needs_color(outputs), cuts_long_lists(outputs)};
      graph_.capture(frame.stream, topology,
                     [&] { run(frame, size, outputs, pixels, clock, side_stream_); });
      clock.begin(false, frame.stream);
      graph_.launch(frame.stream);
    }
    clock.finish(frame.stream);
    frame.enqueue_present();
    copy_to_host(scratch_.counters, &*counters_, 1, frame.stream);
    const bool pairs_fit = counters_->tile_pairs <= pair_capacity_;
    const bool segments_fit = !cuts_long_lists(outputs) || counters_->segments <= segment_capacity_;
    if (pairs_fit && segments_fit) return;
    if (!pairs_fit) size.pair_capacity = larger_capacity(counters_->tile_pairs);
    if (!segments_fit) size.segment_capacity = with_half(counters_->segments);
    frame.throw_if_cancelled();
  }
}

void FastPipeline::run(const FrameContext& frame, const FrameSize& size, const Outputs& outputs,
                       Pixels& pixels, StageClock& clock, cudaStream_t side_stream) {
  const auto mark = [&](Stage stage) {
    if (side_stream == frame.stream) clock.end(stage, frame.stream);
  };
  project(frame, visible_, scratch_.begin_frame(size));
  projected_.record(frame.stream);
  projected_.make_wait(side_stream);
  if (needs_color(outputs)) color(frame, visible_, side_stream);
  colored_.record(side_stream);
  mark(Stage::preprocess);
  sort_by_depth(frame, size, visible_, scratch_, order_);
  mark(Stage::sort);
  bin(frame, size, visible_, order_, scratch_, pairs_);
  mark(Stage::bin);
  sort_by_tile(frame, size, pairs_, scratch_);
  schedule(frame, scratch_);
  mark(Stage::sort);
  colored_.make_wait(frame.stream);
  if (outputs.blends()) {
    pixels.clear_used(outputs, size.pair_capacity, frame.stream);
    if (cuts_long_lists(outputs)) count_long_lists(frame, visible_, pairs_, scratch_);
    scheduled_.record(frame.stream);
    scheduled_.make_wait(side_stream);
    if (cuts_long_lists(outputs)) {
      blend_long_lists(frame, visible_, pairs_, scratch_, outputs, pixels);
    }
    blend(frame, visible_, pairs_, scratch_, outputs, pixels, side_stream);
    blended_.record(side_stream);
    blended_.make_wait(frame.stream);
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
  collect_lists(
      frame, outputs, pixels, [&] { return list_lengths(frame); }, pairs_.gaussians,
      [&](Trace& trace) { append_gaussians(frame, trace); }, result);
}

std::vector<std::uint32_t> FastPipeline::list_lengths(const FrameContext& frame) const {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  std::vector<std::uint32_t> lengths;
  for (const KeyRange& range : copied(scratch_.ranges, tiles, frame.stream)) {
    lengths.push_back(range.size());
  }
  return lengths;
}

void FastPipeline::append_gaussians(const FrameContext& frame, Trace& trace) const {
  const auto keys = copied(visible_.depth_keys.data(), frame.cloud.count, frame.stream);
  const auto splats = copied(visible_.splats.data(), frame.cloud.count, frame.stream);
  const auto footprints = copied(visible_.footprints.data(), frame.cloud.count, frame.stream);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == kInvisibleKey) continue;
    append_visible(trace, i, footprints[i].footprint(), depth_of_key(keys[i], frame.camera),
                   splats[i].splat());
  }
}

}  // namespace qs::cuda::fast
