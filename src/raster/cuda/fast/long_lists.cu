// SPDX-License-Identifier: MIT
//
// Composites long lists. A warp takes half a segment at a time and composites it as if nothing were
// in front of it, which gives its colour and transmittance. Then it waits until the transmittance
// of all segments in front is known (Merrill and Garland, Single-pass Parallel Prefix Scan with
// Decoupled Look-back, 2016). A pixel stops in the segment in which the product of transmittances
// falls below kTransmittanceMin; there it is composited again, from its true transmittance, so the
// stop rule stays exact. The last warp joins the colours of a list, in groups of segments.
//
// Segments in front are taken first. A warp waits only for segments that running warps have taken,
// so every wait ends. It leaves out the pixels that have stopped in front, as far as
// that is known, and segments behind the last stop.
#include "raster/cuda/fast/segments.cuh"
#include "raster/cuda/fast/stages.cuh"
#include "raster/cuda/fast/walk.cuh"

namespace qs::cuda::fast {
namespace {

constexpr float kStopped = 0.1f * kTransmittanceMin;  // transmittance of an opaque segment
constexpr std::uint32_t kGroup = 16;                  // segments that are joined first

/// One half of a segment, which a warp takes in its turn.
struct HalfSegment {
  Segment* segment;
  SegmentResult* result;
  std::uint32_t number, count;
  unsigned half_index;
  HalfTile half;
  std::uint32_t begin, end;

  __device__ HalfSegment(const SegmentsView& view, std::uint32_t index, unsigned half_index_,
                         const ListInput& in)
      : segment(view.segments + index),
        result(view.results + index),
        number(segment->number),
        count(segment->count),
        half_index(half_index_),
        half(segment->tile, half_index_, in.columns),
        begin(segment->begin),
        end(number + 1 < count ? segment[1].begin : in.ranges[segment->tile].end) {}

  __device__ Segment& first() const { return *(segment - number); }
  __device__ SegmentResult& result_of(std::uint32_t other) const {
    return *(result - number + other);
  }
  __device__ SegmentState state_of(std::uint32_t other) const {
    return static_cast<SegmentState>(load_fresh(&(segment - number + other)->state[half_index]));
  }
  __device__ void publish_state(SegmentState state) const {
    __syncwarp();
    if (lane_index() == 0) publish(&segment->state[half_index], static_cast<std::uint32_t>(state));
  }

  /// All pixels have stopped in front of this segment. All lanes of a warp call it together.
  __device__ std::uint32_t stopped() const {
    return __shfl_sync(kAllLanes, load_fresh(&first().stopped[half_index]), 0);
  }
  __device__ void stop_in_front_of(std::uint32_t other) const {
    if (lane_index() == 0) atomicMin(&first().stopped[half_index], other);
  }
};

/// The transmittances in front of a segment for the pixels of a lane. All lanes of a warp call its
/// functions together.
struct Front {
  float before[kPixels];

  /// Begins with the product up to segment `known` - 1, which must be known; 0: with 1.
  __device__ void begin(const HalfSegment& own, std::uint32_t known) {
#pragma unroll
    for (int j = 0; j < kPixels; ++j)
      before[j] =
          known > 0 ? load_fresh(&own.result_of(known - 1).behind[own.half.place(j)]) : 1.0f;
  }

  /// Multiplies the segments from `known` to `own` - 1. Bit d of the mask decides about segment
  /// `own` - 1 - d: 0 leaves it out. The order is ascending, so that fewer factors give no smaller
  /// product.
  __device__ void multiply(const HalfSegment& own, std::uint32_t known, unsigned mask) {
    constexpr std::uint32_t kBatch = 8;  // results that a lane reads at the same time
    for (std::uint32_t first = known; first < own.number; first += kBatch) {
#pragma unroll
      for (std::uint32_t s = first; s < first + kBatch; ++s) {
        const std::uint32_t distance = own.number - 1 - s;  // large beyond the last
        const bool is_in = s < own.number && (distance >= kWarp || (mask >> distance & 1) != 0);
#pragma unroll
        for (int j = 0; j < kPixels; ++j) {
          const float* const value = &own.result_of(s).transmittance[own.half.place(j)];
          before[j] *= is_in ? load_fresh(value) : 1.0f;
        }
      }
    }
  }

  /// As far as it is known now: no less than the true transmittance.
  __device__ void bound(const HalfSegment& own) {
    const std::uint32_t distance = lane_index();
    const bool exists = distance < own.number;
    const SegmentState state =
        exists ? own.state_of(own.number - 1 - distance) : SegmentState::waiting;
    const unsigned known = __ballot_sync(kAllLanes, state == SegmentState::known);
    const unsigned composited = __ballot_sync(kAllLanes, state != SegmentState::waiting);
    const unsigned nearest = known != 0 ? lowest_bit(known) : kWarp;
    const std::uint32_t from = nearest < kWarp      ? own.number - nearest
                               : own.number < kWarp ? 0
                                                    : own.number - kWarp;
    begin(own, nearest < kWarp ? from : 0);
    multiply(own, from, composited);
  }

  /// Waits until it is known exactly. Returns false if all pixels have stopped in front.
  __device__ bool wait(const HalfSegment& own) {
    for (;;) {
      if (own.stopped() <= own.number) return false;
      for (std::uint32_t first = 0; first < own.number; first += kWarp) {
        const std::uint32_t distance = first + lane_index();
        const bool exists = distance < own.number;
        const SegmentState state =
            exists ? own.state_of(own.number - 1 - distance) : SegmentState::waiting;
        const unsigned known = __ballot_sync(kAllLanes, state == SegmentState::known);
        const unsigned waiting = __ballot_sync(kAllLanes, state == SegmentState::waiting);
        if (known == 0 && waiting != 0) break;
        if (known == 0) continue;
        const unsigned nearest = lowest_bit(known);
        if ((waiting & ((1u << nearest) - 1)) != 0) break;
        const std::uint32_t from = own.number - first - nearest;
        begin(own, from);
        multiply(own, from, kAllLanes);
        return true;
      }
    }
  }

  /// True if a pixel of the warp may not have stopped.
  __device__ bool any_live() const {
    bool any = false;
    for (const float pixel : before) any = any || pixel >= kTransmittanceMin;
    return __any_sync(kAllLanes, any);
  }
};

/// The colours of a lane's pixels.
struct Colors {
  glm::vec3 pixels[kPixels];

  __device__ void store(SegmentResult* result, const HalfTile& half) const {
#pragma unroll
    for (int j = 0; j < kPixels; ++j) store(result, half, j);
  }
  __device__ void store(SegmentResult* result, const HalfTile& half, int j) const {
    const unsigned place = half.place(j);
    result->red[place] = pixels[j].x;
    result->green[place] = pixels[j].y;
    result->blue[place] = pixels[j].z;
  }

  /// Adds every `step`-th segment of [begin, end), front to back.
  __device__ void add(const HalfSegment& own, std::uint32_t begin, std::uint32_t end,
                      std::uint32_t step) {
#pragma unroll 4
    for (std::uint32_t s = begin; s < end; s += step) {
      const SegmentResult& other = own.result_of(s);
#pragma unroll
      for (int j = 0; j < kPixels; ++j) {
        const unsigned place = own.half.place(j);
        pixels[j] += glm::vec3(load_fresh(&other.red[place]), load_fresh(&other.green[place]),
                               load_fresh(&other.blue[place]));
      }
    }
  }
};

/// Composites many pixels of half a tile at the same time.
template <Rows kRows>
__device__ void composite_many(const ListInput& in, const HalfSegment& own, Rings<false>& rings,
                               WalkedPixel (&pixels)[kPixels]) {
  Column<Cut::flush> column;
#pragma unroll
  for (int j = 0; j < kPixels; ++j)
    column.pixels[j] = {pixels[j].transmittance * kClear<Cut::flush>, 0, 0, 0};
  Marks unused{};
  Walk<false, kRows>(in, own.half, rings, column, unused).composite(own.begin, own.end);
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const ColumnPixel<Cut::flush>& pixel = column.pixels[j];
    pixels[j] = {0, pixel.red, pixel.green, pixel.blue};
  }
}

/// Composites the pixels again that stop in a segment. `pixels` has their true transmittance in
/// front of it, and 0 for the other pixels.
template <Rows kRows>
__device__ void composite_stopping(const ListInput& in, const HalfSegment& own, Rings<false>& rings,
                                   WalkedPixel (&pixels)[kPixels]) {
  PixelWalk walk(in, own.half, pixels);
  const unsigned stopping = walk.count();
  if (stopping == 0) return;
  bool stops[kPixels];
#pragma unroll
  for (int j = 0; j < kPixels; ++j) stops[j] = pixels[j].transmittance > 0.0f;
  if (stopping <= kFewPixels)
    walk.composite(own.begin, own.end);
  else
    composite_many<kRows>(in, own, rings, pixels);
  Colors colors;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    colors.pixels[j] = {pixels[j].red, pixels[j].green, pixels[j].blue};
    if (stops[j]) colors.store(own.result, own.half, j);
  }
}

/// Composites half a segment, unless all its pixels have stopped in front.
template <Rows kRows, bool kSlabs>
__device__ void composite(const ListInput& in, const HalfSegment& own, Rings<false>& rings,
                          const BlendOutput& out, const OcclusionView& occlusion) {
  if (own.stopped() <= own.number) return;
  Front front;
  front.bound(own);
  float carried[kPixels];  // scaled transmittance in front of the list
  if constexpr (kSlabs) {
#pragma unroll
    for (int j = 0; j < kPixels; ++j) {
      carried[j] = occlusion.carried(own.half.x, own.half.y + j);
      // Rounding may take the transmittance of a pixel that goes on below the least.
      const float most = fmaxf(carried[j] * kAlphaScale<Cut::flush>, kTransmittanceMin);
      front.before[j] = carried[j] > 0 ? fminf(front.before[j], most) : 0;
    }
  }
  if (!front.any_live()) return own.stop_in_front_of(own.number);

  const bool is_first = own.number == 0;
  const glm::vec3 start = is_first ? in.background : glm::vec3(0.0f);
  Column<Cut::flush> column;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const bool exists = own.half.x < in.width && own.half.y + j < in.height;
    const bool is_live = exists && front.before[j] >= kTransmittanceMin;
    column.pixels[j] = {is_live ? kClear<Cut::flush> : 0.0f, start.x, start.y, start.z};
    if (kSlabs && is_first && is_live) {
      const std::size_t at = static_cast<std::size_t>(own.half.y + j) * in.width + own.half.x;
      column.pixels[j].transmittance = carried[j];
      if (occlusion.slab > 0)
        column.pixels[j] = {carried[j], out.color[3 * at], out.color[3 * at + 1],
                            out.color[3 * at + 2]};
      front.before[j] = 1;
    }
  }
  Marks unused{};
  Walk<false, kRows>(in, own.half, rings, column, unused).composite(own.begin, own.end);
  float behind[kPixels];
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const ColumnPixel<Cut::flush>& pixel = column.pixels[j];
    behind[j] = pixel.is_live() ? pixel.transmittance * kAlphaScale<Cut::flush> : kStopped;
    own.result->transmittance[own.half.place(j)] = behind[j];
  }
  if (!is_first) {
    own.publish_state(SegmentState::composited);
    if (!front.wait(own)) return;
  }
  bool is_live = false;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    behind[j] *= front.before[j];
    own.result->behind[own.half.place(j)] = behind[j];
    is_live = is_live || behind[j] >= kTransmittanceMin;
  }
  own.publish_state(SegmentState::known);
  if (!__any_sync(kAllLanes, is_live)) own.stop_in_front_of(own.number + 1);

  Colors colors;
  WalkedPixel stopping[kPixels];
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    const ColumnPixel<Cut::flush>& pixel = column.pixels[j];
    const bool was_live = front.before[j] >= kTransmittanceMin;
    const float share = was_live ? front.before[j] : 0.0f;
    colors.pixels[j] = {share * pixel.red, share * pixel.green, share * pixel.blue};
    const bool stops = was_live && behind[j] < kTransmittanceMin;
    stopping[j] = {stops ? front.before[j] : 0.0f, 0, 0, 0};
  }
  colors.store(own.result, own.half);
  // The first segment is exact already.
  if (!is_first) composite_stopping<kRows>(in, own, rings, stopping);
}

/// The last warp of a group to end joins its segments, and the last warp of a list its groups.
template <bool kSlabs>
__device__ void join(const ListInput& in, const BlendOutput& out, const HalfSegment& own,
                     const OcclusionView& occlusion) {
  const std::uint32_t begin = own.number / kGroup * kGroup, end = min(begin + kGroup, own.count);
  Segment* const group = own.segment - (own.number - begin);
  if (!is_last_warp(&group->ended[own.half_index], end - begin)) return;
  Colors colors{};
  colors.add(own, begin, min(end, own.stopped()), 1);
  if (own.count > kGroup) {
    colors.store(&own.result_of(begin), own.half);
    const std::uint32_t groups = (own.count + kGroup - 1) / kGroup;
    if (!is_last_warp(&own.first().groups_ended[own.half_index], groups)) return;
    colors = {};
    colors.add(own, 0, min(own.count, own.stopped()), kGroup);
  }
  bool was_live[kPixels] = {};  // in front of the list; with slabs
  if constexpr (kSlabs) {
    const bool has_stopped = own.stopped() <= own.count;
    bool is_live = false;
#pragma unroll
    for (int j = 0; j < kPixels; ++j) {
      if (own.half.x >= in.width || own.half.y + j >= in.height) continue;
      const float behind =
          has_stopped ? 0.0f : load_fresh(&own.result_of(own.count - 1).behind[own.half.place(j)]);
      const std::size_t pixel = static_cast<std::size_t>(own.half.y + j) * in.width + own.half.x;
      was_live[j] = occlusion.carried(own.half.x, own.half.y + j) > 0;
      const bool goes_on = was_live[j] && behind >= kTransmittanceMin;
      is_live = is_live || goes_on;
      occlusion.transmittance[pixel] = goes_on ? behind * kClear<Cut::flush> : 0;
    }
    occlusion.record(own.half.x0, own.half.y0, is_live);
  }
  if (own.half.x >= in.width) return;
#pragma unroll
  for (int j = 0; j < kPixels; ++j) {
    if (own.half.y + j >= in.height) return;
    if (kSlabs && !was_live[j]) continue;
    const std::size_t pixel = static_cast<std::size_t>(own.half.y + j) * in.width + own.half.x;
    out.color[3 * pixel] = colors.pixels[j].x;
    out.color[3 * pixel + 1] = colors.pixels[j].y;
    out.color[3 * pixel + 2] = colors.pixels[j].z;
  }
}

/// The next turn of the calling warp.
__device__ std::uint32_t next_turn(std::uint32_t* turns) {
  std::uint32_t turn = 0;
  if (lane_index() == 0) turn = atomicAdd(turns, 1u);
  return __shfl_sync(kAllLanes, turn, 0);
}

template <Rows kRows, bool kSlabs>
__global__ void __launch_bounds__(kBlendThreads, kBlendBlocks)
    blend_segments(SegmentsView view, ListInput in, BlendOutput out, OcclusionView occlusion) {
  __shared__ Rings<false> rings[kHalfTiles];
  if (!view.are_used()) return;
  const ScheduleView queue{view.queue_sizes, view.queue, view.capacity};
  const std::uint32_t segments =
      __shfl_sync(kAllLanes, inclusive_sum_of_warp(view.queue_sizes[lane_index()]), kWarp - 1);
  for (;;) {
    const std::uint32_t turn = next_turn(&view.counters->turns);
    if (turn >= kHalfTiles * segments) return;
    const HalfSegment own(view, queue.tile(turn / kHalfTiles), turn % kHalfTiles, in);
    composite<kRows, kSlabs>(in, own, rings[threadIdx.x / kWarp], out, occlusion);
    join<kSlabs>(in, out, own, occlusion);
  }
}

}  // namespace

void blend_long_lists(const FrameContext& frame, const Scratch& scratch, const Outputs& outputs,
                      Pixels& pixels, const OcclusionView& occlusion) {
  const bool is_thin = has_thin_rows(frame.settings);
  launch("blend",
         occlusion.is_used() ? (is_thin ? blend_segments<Rows::exponents, true>
                                        : blend_segments<Rows::products, true>)
         : is_thin           ? blend_segments<Rows::exponents, false>
                             : blend_segments<Rows::products, false>,
         Blocks(kBlendBlocks * scratch.multiprocessors, kBlendThreads), frame.stream,
         scratch.segments, scratch.lists(frame), BlendOutput::of(pixels, outputs), occlusion);
}

}  // namespace qs::cuda::fast
