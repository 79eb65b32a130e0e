// SPDX-License-Identifier: MIT
#include "raster/cuda/fast/blend.cuh"
#include "raster/cuda/fast/segments.cuh"
#include "raster/cuda/schedule.cuh"

namespace qs::cuda::fast {
namespace {

constexpr unsigned kBlendThreads = kHalfTiles * kWarp;
constexpr unsigned kBlendBlocks = 14;                 // per multiprocessor, to hide latency
constexpr unsigned kSegmentBlocks = 1024;             // share the segments of long lists
constexpr unsigned kCountBlocks = 1056;               // share the segments when they are counted
constexpr unsigned kJoinBlocks = 256;                 // share the long lists
constexpr float kStopped = 0.1f * kTransmittanceMin;  // transmittance of an opaque segment

/// Draws lists of `longest` Gaussians at most. kMaps: draws all lists and also fills
/// BlendOutput::evaluated and used, which is slower.
template <bool kMaps, Rows kRows>
__global__ void __launch_bounds__(kBlendThreads, kBlendBlocks)
    blend_tiles(ScheduleView schedule, ListInput in, BlendOutput out, std::uint32_t longest) {
  constexpr Cut kCut = Walk<kMaps, kRows>::kCut;
  __shared__ Rings<kMaps> rings[kHalfTiles];
  const unsigned tile = schedule.tile(blockIdx.x), warp = threadIdx.x / kWarp;
  const HalfTile half(tile, warp, in.columns);
  const ListRange range = in.ranges[tile];
  if (!kMaps && range.size() > longest) return;

  Column<kCut> column;
  Marks marks{{}, out.used};
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const bool exists = half.x < in.width && half.y + j < in.height;
    column.pixels[j] = {exists ? kClear<kCut> : 0.0f, in.background.x, in.background.y,
                        in.background.z};
    marks.evaluated[j] = range.size();
  }
  Walk<kMaps, kRows>(in, half, rings[warp], column, marks).composite(range.begin, range.end);

  if (half.x >= in.width) return;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (half.y + j >= in.height) return;
    const std::size_t at = static_cast<std::size_t>(half.y + j) * in.width + half.x;
    if constexpr (kMaps) {
      if (out.evaluated != nullptr) out.evaluated[at] = marks.evaluated[j];
    }
    if (out.color != nullptr) {
      out.color[3 * at] = column.pixels[j].red;
      out.color[3 * at + 1] = column.pixels[j].green;
      out.color[3 * at + 2] = column.pixels[j].blue;
    }
  }
}

/// Each warp counts parts of long lists, one after the other.
__global__ void __launch_bounds__(kThreads) count_segments(SegmentsView view, ListInput in) {
  const std::uint32_t count = min(view.counters->segments, view.capacity);
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  for (std::uint32_t index = (blockIdx.x * kThreads + threadIdx.x) / kWarp; index < count;
       index += warps) {
    const Segment segment = view.segments[index];
    if (segment.tile == Segment::kNoTile) continue;
    LongList list(view, in.ranges[segment.tile], index - segment.number);
    list.count(in, segment.tile, segment.number);
    if (lane_index() == 0) view.waves.append(segment.number, index);
  }
}

/// A warp's view of the results of its half of the tile, of the segments in front of segment
/// `number` of a list.
struct Front {
  const Segment* segments;  // the list's
  const SegmentResult* results;
  std::uint32_t number;
  unsigned half_index;

  /// A mask of the finished ones among 32 segments from `first` on.
  __device__ unsigned finished(std::uint32_t first) const {
    const std::uint32_t own = first + lane_index();
    const bool is_finished = own < number && load_fresh(&segments[own].finished[half_index]) != 0;
    const unsigned all = __ballot_sync(kAllLanes, is_finished);
    __threadfence();  // their results are read after this
    return all;
  }

  /// Sets `before` to the products of the transmittances of the finished segments: no less than the
  /// true ones. Returns false if all pixels have stopped.
  __device__ bool bound(const HalfTile& half, float (&before)[kPixels]) const {
    constexpr unsigned kBatch = 8;
#pragma unroll
    for (float& pixel : before) pixel = 1;
    for (std::uint32_t first = 0; first < number; first += kWarp) {
      const unsigned all = finished(first);
      for (unsigned batch = 0; batch < kWarp && all >> batch != 0; batch += kBatch) {
#pragma unroll
        for (unsigned k = batch; k < batch + kBatch; ++k) {
#pragma unroll
          for (int j = 0; j < kPixels; ++j) {
            const bool known = (all >> k & 1) != 0;
            const float* const own = &results[first + k].transmittance[half.place(j)];
            before[j] *= known ? load_fresh(own) : 1.0f;
          }
        }
        if (!any_live(before)) return false;
      }
    }
    return true;
  }

  static __device__ bool any_live(const float (&before)[kPixels]) {
    bool any = false;
    for (const float pixel : before) any = any || pixel >= kTransmittanceMin;
    return __any_sync(kAllLanes, any);
  }
};

/// Sets the pixels that stop in segment `index` to their transmittance in front of it, and the
/// other pixels to 0. False if no pixel stops.
__device__ bool find_stopping(const SegmentsView& view, std::uint32_t index, std::uint32_t number,
                              const HalfTile& half, Column<Cut::flush>& column) {
  float before[kPixels] = {1, 1, 1, 1};
  const SegmentResult* const first = view.results + (index - number);
  constexpr std::uint32_t kBatch = 8;
  for (std::uint32_t batch = 0; batch < number; batch += kBatch) {
#pragma unroll
    for (std::uint32_t s = batch; s < batch + kBatch; ++s) {
#pragma unroll
      for (int j = 0; j < kPixels; ++j) {
        before[j] *= s < number ? first[s].transmittance[half.place(j)] : 1.0f;
      }
    }
    if (!Front::any_live(before)) return false;
  }
  bool any = false;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const float behind = before[j] * first[number].transmittance[half.place(j)];
    const bool stops = before[j] >= kTransmittanceMin && behind < kTransmittanceMin;
    column.pixels[j] = {stops ? before[j] * kClear<Cut::flush> : 0.0f, 0, 0, 0};
    any = any || stops;
  }
  return __any_sync(kAllLanes, any);
}

/// Writes the result of compositing a segment, of the pixels `writes`.
template <bool kAgain>
__device__ void store_result(const HalfTile& half, const Column<Cut::flush>& column,
                             const bool (&writes)[kPixels], SegmentResult& result) {
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (!writes[j]) continue;
    const ColumnPixel<Cut::flush>& pixel = column.pixels[j];
    const unsigned place = half.place(j);
    result.red[place] = pixel.red;
    result.green[place] = pixel.green;
    result.blue[place] = pixel.blue;
    const float left =
        pixel.is_live() ? pixel.transmittance * kAlphaScale<Cut::flush> : kStopped;
    result.transmittance[place] = kAgain ? 0.0f : left;
  }
}

/// Each warp composites half tiles of segments, one after the other. kAgain: the second time, see
/// segments.cuh. The first segment of a list is exact the first time.
template <bool kAgain, Rows kRows>
__global__ void __launch_bounds__(kBlendThreads, kBlendBlocks)
    blend_segments(SegmentsView view, ListInput in) {
  __shared__ Rings<false> rings[kHalfTiles];
  __shared__ Waves::Shared shared;
  Waves::prepare<kBlendThreads>(view.waves, shared);
  const Waves waves(view.waves, shared);
  for (;;) {
    std::uint32_t turn = kHalfTiles * waves.segments();
    if (lane_index() == 0 && turn > 0) turn = atomicAdd(&view.counters->turns[kAgain], 1u);
    turn = __shfl_sync(kAllLanes, turn, 0);
    if (turn >= kHalfTiles * waves.segments()) return;
    const std::uint32_t index = waves.segment(turn / kHalfTiles);
    Segment& segment = view.segments[index];
    const std::uint32_t number = segment.number;
    LongList list(view, in.ranges[segment.tile], index - number);
    list.cut();
    if (number >= list.segments()) continue;
    const unsigned half_index = turn % kHalfTiles;
    const HalfTile half(segment.tile, half_index, in.columns);
    SegmentResult& result = view.results[index];
    Column<Cut::flush> column;
    bool writes[kPixels];
    bool composites = true;
    if constexpr (kAgain) {
      composites = number > 0 && find_stopping(view, index, number, half, column);
#pragma unroll
      for (int j = 0; j < kPixels; ++j) {
        writes[j] = composites && column.pixels[j].transmittance > 0.0f;
      }
    } else {
      const Front front{&segment - number, &result - number, number, half_index};
      float before[kPixels];
      composites = front.bound(half, before);
      const glm::vec3 start = number == 0 ? in.background : glm::vec3(0.0f);
#pragma unroll
      for (int j = 0; j < kPixels; ++j) {
        const bool exists = half.x < in.width && half.y + j < in.height;
        const bool is_live = exists && before[j] >= kTransmittanceMin;
        column.pixels[j] = {is_live ? kClear<Cut::flush> : 0.0f, start.x, start.y, start.z};
        writes[j] = true;
      }
    }
    if (composites) {
      Marks unused{};
      Walk<false, kRows>(in, half, rings[threadIdx.x / kWarp], column, unused)
          .composite(list.begin(number), list.end(number));
    }
    if (composites || !kAgain) store_result<kAgain>(half, column, writes, result);
    __threadfence();
    __syncwarp();
    if (!kAgain && lane_index() == 0) segment.finished[half_index] = 1;
  }
}

/// Each block joins the segments of long lists, one list after the other, a thread per pixel.
__global__ void __launch_bounds__(kTileSize* kTileSize)
    join_segments(SegmentsView view, ListInput in, BlendOutput out) {
  const std::uint32_t lists = min(view.counters->long_lists, view.capacity);
  for (std::uint32_t list = blockIdx.x; list < lists; list += gridDim.x) {
    const std::uint32_t index = view.first_segments[list];
    if (index >= view.capacity) continue;
    const std::uint32_t tile = view.segments[index].tile;
    if (tile == Segment::kNoTile) continue;
    LongList cut(view, in.ranges[tile], index);
    cut.cut();
    const std::uint32_t segments = cut.segments();
    const unsigned place = threadIdx.x;
    const SegmentResult* const first = view.results + index;
    glm::vec3 color(first->red[place], first->green[place], first->blue[place]);
    float before = first->transmittance[place];
#pragma unroll 8
    for (std::uint32_t s = 1; s < segments; ++s) {
      const float own = first[s].transmittance[place];
      const glm::vec3 more(first[s].red[place], first[s].green[place], first[s].blue[place]);
      if (!(before >= kTransmittanceMin)) continue;
      const float share = own == 0.0f ? 1.0f : before;
      color = glm::vec3(fmaf(share, more.x, color.x), fmaf(share, more.y, color.y),
                        fmaf(share, more.z, color.z));
      before *= own;
    }
    const int x = static_cast<int>(tile % in.columns * kTileSize + place % kTileSize);
    const int y = static_cast<int>(tile / in.columns * kTileSize + place / kTileSize);
    if (x >= in.width || y >= in.height) continue;
    float* const pixel = out.color + 3 * (static_cast<std::size_t>(y) * in.width + x);
    pixel[0] = color.x;
    pixel[1] = color.y;
    pixel[2] = color.z;
  }
}

ListInput input_of(const FrameContext& frame, const ListedTiles& listed) {
  return ListInput::of(frame, listed.pairs.gaussians, std::as_const(listed.scratch.ranges),
                       listed.visible.splats);
}

template <Rows kRows>
void blend_rows(const FrameContext& frame, const ListedTiles& listed, const Outputs& outputs,
                Pixels& pixels, cudaStream_t stream) {
  const Scratch& scratch = listed.scratch;
  const auto tiles = static_cast<unsigned>(frame.grid.count());
  launch("blend", cuts_long_lists(outputs) ? blend_tiles<false, kRows> : blend_tiles<true, kRows>,
         Blocks(tiles, kBlendThreads), stream,
         ScheduleView{scratch.class_sizes, scratch.schedule, tiles}, input_of(frame, listed),
         BlendOutput::of(pixels, outputs), scratch.segments.longest_uncut);
}

template <Rows kRows>
void blend_segment_rows(const FrameContext& frame, const SegmentsView& segments,
                        const ListInput& in) {
  const Blocks blocks(kSegmentBlocks, kBlendThreads);
  launch("blend", blend_segments<false, kRows>, blocks, frame.stream, segments, in);
  launch("blend", blend_segments<true, kRows>, blocks, frame.stream, segments, in);
}

}  // namespace

void blend(const FrameContext& frame, const ListedTiles& listed, const Outputs& outputs,
           Pixels& pixels, cudaStream_t stream) {
  const auto of_rows =
      has_thin_rows(frame.settings) ? blend_rows<Rows::exponents> : blend_rows<Rows::products>;
  of_rows(frame, listed, outputs, pixels, stream);
}

void count_long_lists(const FrameContext& frame, const ListedTiles& listed) {
  launch("blend", count_segments, Blocks(kCountBlocks, kThreads), frame.stream,
         listed.scratch.segments, input_of(frame, listed));
}

void blend_long_lists(const FrameContext& frame, const ListedTiles& listed, const Outputs& outputs,
                      Pixels& pixels) {
  const SegmentsView segments = listed.scratch.segments;
  const ListInput in = input_of(frame, listed);
  const auto of_rows = has_thin_rows(frame.settings) ? blend_segment_rows<Rows::exponents>
                                                     : blend_segment_rows<Rows::products>;
  of_rows(frame, segments, in);
  launch("blend", join_segments, Blocks(kJoinBlocks, kTileSize * kTileSize), frame.stream, segments,
         in, BlendOutput::of(pixels, outputs));
}

}  // namespace qs::cuda::fast
