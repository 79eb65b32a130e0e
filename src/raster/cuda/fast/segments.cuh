// SPDX-License-Identifier: MIT
//
// Long lists are cut into segments that many warps composite at the same time. Every segment is
// composited first as if nothing were in front of it, which gives its colour and transmittance. A
// pixel stops in the segment in which the product of transmittances falls below kTransmittanceMin.
// Such segments are composited again for those pixels, from their true transmittance, so the stop
// rule stays exact. Finally the segments of a tile are joined, front to back.
//
// Rounding depends on where a list is cut. All lossless modes must draw the same picture, although
// they list different Gaussians: some list more that reach no pixel with alpha >= 1/255. So
// segments are counted in Gaussians that certainly reach a pixel, which every lossless mode lists.
#pragma once

#include "raster/cuda/fast/scratch.cuh"
#include "raster/cuda/fast/walk.cuh"

namespace qs::cuda::fast {

inline constexpr std::uint32_t kSegment = 512;      ///< Gaussians counted per segment, at least
inline constexpr std::uint32_t kMaxSegments = 256;  ///< of a list

/// The number of segments of a list with `counted` Gaussians.
QS_HD std::uint32_t segment_count(std::uint32_t counted) {
  const std::uint32_t count = (counted + kSegment - 1) / kSegment;
  return count < kMaxSegments ? count : kMaxSegments;
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
        parts_(segment_count(range.size())),
        part_((range.size() / parts_ + kWarp) / kWarp * kWarp) {}

  /// Counts the Gaussians in part `number` of the list. The parts have equal lengths; there are as
  /// many as reserved segments.
  __device__ void count(const ListInput& in, std::uint32_t tile, std::uint32_t number) {
    const std::uint32_t begin = number * part_, end = min(begin + part_, range_.size());
    std::uint32_t sum = 0;
#pragma unroll 4
    for (std::uint32_t at = begin; at < end; at += kWarp) {
      const std::uint32_t entry = range_.begin + min(at + lane_index(), range_.size() - 1);
      const bool counts = at + lane_index() < end && reaches(in, tile, in.gaussians[entry]);
      const unsigned mark = __ballot_sync(kAllLanes, counts);
      if (lane_index() == 0) marks_[at / kWarp] = mark;
      sum += __popc(mark);
    }
    if (lane_index() == 0) segments_[number].counted = sum;
  }

  /// Must precede the functions below. Requires all parts to be counted.
  __device__ void cut() {
    std::uint32_t sum = 0;
    for (std::uint32_t s = lane_index(); s < parts_; s += kWarp) sum += segments_[s].counted;
    const std::uint32_t total = __shfl_sync(kAllLanes, inclusive_sum_of_warp(sum), kWarp - 1);
    count_ = total > longest_uncut_ ? segment_count(total) : 1;
    each_ = (total + count_ - 1) / count_;
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
        const unsigned lane = static_cast<unsigned>(__ffs(static_cast<int>(beyond))) - 1;
        return {first + lane, before + __shfl_sync(kAllLanes, sum - own, lane)};
      }
      before += __shfl_sync(kAllLanes, sum, kWarp - 1);
    }
    return {0, 0};  // the sum of all is too small
  }

  /// Position in the list of the counted Gaussian number `rank`.
  __device__ std::uint32_t position_of(std::uint32_t rank) const {
    const Found part = find(parts_, rank, [&](std::uint32_t s) { return segments_[s].counted; });
    const std::uint32_t words = part_ / kWarp, first = part.index * words;
    const Found word = find(words, rank - part.before, [&](std::uint32_t w) {
      const bool exists = (first + w) * kWarp < range_.size();
      return exists ? static_cast<std::uint32_t>(__popc(marks_[first + w])) : 0u;
    });
    const std::uint32_t left = rank - part.before - word.before;
    const unsigned mark = marks_[first + word.index];
    const bool is_it = (mark >> lane_index() & 1) != 0 &&
                       static_cast<std::uint32_t>(__popc(mark & lanes_below())) == left;
    const auto bit = static_cast<int>(__ballot_sync(kAllLanes, is_it));
    return (first + word.index) * kWarp + static_cast<unsigned>(__ffs(bit)) - 1;
  }

  Segment* segments_;
  std::uint32_t* marks_;
  ListRange range_;
  std::uint32_t longest_uncut_;
  std::uint32_t parts_, part_;  // number and length
  std::uint32_t count_ = 1, each_ = 0;
};

}  // namespace qs::cuda::fast
