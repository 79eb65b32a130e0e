// SPDX-License-Identifier: MIT
#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <utility>

#include "raster/cuda/common/depth.cuh"
#include "raster/cuda/common/limits.cuh"
#include "raster/cuda/common/pixels.cuh"
#include "raster/cuda/fast/append.cuh"
#include "raster/cuda/fast/pipeline.cuh"
#include "raster/cuda/fast/segments.cuh"

namespace qs::cuda::fast {
namespace {

/// True if the output of the `color` kernel is used.
bool needs_color(const Outputs& outputs) {
  return outputs.blends() || outputs.trace || outputs.depth || outputs.seen || outputs.share;
}

/// Writes the depths of visible Gaussians by their place, as lists have it.
__global__ void __launch_bounds__(kBlockGaussians)
    store_depths(const FastCounters* counters, FastVisible visible, std::uint32_t count,
                 std::uint32_t nearest, float* depths) {
  if (blockIdx.x >= counters->visible_blocks) return;
  const std::uint32_t place = visible.blocks[blockIdx.x] * kBlockGaussians + threadIdx.x;
  if (place >= count || visible.depth_keys[place] == kInvisibleKey) return;
  depths[place] = std::bit_cast<float>(visible.depth_keys[place] + nearest);
}

/// The capacity with which a frame that exceeded the buffers is redrawn.
std::uint32_t larger_capacity(std::uint64_t tile_pairs) {
  require_indexable(tile_pairs);
  return with_headroom(tile_pairs, kMaxPairs, 0,
                       [](std::uint64_t pairs) { return pairs * sizeof(std::uint32_t); });
}

std::uint32_t with_half(std::uint32_t count) { return count + count / 2; }

/// For tests: QUADSPLAT_SLABS=N draws every frame that may leave out Gaussians in N slabs.
unsigned forced_slabs() {
  const char* forced = std::getenv("QUADSPLAT_SLABS");
  unsigned slabs = 0;
  if (forced == nullptr || std::sscanf(forced, "%u", &slabs) != 1) return 0;
  return std::min(slabs, OcclusionView::kMostSlabs);
}

/// True if a frame with these outputs may leave out hidden Gaussians. Lists, counts of pairs,
/// depths, selections and times of stages include all Gaussians.
bool allows_occlusion(const Outputs& outputs) {
  return cuts_long_lists(outputs) && !outputs.pairs && !outputs.depth && !outputs.trace &&
         !outputs.seen && !outputs.share && !outputs.stage_times;
}

/// For scripts/far: QUADSPLAT_CUT=LEAST,EACH sets CutRule, in pairs.
void force_cut_rule(SegmentsView& segments) {
  const char* forced = std::getenv("QUADSPLAT_CUT");
  unsigned least = 0, each = 0;
  if (forced == nullptr || std::sscanf(forced, "%u,%u", &least, &each) != 2) return;
  segments.least = std::max(least / kSampled, 1u);
  segments.each = std::max(each / kSampled, 1u);
}

}  // namespace

bool MacroSizePolicy::fits(const FastCounters& counters, const MacroSize& size) {
  if (size.has_slices())
    return counters.spilled <= size.spilled && counters.slices <= size.slices &&
           counters.fullest_slice <= size.slice_capacity;
  const std::uint32_t fullest = counters.fullest_macro_tile;
  return fullest < MacroTiles::kUsual || (size.keeps_whole() && fullest <= size.capacity);
}

std::optional<MacroSize> MacroSizePolicy::next(const FastCounters& counters,
                                               const FrameSize& size) const {
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 30;
  constexpr std::uint32_t kStep = 1024;
  const std::uint32_t fullest = counters.fullest_macro_tile;
  if (fullest < MacroTiles::kUsual / 8 * 7) return MacroSize{};
  MacroSize whole;
  whole.capacity = (fullest + fullest / 8 + kStep) / kStep * kStep;
  if (whole.capacity <= std::min(most_, MacroSize::kMostWhole) &&
      whole.capacity * size.macro_tiles() * MacroTiles::kBytesEach <= kMostBytes) {
    return whole;
  }
  return sliced(counters, size.macro);
}

std::optional<MacroSize> MacroSizePolicy::sliced(const FastCounters& counters,
                                                 const MacroSize& before) const {
  const auto log2_distance_of = [](std::uint32_t target) {
    return static_cast<std::uint32_t>(std::bit_width(target / Slicing::kLeastSamples)) - 1;
  };
  const auto samples_of = [&](std::uint32_t target) {
    const std::uint32_t samples = counters.fullest_macro_tile >> log2_distance_of(target);
    return samples + samples / 4 + 64;
  };
  // A macro-tile that was fuller than expected has samples of its first entries only, and these do
  // not represent the other entries. Then its slices overflow, but not because they are too large.
  const bool has_all_samples =
      counters.fullest_macro_tile >> before.log2_distance <= before.sample_capacity;
  MacroSize next = before;
  next.capacity = MacroTiles::kUsual;
  const bool are_usual = samples_of(MacroSize::kUsual / 2) <= most_;
  next.slice_capacity = are_usual ? MacroSize::kUsual : std::min(MacroSize::kMedium, most_);
  if (next.slice_capacity != before.slice_capacity) {
    // Medium slices have fewer samples, so their lengths vary more.
    next.slice_target = are_usual ? next.slice_capacity / 2 : next.slice_capacity / 5 * 2;
  } else if (counters.fullest_slice > before.slice_capacity && has_all_samples) {
    next.slice_target = before.slice_target / 2;
  }
  next.sample_capacity = samples_of(next.slice_target);
  next.sorts_in_global_memory = next.sample_capacity > most_;
  if (next.slice_target < next.slice_capacity / 8) return std::nullopt;
  next.log2_distance = log2_distance_of(next.slice_target);
  const std::uint64_t entries = std::uint64_t{counters.spilled} * Slicing::kParts +
                                std::uint64_t{counters.full_macro_tiles} * MacroTiles::kUsual;
  const std::uint64_t slices = entries / next.slice_target + counters.full_macro_tiles;
  if (slices > next.slices) next.slices = static_cast<std::uint32_t>(slices + slices / 4 + 16);
  if (counters.spilled > next.spilled) next.spilled = with_half(counters.spilled);
  return next;
}

FastPipeline::FastPipeline(int device)
    : side_stream_(device, false),
      full_stream_(device, true),
      scratch_(multiprocessors()),
      macro_size_policy_(most_in_shared_memory()) {
  last_size_.pair_capacity = 1 << 16;
  forced_slabs_ = forced_slabs();
  force_cut_rule(scratch_.segments);
}

/// A slab is worth its passes if it has millions of Gaussians. Fitted on copies of one scene, see
/// docs/log/far.md.
unsigned FastPipeline::slabs_of(std::uint32_t shown_blocks) const {
  constexpr std::uint32_t kLeastBlocks = (1 << 22) / kBlockGaussians;
  if (forced_slabs_ > 0) return forced_slabs_;
  return std::clamp(std::bit_floor(shown_blocks / kLeastBlocks), 1u, OcclusionView::kMostSlabs);
}

bool FastPipeline::can_draw(TileGrid grid) {
  return MacroTiles::count_of(grid) <= MacroTiles::kMost;
}

bool FastPipeline::occludes(const FrameContext& frame, const Outputs& outputs) {
  return frame.settings.occlusion && allows_occlusion(outputs) &&
         frame.camera.projection == Projection::pinhole;
}

void FastPipeline::enqueue(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                           StageClock& clock) {
  frame.throw_if_cancelled();
  pixels.reserve(frame.camera, outputs);
  const auto [found, is_new] = views_.try_emplace(frame.number);
  FrameSize& size = found->second.size;
  if (is_new) size = last_size_;
  size.gaussians = frame.cloud.count;
  size.grid = frame.grid;
  size.width = frame.camera.width;
  size.height = frame.camera.height;
  size.slabs = occludes(frame, outputs) ? slabs_ : 1;
  enqueue_again(frame, outputs, pixels, clock);
}

void FastPipeline::enqueue_again(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                                 StageClock& clock) {
  View& view = views_.at(frame.number);
  const FrameSize& size = view.size;
  scratch_.reserve(size);
  pixels.reserve_used(outputs, size.pair_capacity);
  if (outputs.stage_times) {
    clock.begin(true, frame.stream);
    run(frame, outputs, pixels, clock, frame.stream);
  } else {
    const Graph::Topology topology{size.macro.has_slices(),
                                   size.macro.keeps_whole(),
                                   outputs.blends(),
                                   outputs.used,
                                   needs_color(outputs),
                                   cuts_long_lists(outputs) && size.blends_segments,
                                   has_thin_rows(frame.settings),
                                   static_cast<int>(size.slabs)};
    view.graph.capture(frame.stream, topology,
                       [&] { run(frame, outputs, pixels, clock, side_stream_); });
    clock.begin(false, frame.stream);
    view.graph.launch(frame.stream);
  }
  clock.finish(frame.stream);
  frame.enqueue_behind();
  enqueue_copy_to_host(scratch_.counters, of_slabs_->data(), size.slabs, frame.stream);
}

bool FastPipeline::finish(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                          StageClock& clock) {
  FrameSize& size = views_.at(frame.number).size;
  const bool may_occlude = occludes(frame, outputs);
  for (;;) {
    check(cudaStreamSynchronize(frame.stream), "frame");
    merge_counters(size.slabs);
    const bool pairs_fit = counters_.tile_pairs <= size.pair_capacity;
    const bool macro_tiles_fit = MacroSizePolicy::fits(counters_, size.macro);
    // Lists of macro-tiles that do not fit are not complete.
    const bool segments_fit = !cuts_long_lists(outputs) || !macro_tiles_fit || fit_segments(size);
    const std::optional<MacroSize> macro = macro_size_policy_.next(counters_, size);
    size.macro = macro.value_or(MacroSize{});
    last_size_ = size;
    if (may_occlude) slabs_ = slabs_of(counters_.shown_blocks);
    const bool slabs_fit = !may_occlude || size.slabs == slabs_;
    if (pairs_fit && segments_fit && macro_tiles_fit && slabs_fit) return true;
    if (!macro) return false;
    if (!pairs_fit) size.pair_capacity = larger_capacity(counters_.tile_pairs);
    if (may_occlude) size.slabs = slabs_;
    frame.throw_if_cancelled();
    enqueue_again(frame, outputs, pixels, clock);
  }
}

void FastPipeline::merge_counters(unsigned slabs) {
  counters_ = {};
  pairs_ = 0;
  for (const FastCounters& own : std::span(*of_slabs_).first(slabs)) {
    pairs_ += own.tile_pairs;
    counters_.visible += own.visible;
    counters_.entries += own.entries;
    const auto keep_most = [&](auto FastCounters::*counter) {
      counters_.*counter = std::max(counters_.*counter, own.*counter);
    };
    keep_most(&FastCounters::tile_pairs);
    keep_most(&FastCounters::visible_blocks);
    keep_most(&FastCounters::shown_blocks);
    keep_most(&FastCounters::max_pairs_in_a_tile);
    keep_most(&FastCounters::segments);
    keep_most(&FastCounters::fullest_macro_tile);
    keep_most(&FastCounters::full_macro_tiles);
    keep_most(&FastCounters::spilled);
    keep_most(&FastCounters::slices);
    keep_most(&FastCounters::fullest_slice);
  }
}

bool FastPipeline::fit_segments(FrameSize& size) {
  bool may_be_used = false, are_used = false;
  for (unsigned s = 0; s < size.slabs; ++s) {
    const FastCounters& own = (*of_slabs_)[s];
    const CutRule rule = CutRule::of(scratch_.segments, own);
    const bool may = rule.may_be_used(own.max_pairs_in_a_tile);
    may_be_used = may_be_used || may;
    are_used = are_used || (may && size.finds_samples && own.longest_samples > rule.longest);
  }
  const bool have_room = counters_.segments <= size.segment_capacity;
  const bool fit =
      are_used ? size.blends_segments && have_room : size.finds_samples || !may_be_used;
  if (!have_room) size.segment_capacity = with_half(counters_.segments);
  size.finds_samples = may_be_used;
  size.blends_segments = are_used;
  return fit;
}

void FastPipeline::run(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                       StageClock& clock, cudaStream_t side_stream) {
  if (scratch_.size.slabs == 1)
    return run_slab(frame, outputs, pixels, clock, side_stream, OcclusionView{});
  FastCounters* const counters = scratch_.counters;
  OcclusionView occlusion = scratch_.occlusion;
  for (unsigned s = 0; s < scratch_.size.slabs; ++s) {
    scratch_.counters = scratch_.segments.counters = counters + s;
    occlusion.slab = s;
    run_slab(frame, outputs, pixels, clock, side_stream, occlusion);
  }
  scratch_.counters = scratch_.segments.counters = counters;
}

void FastPipeline::run_slab(const FrameContext& frame, const Outputs& outputs, Pixels& pixels,
                            StageClock& clock, cudaStream_t side_stream,
                            const OcclusionView& occlusion) {
  const FrameSize& size = scratch_.size;
  const auto mark = [&](Stage stage) {
    if (side_stream == frame.stream) clock.end(stage, frame.stream);
  };
  project(frame, scratch_, occlusion, footprints_known_);
  projected_.record(frame.stream);
  footprints_known_.make_wait(side_stream);
  if (needs_color(outputs)) color(frame, scratch_, side_stream);
  colored_.record(side_stream);
  mark(Stage::preprocess);
  const auto list_others = size.macro.has_slices()    ? list_sliced
                           : size.macro.keeps_whole() ? list_whole
                                                      : nullptr;
  const bool forks = list_others != nullptr && side_stream != frame.stream;
  if (forks) projected_.make_wait(full_stream_);
  if (list_others != nullptr) list_others(scratch_, forks ? full_stream_ : frame.stream);
  if (forks) listed_.record(full_stream_);
  list_usual(scratch_, frame.stream);
  if (forks) listed_.make_wait(frame.stream);
  mark(Stage::sort);
  colored_.make_wait(frame.stream);
  if (outputs.blends()) {
    pixels.clear_used(outputs, size.pair_capacity, frame.stream);
    scheduled_.record(frame.stream);
    scheduled_.make_wait(side_stream);
    if (cuts_long_lists(outputs) && size.blends_segments)
      blend_long_lists(frame, scratch_, outputs, pixels, occlusion);
    blend(frame, scratch_, outputs, pixels, occlusion, side_stream);
    blended_.record(side_stream);
    blended_.make_wait(frame.stream);
  }
  mark(Stage::blend);
}

void FastPipeline::collect(const FrameContext& frame, const Outputs& outputs, const Pixels& pixels,
                           Frame& result) {
  RenderStats& stats = result.stats;
  stats.listed = pairs_;
  stats.is_occluded = scratch_.size.slabs > 1;
  if (!stats.is_occluded) {
    stats.visible = counters_.visible;
    stats.tile_pairs = pairs_;
    stats.max_pairs_in_a_tile = counters_.max_pairs_in_a_tile;
  }
  stats.sort_bytes = std::uint64_t{counters_.entries} * sizeof(SortEntry);
  collect_lists(
      frame, outputs, pixels, scratch_.ranges, scratch_.gaussians,
      [&](Trace& trace) { append_gaussians(frame, trace); }, result);
  if (!outputs.trace) return;
  const auto file_indices =
      copied(frame.cloud.file_indices.data(), frame.cloud.count, frame.stream);
  for (std::uint32_t& listed : result.trace.listed) listed = file_indices[listed];
}

void FastPipeline::draw_depth(const FrameContext& frame, Pixels& pixels) {
  const std::uint32_t count = frame.cloud.count;
  depths_.reserve("the frame's Gaussians", count);
  launch("depth", store_depths, Blocks(std::max(blocks_for(count), 1u), kBlockGaussians),
         frame.stream, scratch_.counters, scratch_.visible, count, nearest_bits(frame.camera),
         depths_.data());
  cuda::draw_depth(frame, scratch_.lists(frame), depths_.data(), pixels);
}

void FastPipeline::append_gaussians(const FrameContext& frame, Trace& trace) const {
  const std::uint32_t count = frame.cloud.count;
  const auto on_host = [&](const auto* values) { return copied(values, count, frame.stream); };
  const auto keys = on_host(scratch_.visible.depth_keys);
  const auto splats = on_host(scratch_.visible.splats);
  const auto footprints = on_host(scratch_.visible.footprints);
  const auto file_indices = on_host(frame.cloud.file_indices.data());
  std::vector<std::uint32_t> places(count, count);  // by index in the file; `count`: invisible
  for (const std::uint32_t block :
       copied(scratch_.visible.blocks, counters_.visible_blocks, frame.stream)) {
    const std::uint32_t first = block * kBlockGaussians;
    for (std::uint32_t place = first; place < std::min(first + kBlockGaussians, count); ++place)
      if (keys[place] != kInvisibleKey) places[file_indices[place]] = place;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t place = places[i];
    if (place == count) continue;
    append_visible(trace, i, footprints[place].footprint(), depth_of_key(keys[place], frame.camera),
                   splats[place].splat());
  }
}

}  // namespace qs::cuda::fast
