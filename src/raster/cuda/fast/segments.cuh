// SPDX-License-Identifier: MIT
//
// Long lists are cut into segments that many warps composite at the same time. Every segment is
// composited first as if nothing were in front of it, which gives its colour and transmittance. A
// pixel stops in the segment in which the product of transmittances falls below kTransmittanceMin.
// Such segments are composited again for those pixels, from their true transmittance, so the stop
// rule stays exact. Finally the segments of a tile are joined, front to back.
//
// Segments are begun in waves, the first ones of all lists first. A warp leaves out the pixels that
// have stopped in the segments in front, as far as these are finished.
//
// Rounding depends on where a list is cut. All lossless modes must draw the same picture, although
// they list different Gaussians: some list more that reach no pixel with alpha >= 1/255. So a list
// is cut at samples: one Gaussian in kSampled, if it certainly reaches a pixel, because every
// lossless mode lists these.
#pragma once

#include "raster/cuda/fast/scratch.cuh"
#include "raster/cuda/fast/walk.cuh"

namespace qs::cuda::fast {

inline constexpr std::uint32_t kSampled = 8;
inline constexpr std::uint32_t kSegment = 64;  ///< samples per segment, at least

/// True for one Gaussian in kSampled, regardless of their order (Appleby, MurmurHash3: finalizer).
QS_HD bool may_be_sample(std::uint32_t gaussian) {
  std::uint32_t hash = gaussian;
  hash = (hash ^ hash >> 16) * 0x85ebca6bu;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35u;
  return (hash ^ hash >> 16) % kSampled == 0;
}

/// The samples of a list with so many pairs: more are too improbable to happen (six standard
/// deviations above the mean).
QS_HD std::uint32_t most_samples(std::uint32_t pairs) {
  const float mean = static_cast<float>(pairs / kSampled);
  return static_cast<std::uint32_t>(mean + 6 * sqrtf(mean));
}

/// The number of segments of a list with `samples` samples.
QS_HD std::uint32_t segment_count(std::uint32_t samples) {
  const std::uint32_t count = (samples + kSegment - 1) / kSegment;
  return count < kMaxSegments ? count : kMaxSegments;
}

/// The segments that a list of `pairs` pairs reserves.
QS_HD std::uint32_t reserved_segments(std::uint32_t pairs) {
  return segment_count(most_samples(pairs));
}

/// A long list. All lanes of a warp call its functions together.
class LongList {
 public:
  /// `first` is the list's first segment.
  __device__ LongList(const SegmentsView& view, ListRange range, std::uint32_t first)
      : segments_(view.segments + first),
        marks_(view.marks + range.begin / SegmentsView::kPairsPerMark),
        range_(range),
        longest_uncut_(view.longest_uncut),
        parts_(reserved_segments(range.size())),
        part_((range.size() / parts_ + kWarp) / kWarp * kWarp) {}

  /// Counts the samples in part `number` of the list. The parts have equal lengths; there are as
  /// many as reserved segments.
  __device__ void count(const ListInput& in, std::uint32_t tile, std::uint32_t number) {
    const std::uint32_t begin = number * part_, end = min(begin + part_, range_.size());
    std::uint32_t sum = 0;
#pragma unroll 4
    for (std::uint32_t at = begin; at < end; at += kWarp) {
      const std::uint32_t entry = range_.begin + min(at + lane_index(), range_.size() - 1);
      const std::uint32_t gaussian = in.gaussians[entry];
      const bool is_sample =
          at + lane_index() < end && may_be_sample(gaussian) && reaches(in, tile, gaussian);
      const unsigned mark = __ballot_sync(kAllLanes, is_sample);
      if (lane_index() == 0) marks_[at / kWarp] = mark;
      sum += __popc(mark);
    }
    if (lane_index() == 0) segments_[number].samples = sum;
  }

  /// Must precede the functions below. Requires all parts to be counted.
  __device__ void cut() {
    std::uint32_t sum = 0;
    for (std::uint32_t s = lane_index(); s < parts_; s += kWarp) sum += segments_[s].samples;
    const std::uint32_t total = __shfl_sync(kAllLanes, inclusive_sum_of_warp(sum), kWarp - 1);
    // A list with more samples is longer than longest_uncut_ in every mode.
    count_ = total > most_samples(longest_uncut_) ? min(segment_count(total), parts_) : 1;
    each_ = (total + count_ - 1) / count_;
    if (each_ > 0) count_ = (total + each_ - 1) / each_;  // rounding up may leave none for the last
  }

  __device__ std::uint32_t segments() const { return count_; }

  /// The pairs of segment `number`.
  __device__ std::uint32_t begin(std::uint32_t number) const {
    return range_.begin + (number == 0 ? 0 : position_of(number * each_));
  }
  __device__ std::uint32_t end(std::uint32_t number) const {
    return number + 1 == count_ ? range_.end : begin(number + 1);
  }

 private:
  /// True if a pixel of the tile certainly has alpha >= 1/255: tests the pixel nearest to the mean.
  static __device__ bool reaches(const ListInput& in, std::uint32_t tile, std::uint32_t gaussian) {
    constexpr float kMargin = 0.05f;  // of log2 alpha
    const BoundedSplat& splat = in.splats[gaussian];
    const auto nearest = [](float mean, std::uint32_t first, int limit) {
      const int last = min(static_cast<int>(first) + kTileSize, limit) - 1;
      const float pixel = fmaxf(floorf(mean + 0.5f), static_cast<float>(first));
      return fminf(pixel, static_cast<float>(last));
    };
    const float dx = nearest(splat.x, tile % in.columns * kTileSize, in.width) - splat.x;
    const float dy = nearest(splat.y, tile / in.columns * kTileSize, in.height) - splat.y;
    const float along = fmaf(splat.xy, dy, splat.xx * dx);
    const float log2_alpha = fmaf(dx, along, fmaf(splat.yy * dy, dy, splat.log2_opacity));
    return log2_alpha >= kMargin - kLog2Of255 && splat.clamp_rows < INFINITY;
  }

  struct Found {
    std::uint32_t index, before;  ///< before: the sum over the lower indices
  };

  /// The index < size at which the running sum of value(index) exceeds `rank`.
  template <class Value>
  static __device__ Found find(std::uint32_t size, std::uint32_t rank, const Value& value) {
    std::uint32_t before = 0;
    for (std::uint32_t first = 0; first < size; first += kWarp) {
      const std::uint32_t own = first + lane_index() < size ? value(first + lane_index()) : 0;
      const std::uint32_t sum = inclusive_sum_of_warp(own);
      const unsigned beyond = __ballot_sync(kAllLanes, before + sum > rank);
      if (beyond != 0) {
        const unsigned lane = lowest_bit(beyond);
        return {first + lane, before + __shfl_sync(kAllLanes, sum - own, lane)};
      }
      before += __shfl_sync(kAllLanes, sum, kWarp - 1);
    }
    return {0, 0};  // the sum of all is too small
  }

  /// Position in the list of sample number `rank`.
  __device__ std::uint32_t position_of(std::uint32_t rank) const {
    const Found part = find(parts_, rank, [&](std::uint32_t s) { return segments_[s].samples; });
    const std::uint32_t words = part_ / kWarp, first = part.index * words;
    const Found word = find(words, rank - part.before, [&](std::uint32_t w) {
      const bool exists = (first + w) * kWarp < range_.size();
      return exists ? static_cast<std::uint32_t>(__popc(marks_[first + w])) : 0u;
    });
    const std::uint32_t left = rank - part.before - word.before;
    const unsigned mark = marks_[first + word.index];
    const bool is_it = (mark >> lane_index() & 1) != 0 &&
                       static_cast<std::uint32_t>(__popc(mark & lanes_below())) == left;
    return (first + word.index) * kWarp + lowest_bit(__ballot_sync(kAllLanes, is_it));
  }

  Segment* segments_;
  std::uint32_t* marks_;
  ListRange range_;
  std::uint32_t longest_uncut_;
  std::uint32_t parts_, part_;  // number and length
  std::uint32_t count_ = 1, each_ = 0;
};

}  // namespace qs::cuda::fast
