// SPDX-License-Identifier: MIT
//
// The kernels that composite long lists:
//   count_segments    finds the samples of the lists
//   cut_segments      finds the pairs of the segments, and the sizes of the waves
//   order_segments    orders the segments by waves
//   blend_segments    composites the segments as if nothing were in front of them
//   finish_segments   composites the pixels again that stop in a segment
//   join_segments     joins the segments of a list, front to back
#include "raster/cuda/fast/segments.cuh"
#include "raster/cuda/fast/stages.cuh"
#include "raster/cuda/fast/walk.cuh"

namespace qs::cuda::fast {
namespace {

constexpr unsigned kSegmentBlocks = 1024;  // share the segments of long lists
constexpr unsigned kCountBlocks =
    8;  // per multiprocessor, share the segments when they are counted
constexpr unsigned kJoinBlocks = 256;                 // share the long lists
constexpr float kStopped = 0.1f * kTransmittanceMin;  // transmittance of an opaque segment

/// Calls visit(index, segment, list) for all reserved segments. Warps take them in turns.
template <class Visit>
__device__ void for_each_segment(const SegmentsView& view, const ListInput& in,
                                 const Visit& visit) {
  const std::uint32_t count = min(view.counters->segments, view.capacity);
  const std::uint32_t warps = gridDim.x * (kThreads / kWarp);
  for (std::uint32_t index = (blockIdx.x * kThreads + threadIdx.x) / kWarp; index < count;
       index += warps) {
    Segment& segment = view.segments[index];
    if (segment.tile == Segment::kNoTile) continue;
    LongList list(view, in.ranges[segment.tile], index - segment.number);
    visit(index, segment, list);
  }
}

__global__ void __launch_bounds__(kThreads) count_segments(SegmentsView view, ListInput in) {
  for_each_segment(view, in, [&](std::uint32_t, const Segment& segment, LongList& list) {
    list.count(in, segment.tile, segment.number);
  });
}

/// Turns the sizes of the waves into their first turns. All threads of one block call it together.
__device__ void begin_waves(const WavesView& waves, FastCounters* counters) {
  static_assert(kThreads == kMaxSegments);
  const std::uint32_t size = load_fresh(&waves.sizes[threadIdx.x]);
  const BlockSum<std::uint32_t> sizes = sum_of_block<kThreads>(size);
  waves.sizes[threadIdx.x] = sizes.before;
  if (threadIdx.x == 0) counters->cut_segments = sizes.total;
}

__global__ void __launch_bounds__(kThreads) cut_segments(SegmentsView view, ListInput in) {
  for_each_segment(view, in, [&](std::uint32_t, Segment& segment, LongList& list) {
    list.cut();
    if (segment.number >= list.segments()) return;
    const std::uint32_t begin = list.begin(segment.number), end = list.end(segment.number);
    if (lane_index() != 0) return;
    segment.begin = begin;
    segment.end = end;
    segment.count = list.segments();
    segment.slot = atomicAdd(&view.waves.sizes[segment.number], 1u);
  });
  if (is_last_block(&view.counters->cut_blocks_done)) begin_waves(view.waves, view.counters);
}

/// Launched with a thread per segment.
__global__ void __launch_bounds__(kThreads) order_segments(SegmentsView view) {
  const std::uint32_t count = min(view.counters->segments, view.capacity);
  const std::uint32_t stride = gridDim.x * kThreads;
  for (std::uint32_t i = blockIdx.x * kThreads + threadIdx.x; i < count; i += stride) {
    const Segment& segment = view.segments[i];
    if (segment.count == 0) continue;
    view.waves.order[view.waves.sizes[segment.number] + segment.slot] = i;
  }
}

/// One half of a segment, which a warp takes in its turn.
struct HalfSegment {
  Segment* segment;
  SegmentResult* result;
  std::uint32_t number, begin, end;
  unsigned half_index;

  __device__ HalfSegment(const SegmentsView& view, std::uint32_t turn)
      : half_index(turn % kHalfTiles) {
    const std::uint32_t index = view.waves.order[turn / kHalfTiles];
    segment = view.segments + index;
    result = view.results + index;
    number = segment->number;
    begin = segment->begin;
    end = segment->end;
  }

  __device__ HalfTile half(const ListInput& in) const {
    return {segment->tile, half_index, in.columns};
  }
};

/// The next turn of the calling warp.
__device__ std::uint32_t next_turn(std::uint32_t* turns) {
  std::uint32_t turn = 0;
  if (lane_index() == 0) turn = atomicAdd(turns, 1u);
  return __shfl_sync(kAllLanes, turn, 0);
}

/// The transmittances in front of a segment for the pixels of a lane. All lanes of a warp call its
/// functions together.
struct Front {
  /// The product over the segments with numbers below front_end.
  float front[kPixels] = {1, 1, 1, 1};
  std::uint32_t front_end = 0;
  /// The product over all finished segments: no less than the true transmittance.
  float before[kPixels];

  /// Begins with the segment in front that has finished and knows most.
  __device__ void begin(const HalfSegment& own, const HalfTile& half) {
    const std::uint32_t distance = lane_index() + 1;
    const Segment* const other = own.segment - distance;
    const bool is_finished =
        distance <= own.number && load_fresh(&other->finished[own.half_index]) != 0;
    const std::uint32_t known =
        is_finished ? load_fresh(&other->front_end[own.half_index]) * kWarp + distance : 0;
    const std::uint32_t most = largest_of_warp(known);
    if (most == 0) return;
    const SegmentResult& result = *(own.result - ((most - 1) % kWarp + 1));
    front_end = (most - 1) / kWarp;
#pragma unroll
    for (int j = 0; j < kPixels; ++j) front[j] = load_fresh(&result.front[half.place(j)]);
  }

  /// Multiplies the results of the finished segments that are not in the product yet.
  __device__ void advance(const HalfSegment& own, const HalfTile& half) {
    constexpr std::uint32_t kBatch = 8;  // results that a lane reads at the same time
#pragma unroll
    for (int j = 0; j < kPixels; ++j) before[j] = front[j];
    bool all_finished = true;
    for (std::uint32_t first = front_end; first < own.number; first += kWarp) {
      const unsigned finished = finished_from(own, first);
      for (std::uint32_t batch = 0; batch < kWarp && finished >> batch != 0; batch += kBatch) {
#pragma unroll
        for (std::uint32_t s = batch; s < batch + kBatch; ++s) {
          const bool is_finished = (finished >> s & 1) != 0;
          const SegmentResult* const result = own.result - own.number + first + s;
          all_finished = all_finished && is_finished;
          if (all_finished) ++front_end;
#pragma unroll
          for (int j = 0; j < kPixels; ++j) {
            const float* const value = &result->transmittance[half.place(j)];
            const float transmittance = is_finished ? load_fresh(value) : 1.0f;
            before[j] *= transmittance;
            if (all_finished) front[j] *= transmittance;
          }
        }
      }
      all_finished = all_finished && finished == kAllLanes;
    }
  }

  /// True if a pixel of the warp may not have stopped.
  __device__ bool any_live() const {
    bool any = false;
    for (const float pixel : before) any = any || pixel >= kTransmittanceMin;
    return __any_sync(kAllLanes, any);
  }

 private:
  /// A mask of the finished segments among numbers `first` to `first` + 31, as far as they are in
  /// front. Their results may be read afterwards.
  static __device__ unsigned finished_from(const HalfSegment& own, std::uint32_t first) {
    const std::uint32_t number = first + lane_index();
    const Segment* const segment = own.segment - own.number + number;
    const bool is_finished =
        number < own.number && load_fresh(&segment->finished[own.half_index]) != 0;
    return __ballot_sync(kAllLanes, is_finished);
  }
};

/// Warps composite halves of segments, wave by wave. The pixels that have stopped in front are left
/// out; their result is that they have stopped.
template <Rows kRows>
__global__ void __launch_bounds__(kBlendThreads, kBlendBlocks)
    blend_segments(SegmentsView view, ListInput in) {
  __shared__ Rings<false> rings[kHalfTiles];
  const std::uint32_t turns = kHalfTiles * view.counters->cut_segments;
  for (;;) {
    const std::uint32_t turn = next_turn(&view.counters->turns[0]);
    if (turn >= turns) return;
    const HalfSegment own(view, turn);
    const HalfTile half = own.half(in);
    const glm::vec3 start = own.number == 0 ? in.background : glm::vec3(0.0f);
    Column<Cut::flush> column;
    bool any;
    {
      Front front;
      front.begin(own, half);
      front.advance(own, half);
      any = front.any_live();
#pragma unroll
      for (int j = 0; j < kPixels; ++j) {
        own.result->front[half.place(j)] = front.front[j];
        const bool exists = half.x < in.width && half.y + j < in.height;
        const bool is_live = exists && front.before[j] >= kTransmittanceMin;
        column.pixels[j] = {is_live ? kClear<Cut::flush> : 0.0f, start.x, start.y, start.z};
      }
      if (lane_index() == 0) own.segment->front_end[own.half_index] = front.front_end;
    }
    if (any) {
      Marks unused{};
      Walk<false, kRows>(in, half, rings[threadIdx.x / kWarp], column, unused)
          .composite(own.begin, own.end);
    }
#pragma unroll
    for (int j = 0; j < kPixels; ++j) {
      const ColumnPixel<Cut::flush>& pixel = column.pixels[j];
      const unsigned place = half.place(j);
      own.result->red[place] = pixel.red;
      own.result->green[place] = pixel.green;
      own.result->blue[place] = pixel.blue;
      own.result->transmittance[place] =
          pixel.is_live() ? pixel.transmittance * kAlphaScale<Cut::flush> : kStopped;
    }
    __syncwarp();
    if (lane_index() == 0) publish(&own.segment->finished[own.half_index]);
  }
}

/// Sets the pixels that stop in a segment to their transmittance in front of it, and the other
/// pixels to 0. Requires all segments to be finished.
__device__ void find_stopping(const HalfSegment& own, const HalfTile& half,
                              WalkedPixel (&pixels)[kPixels]) {
  Front front;
  front.front_end = own.segment->front_end[own.half_index];
#pragma unroll
  for (int j = 0; j < kPixels; ++j) front.front[j] = own.result->front[half.place(j)];
  front.advance(own, half);
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const float before = front.before[j];
    const float behind = before * own.result->transmittance[half.place(j)];
    const bool stops = before >= kTransmittanceMin && behind < kTransmittanceMin;
    pixels[j] = {stops ? before : 0.0f, 0, 0, 0};
  }
}

/// Composites many pixels of half a tile at the same time.
template <Rows kRows>
__device__ void composite_many(const ListInput& in, const HalfTile& half, Rings<false>& rings,
                               std::uint32_t begin, std::uint32_t end,
                               WalkedPixel (&pixels)[kPixels]) {
  Column<Cut::flush> column;
#pragma unroll
  for (int j = 0; j < kPixels; ++j)
    column.pixels[j] = {pixels[j].transmittance * kClear<Cut::flush>, 0, 0, 0};
  Marks unused{};
  Walk<false, kRows>(in, half, rings, column, unused).composite(begin, end);
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const ColumnPixel<Cut::flush>& pixel = column.pixels[j];
    pixels[j] = {0, pixel.red, pixel.green, pixel.blue};
  }
}

/// Warps composite the halves of segments again for the pixels that stop there. The first segment
/// of a list is exact already.
template <Rows kRows>
__global__ void __launch_bounds__(kBlendThreads, kBlendBlocks)
    finish_segments(SegmentsView view, ListInput in) {
  __shared__ Rings<false> rings[kHalfTiles];
  const std::uint32_t turns = kHalfTiles * view.counters->cut_segments;
  for (;;) {
    const std::uint32_t turn = next_turn(&view.counters->turns[1]);
    if (turn >= turns) return;
    const HalfSegment own(view, turn);
    if (own.number == 0) continue;
    const HalfTile half = own.half(in);
    WalkedPixel pixels[kPixels];
    find_stopping(own, half, pixels);
    PixelWalk walk(in, half, pixels);
    const unsigned stopping = walk.count();
    if (stopping == 0) continue;
    bool stops[kPixels];
#pragma unroll
    for (int j = 0; j < kPixels; ++j) stops[j] = pixels[j].transmittance > 0.0f;
    if (stopping <= kFewPixels)
      walk.composite(own.begin, own.end);
    else
      composite_many<kRows>(in, half, rings[threadIdx.x / kWarp], own.begin, own.end, pixels);
    SegmentResult& result = *own.result;
#pragma unroll
    for (int j = 0; j < kPixels; ++j) {
      if (!stops[j]) continue;
      const unsigned place = half.place(j);
      result.red[place] = pixels[j].red;
      result.green[place] = pixels[j].green;
      result.blue[place] = pixels[j].blue;
      result.transmittance[place] = 0.0f;
    }
    __syncwarp();
  }
}

/// Each block joins the segments of long lists, one list after the other, a thread per pixel.
__global__ void __launch_bounds__(kTileSize* kTileSize)
    join_segments(SegmentsView view, ListInput in, BlendOutput out) {
  const std::uint32_t lists = min(view.counters->long_lists, view.capacity);
  for (std::uint32_t list = blockIdx.x; list < lists; list += gridDim.x) {
    const std::uint32_t index = view.first_segments[list];
    if (index >= view.capacity) continue;
    const std::uint32_t tile = view.segments[index].tile, segments = view.segments[index].count;
    if (tile == Segment::kNoTile) continue;
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

}  // namespace

void count_long_lists(const FrameContext& frame, const Scratch& scratch) {
  const Blocks blocks(kCountBlocks * scratch.multiprocessors);
  const ListInput in = scratch.lists(frame);
  launch("blend", count_segments, blocks, frame.stream, scratch.segments, in);
  launch("blend", cut_segments, blocks, frame.stream, scratch.segments, in);
  launch("blend", order_segments, kJoinBlocks, frame.stream, scratch.segments);
}

void blend_long_lists(const FrameContext& frame, const Scratch& scratch, const Outputs& outputs,
                      Pixels& pixels) {
  const ListInput in = scratch.lists(frame);
  const bool is_thin = has_thin_rows(frame.settings);
  const Blocks blocks(kSegmentBlocks, kBlendThreads);
  launch("blend", is_thin ? blend_segments<Rows::exponents> : blend_segments<Rows::products>,
         blocks, frame.stream, scratch.segments, in);
  launch("blend", is_thin ? finish_segments<Rows::exponents> : finish_segments<Rows::products>,
         blocks, frame.stream, scratch.segments, in);
  launch("blend", join_segments, Blocks(kJoinBlocks, kTileSize * kTileSize), frame.stream,
         scratch.segments, in, BlendOutput::of(pixels, outputs));
}

}  // namespace qs::cuda::fast
