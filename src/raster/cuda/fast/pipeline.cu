// SPDX-License-Identifier: MIT
#include <algorithm>

#include "raster/cuda/collect.cuh"
#include "raster/cuda/fast/append.cuh"
#include "raster/cuda/fast/bin.cuh"
#include "raster/cuda/fast/macro_tiles.cuh"
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

static_assert(MacroTileCapacity::kMostMacroTiles <= StagedEntry::kMacroTiles);

std::uint32_t MacroTileCapacity::most_for(const FrameSize& size) const {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;
  if (size.macro_tiles() > kMostMacroTiles) return 0;
  const std::uint64_t affordable = kMostBytes / (size.macro_tiles() * MacroTiles::kBytesEach);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(most_, affordable));
}

std::uint32_t MacroTileCapacity::next(const Counters& counters, const FrameSize& size) {
  if (!size.uses_macro_tiles()) {
    // The longest list of a tile is known, not how many Gaussians its macro-tile would have.
    if (longest_list_ == 0) longest_list_ = counters.max_pairs_in_a_tile;
    const bool is_nearer = counters.max_pairs_in_a_tile <= longest_list_ / 2;
    return is_nearer ? kFirst : 0;
  }
  longest_list_ = 0;
  constexpr std::uint32_t kStep = 1024;
  const std::uint32_t fullest = counters.fullest_macro_tile, most = most_for(size);
  if (fullest > most) return 0;
  const std::uint32_t roomy = (fullest + fullest / 8 + kStep) / kStep * kStep;
  return std::min(roomy, most);
}

FastPipeline::FastPipeline(int device)
    : side_stream_(device, false),
      full_stream_(device, true),
      macro_capacity_(most_per_macro_tile()) {
  size_.pair_capacity = 1 << 16;
  size_.segment_capacity = 1 << 5;
  size_.macro_capacity = MacroTileCapacity::kFirst;
}

void FastPipeline::draw(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                        StageClock& clock) {
  frame.throw_if_cancelled();
  pixels.reserve(frame.camera, outputs);
  FrameSize size = size_;
  size.gaussians = frame.cloud.count;
  size.grid = frame.grid;
  size.macro_capacity = std::min(size.macro_capacity, macro_capacity_.most_for(size));
  for (;;) {
    if (!scratch_.can_hold_macro_tiles(size)) size.macro_capacity = 0;
    reserve(size);
    pixels.reserve_used(outputs, size.pair_capacity);
    size_ = size;
    if (outputs.stage_times) {
      clock.begin(true, frame.stream);
      run(frame, size, outputs, pixels, clock, frame.stream);
    } else {
      const int sort_passes =
          size.uses_macro_tiles() ? -int{size.has_full_macro_tiles()} : depth_passes(frame);
      const Graph::Topology topology{sort_passes,          size.uses_16_bit_keys(),
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
    const bool pairs_fit = counters_->tile_pairs <= size.pair_capacity;
    const bool segments_fit =
        !cuts_long_lists(outputs) || counters_->segments <= size.segment_capacity;
    const bool macro_tiles_fit =
        !size.uses_macro_tiles() || counters_->fullest_macro_tile <= size.macro_capacity;
    size_.macro_capacity = size.macro_capacity = macro_capacity_.next(*counters_, size);
    if (pairs_fit && segments_fit && macro_tiles_fit) return;
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
  project(frame, size, visible_, scratch_);
  projected_.record(frame.stream);
  projected_.make_wait(side_stream);
  if (needs_color(outputs)) color(frame, visible_, side_stream);
  colored_.record(side_stream);
  mark(Stage::preprocess);
  if (size.uses_macro_tiles()) {
    const bool forks = size.has_full_macro_tiles() && side_stream != frame.stream;
    if (forks) projected_.make_wait(full_stream_);
    list_by_macro_tile(frame, size, scratch_, pairs_, forks ? full_stream_ : frame.stream);
    if (forks) {
      listed_.record(full_stream_);
      listed_.make_wait(frame.stream);
    }
  } else {
    sort_by_depth(frame, size, visible_, scratch_, order_);
    mark(Stage::sort);
    bin(frame, size, visible_, order_, scratch_, pairs_);
    mark(Stage::bin);
    sort_by_tile(frame, size, pairs_, scratch_);
    schedule(frame, scratch_);
  }
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
  order_.reserve(size);
  pairs_.reserve(size);
  scratch_.reserve(size);
}

void FastPipeline::collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
                           Frame& result) {
  result.stats.visible = counters_->visible;
  result.stats.tile_pairs = counters_->tile_pairs;
  result.stats.max_pairs_in_a_tile = counters_->max_pairs_in_a_tile;
  collect_lists(
      frame, outputs, pixels, [&] { return list_ranges(frame); }, pairs_.gaussians,
      [&](Trace& trace) { append_gaussians(frame, trace); }, result);
}

std::vector<ListRange> FastPipeline::list_ranges(const FrameContext& frame) const {
  const auto tiles = static_cast<std::size_t>(frame.grid.count());
  std::vector<ListRange> ranges;
  for (const KeyRange& range : copied(scratch_.ranges, tiles, frame.stream)) {
    ranges.push_back({range.begin(), range.end});
  }
  return ranges;
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
