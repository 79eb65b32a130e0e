// SPDX-License-Identifier: MIT
//
// Long lists are cut into segments that many warps composite at the same time (long_lists.cu).
//
// Rounding depends on where a list is cut. All lossless modes must draw the same picture, although
// they list different Gaussians: some list more that reach no pixel with alpha >= 1/255. So a list
// is cut at samples: one Gaussian in CutRule::distance, if it certainly reaches a pixel of the
// tile, because every lossless mode lists these. They are found and counted while lists are
// written.
#pragma once

#include "raster/cuda/common/schedule.cuh"
#include "raster/cuda/fast/scratch.cuh"

namespace qs::cuda::fast {

/// The least CutRule::distance, and the unit of FastCounters::sampled_tiles.
inline constexpr std::uint32_t kSampled = 8;

/// True for one number in `distance`, a power of two (Appleby, MurmurHash3: finalizer).
QS_HD bool is_sampled(std::uint32_t number, std::uint32_t distance) {
  std::uint32_t hash = number;
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return ((hash ^ hash >> 16) & (distance - 1)) == 0;
}

/// Lists of more than `least` samples are cut into segments of `each` samples, if the longest list
/// of the frame has more than `longest`. The rule follows from the frame: a warp may walk through a
/// long list as long as the rest of the GPU composites the other lists; more segments cost more,
/// and longer ones end later. The measure of all lists is FastCounters::sampled_tiles, the tiles in
/// the bounding boxes of the Gaussians in one warp of kSampled. It is equal in all modes and on all
/// GPUs. A usual segment has 16 to 31 samples: more would take longer to find.
struct CutRule {
  static constexpr float kMostSegments = 640;  ///< of a list

  std::uint32_t least, each, longest;
  std::uint32_t distance = kSampled;  ///< one Gaussian in so many may be a sample

  static QS_HD CutRule of(const SegmentsView& view, const FastCounters& counters) {
    if (view.least > 0) return {view.least, view.each, view.least};
    // In pairs / kSampled. Fitted on ten scenes, and judged on each without it, see
    // docs/log/far.md.
    const float tiles = static_cast<float>(counters.sampled_tiles);
    const auto least = static_cast<std::uint32_t>(fminf(128 + tiles / 5120, 1024));
    const auto each = static_cast<std::uint32_t>(fminf(fmaxf(sqrtf(tiles) / 13, 16), 128));
    const auto longest = static_cast<std::uint32_t>(fminf(275 + tiles / 672, 4096));
    unsigned shift = 0;
    while (each >> shift >= 32) ++shift;
    return {least >> shift, each >> shift, longest >> shift, kSampled << shift};
  }
  static __device__ CutRule of(const SegmentsView& view) { return of(view, *view.counters); }

  QS_HD bool may_be_sample(std::uint32_t place) const { return is_sampled(place, distance); }
  /// False if no list of so many pairs is cut, in any mode.
  QS_HD bool may_cut(std::uint32_t pairs) const { return most_samples(pairs) > least; }
  /// False if a frame whose longest list has so many pairs cuts none, in any mode.
  QS_HD bool may_be_used(std::uint32_t pairs) const { return most_samples(pairs) > longest; }
  __device__ bool cuts(std::uint32_t samples) const { return samples > least; }
  /// Samples in a segment of a list that is cut. The last segment has the rest.
  __device__ std::uint32_t each_of(std::uint32_t samples) const {
    return max(each, static_cast<std::uint32_t>(static_cast<float>(samples) / kMostSegments));
  }

 private:
  /// The samples of a list with so many pairs: more are too improbable to happen (six standard
  /// deviations above the mean).
  QS_HD std::uint32_t most_samples(std::uint32_t pairs) const {
    const float mean = static_cast<float>(pairs / distance);
    return static_cast<std::uint32_t>(mean + 6 * sqrtf(mean));
  }
};

__device__ inline bool SegmentsView::are_used() const {
  return counters->longest_samples > CutRule::of(*this).longest;
}

/// The tiles of a macro-tile that a Gaussian lists, as in MacroMask, and above them the
/// tiles in which it is a sample.
using MarkedTiles = std::uint16_t;
constexpr unsigned kSampleShift = 8;
static_assert(MacroTiles::kTiles == kSampleShift);

/// Finds the tiles in which Gaussians are samples. A kernel parameter.
struct SampleFinder {
  const PackedFootprint* footprints;
  int width, height;  // px

  /// Requires CutRule::may_be_sample(place). `mask`: the tiles that Gaussian `place` lists of the
  /// macro-tile with the tiles `window`.
  __device__ MarkedTiles marked(std::uint32_t place, unsigned mask, const TileRect& window) const {
    const PackedFootprint& own = footprints[place];
    const Covariance2<float> covariance = own.covariance;
    const float determinant = covariance.determinant();
    constexpr float kThinnest = 1e4f;  // rounding does not matter
    constexpr float kMargin = 0.07f;   // of 2 ln alpha
    const bool is_round = covariance.xx * covariance.yy < kThinnest * determinant;
    const float most = is_round ? (own.gamma - kMargin) * determinant : -1.0f;
    unsigned samples = 0;
#pragma unroll
    for (int tile = 0; tile < MacroTiles::kTiles; ++tile) {
      const int column = window.columns.begin + tile % MacroTiles::kColumns;
      const int row = window.rows.begin + tile / MacroTiles::kColumns;
      const float dx = offset(own.mean_px.x, column * kTileSize, width);
      const float dy = offset(own.mean_px.y, row * kTileSize, height);
      const float along = fmaf(covariance.yy, dx, -2.0f * covariance.xy * dy);
      if (fmaf(dx, along, covariance.xx * dy * dy) <= most) samples |= 1u << tile;
    }
    return static_cast<MarkedTiles>(mask | (samples & mask) << kSampleShift);
  }

 private:
  /// From the mean to the nearest pixel of a tile.
  static __device__ float offset(float mean, int first, int limit) {
    const int last = min(first + kTileSize, limit) - 1;
    const float pixel = fmaxf(floorf(mean + 0.5f), static_cast<float>(first));
    return fminf(pixel, static_cast<float>(last)) - mean;
  }
};

/// Reserves the segments of the list of a tile, which begins at pair `begin`, with `each` samples.
/// All lanes of a warp call it together. SegmentsView::first_segments has the result.
__device__ inline void reserve_segments(const SegmentsView& view, std::uint32_t tile,
                                        std::uint32_t begin, std::uint32_t samples,
                                        std::uint32_t each) {
  const std::uint32_t count = (samples + each - 1) / each;
  const unsigned lane = lane_index();
  std::uint32_t first = 0;
  if (lane == 0) first = atomicAdd(&view.counters->segments, count);
  first = __shfl_sync(kAllLanes, first, 0);
  const bool fits = first + count <= view.capacity;
  if (lane == 0) view.first_segments[tile] = fits ? first : SegmentsView::kUncut;
  if (!fits) return;
  // Each lane reserves room for a class of numbers, so that all wait for memory once.
  const std::uint32_t begin_of_class = min(least_length(lane) - 1, count);
  const std::uint32_t end_of_class =
      lane < kLengthClasses - 1 ? min(least_length(lane + 1) - 1, count) : count;
  std::uint32_t place_of_0 = 0;  // where number 0 would be if it were in the class
  if (begin_of_class < end_of_class)
    place_of_0 = atomicAdd(&view.queue_sizes[lane], end_of_class - begin_of_class) - begin_of_class;
  for (std::uint32_t number = lane; number - lane < count; number += kWarp) {
    const bool exists = number < count;
    const unsigned own = min(half_octaves(number + 1), kLengthClasses - 1);
    const std::uint32_t slot = __shfl_sync(kAllLanes, place_of_0, own) + number;
    if (!exists) continue;
    view.segments[first + number] = {
        tile, number, count, begin, {}, {}, each, {}, {SegmentsView::kUncut, SegmentsView::kUncut}};
    view.queue[own * view.capacity + slot] = first + number;
  }
}

}  // namespace qs::cuda::fast
