// SPDX-License-Identifier: MIT
//
// The points are sorted along a curve that fills space (Morton order). 64 points in a row have a
// box, and 64 boxes have one. A point's neighbours on the curve bound the distance of its third
// neighbour; then it visits the boxes within the smallest bound so far.
#include <cmath>

#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/nearest.h"
#include "raster/cuda/common/scan_and_sort.cuh"
#include "raster/cuda/common/warp.cuh"

namespace qs::cuda::diff {
namespace {

constexpr std::uint32_t kInBox = 64;  ///< points of a box, and boxes of a large one
constexpr int kNeighbours = 3;
constexpr unsigned kBoundsBlock = 1024;
constexpr int kAxisBits = 21;
constexpr std::uint64_t kNotFinite = ~std::uint64_t{0};

struct Box {
  float low[3], high[3];

  static __device__ Box none() {
    return {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  }
  __device__ void add(const Box& other) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = fminf(low[axis], other.low[axis]);
      high[axis] = fmaxf(high[axis], other.high[axis]);
    }
  }
  /// Not above the squared distance to any point of the box, also after rounding.
  __device__ double distance2(const double (&point)[3]) const {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double gap = fmax(fmax(static_cast<double>(low[axis]) - point[axis],
                                   point[axis] - static_cast<double>(high[axis])),
                              0.0);
      sum += gap * gap;
    }
    return sum;
  }
};

/// Facts of all points together.
struct PointFacts {
  Box bounds;            ///< of the finite points
  std::uint32_t finite;  ///< their number
};

__device__ bool is_finite_point(const Rows<const float>& points, std::size_t i) {
  const float sum = points.at(i, 0) - points.at(i, 0) + (points.at(i, 1) - points.at(i, 1)) +
                    (points.at(i, 2) - points.at(i, 2));
  return sum == 0.0f;
}

/// One block.
__global__ void __launch_bounds__(kBoundsBlock)
    find_bounds(Rows<const float> points, std::uint32_t count, PointFacts* facts) {
  __shared__ Box boxes[kBoundsBlock];
  Box own = Box::none();
  std::uint32_t finite = 0;
  for (std::uint32_t i = threadIdx.x; i < count; i += kBoundsBlock) {
    if (!is_finite_point(points, i)) continue;
    ++finite;
    for (int axis = 0; axis < 3; ++axis) {
      own.low[axis] = fminf(own.low[axis], points.at(i, axis));
      own.high[axis] = fmaxf(own.high[axis], points.at(i, axis));
    }
  }
  boxes[threadIdx.x] = own;
  const std::uint32_t total = sum_of_block<kBoundsBlock>(finite).total;  // with barriers
  for (unsigned half = kBoundsBlock / 2; half > 0; half /= 2) {
    if (threadIdx.x < half) boxes[threadIdx.x].add(boxes[threadIdx.x + half]);
    __syncthreads();
  }
  if (threadIdx.x == 0) *facts = {boxes[0], total};
}

/// The bits of a number with two zeros behind each.
__device__ std::uint64_t spread_bits(std::uint32_t number) {
  std::uint64_t bits = number;
  bits = (bits | bits << 32) & 0x1f00000000ffff;
  bits = (bits | bits << 16) & 0x1f0000ff0000ff;
  bits = (bits | bits << 8) & 0x100f00f00f00f00f;
  bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
  return (bits | bits << 2) & 0x1249249249249249;
}

__device__ std::uint64_t place_on_curve(const Rows<const float>& points, std::size_t i,
                                        const Box& bounds) {
  std::uint64_t place = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = static_cast<double>(bounds.low[axis]);
    const double size = static_cast<double>(bounds.high[axis]) - low;
    const double share = size > 0 ? (static_cast<double>(points.at(i, axis)) - low) / size : 0;
    const auto cell = static_cast<std::uint32_t>(share * ((1 << kAxisBits) - 1));
    place |= spread_bits(cell) << axis;
  }
  return place;
}

/// Positions along the curve.
struct SortedPoints {
  const std::uint32_t* order;  ///< numbers of the points
  float4* positions;
  Box *boxes, *large;
  const PointFacts* facts;

  __device__ void point(std::uint32_t place, double (&to)[3]) const {
    const float4 at = positions[place];
    to[0] = static_cast<double>(at.x);
    to[1] = static_cast<double>(at.y);
    to[2] = static_cast<double>(at.z);
  }
  /// The CPU's order of the sum.
  __device__ double distance2(std::uint32_t place, const double (&from)[3]) const {
    double other[3], sum = 0;
    point(place, other);
    for (int axis = 0; axis < 3; ++axis) {
      const double gap = from[axis] - other[axis];
      sum += gap * gap;
    }
    return sum;
  }
};

/// The smallest squared distances, ascending.
struct Smallest {
  double values[kNeighbours] = {INFINITY, INFINITY, INFINITY};

  __device__ double worst() const { return values[kNeighbours - 1]; }
  __device__ void add(double value) {
    for (double& own : values) {
      if (!(value < own)) continue;
      const double larger = own;
      own = value;
      value = larger;
    }
  }
};

__device__ std::uint32_t boxes_of(std::uint32_t points) { return (points + kInBox - 1) / kInBox; }

/// One thread per box of 64 points.
__global__ void __launch_bounds__(kThreads) find_boxes(SortedPoints points) {
  const std::uint32_t box = blockIdx.x * kThreads + threadIdx.x;
  const std::uint32_t count = points.facts->finite;
  if (box >= boxes_of(count)) return;
  Box own = Box::none();
  for (std::uint32_t place = box * kInBox; place < min((box + 1) * kInBox, count); ++place) {
    const float4 at = points.positions[place];
    own.add({{at.x, at.y, at.z}, {at.x, at.y, at.z}});
  }
  points.boxes[box] = own;
}

/// One thread per large box.
__global__ void __launch_bounds__(kThreads) find_large_boxes(SortedPoints points) {
  const std::uint32_t large = blockIdx.x * kThreads + threadIdx.x;
  const std::uint32_t count = boxes_of(points.facts->finite);
  if (large >= boxes_of(count)) return;
  Box own = Box::none();
  for (std::uint32_t box = large * kInBox; box < min((large + 1) * kInBox, count); ++box)
    own.add(points.boxes[box]);
  points.large[large] = own;
}

/// The mean for the point at a place of the curve.
__device__ double mean_of_neighbours(const SortedPoints& points, std::uint32_t place) {
  const std::uint32_t count = points.facts->finite, boxes = boxes_of(count);
  const int neighbours = static_cast<int>(min(count - 1, std::uint32_t{kNeighbours}));
  if (neighbours == 0) return 0;
  double own[3];
  points.point(place, own);
  Smallest near;
  for (std::uint32_t step = 1; step <= kNeighbours; ++step) {
    if (place >= step) near.add(points.distance2(place - step, own));
    if (place + step < count) near.add(points.distance2(place + step, own));
  }
  const double bound = near.worst();  // infinite with fewer neighbours
  Smallest found;
  const auto is_near = [&](const Box& box) {
    return box.distance2(own) <= fmin(bound, found.worst());
  };
  for (std::uint32_t large = 0; large < boxes_of(boxes) && found.worst() > 0; ++large) {
    if (!is_near(points.large[large])) continue;
    for (std::uint32_t box = large * kInBox; box < min((large + 1) * kInBox, boxes); ++box) {
      if (!is_near(points.boxes[box])) continue;
      for (std::uint32_t other = box * kInBox; other < min((box + 1) * kInBox, count); ++other)
        if (other != place) found.add(points.distance2(other, own));
    }
  }
  double mean = 0;
  for (int k = 0; k < neighbours; ++k) mean += found.values[k] / static_cast<double>(neighbours);
  return mean;
}

}  // namespace

template <class Real>
void neighbour_distances2(const Rows<const float>& points, std::size_t count, const Queue& queue,
                          const Rows<Real>& out) {
  if (count == 0) return;
  const cudaStream_t stream = stream_of(queue);
  const auto size = static_cast<std::uint32_t>(count);
  DeviceBuffer<PointFacts> facts;
  DeviceBuffer<float4> positions;
  DeviceBuffer<Box> boxes, large;
  SortBuffers sorted;
  facts.reserve("neighbours", 1);
  positions.reserve("neighbours", count);
  boxes.reserve("neighbours", count / kInBox + 1);
  large.reserve("neighbours", count / kInBox / kInBox + 1);
  sorted.reserve("neighbours", size);
  launch("find_bounds", find_bounds, Blocks(1, kBoundsBlock), stream, points, size, facts.data());
  for_each_item("neighbours", size, stream,
                [=, facts = facts.data(), keys = sorted.keys.data(),
                 values = sorted.values.data()] __device__(std::uint32_t i) {
                  keys[i] = is_finite_point(points, i) ? place_on_curve(points, i, facts->bounds)
                                                       : kNotFinite;
                  values[i] = i;
                });
  sort_pairs(sorted, size, 64, stream);
  const SortedPoints view{sorted.values.data(), positions.data(), boxes.data(), large.data(),
                          facts.data()};
  for_each_item("neighbours", size, stream, [=] __device__(std::uint32_t place) {
    const std::size_t i = view.order[place];
    view.positions[place] = {points.at(i, 0), points.at(i, 1), points.at(i, 2), 0};
  });
  launch("find_boxes", find_boxes, blocks_for(count / kInBox + 1), stream, view);
  launch("find_large_boxes", find_large_boxes, blocks_for(count / kInBox / kInBox + 1), stream,
         view);
  for_each_item("neighbours", size, stream, [=] __device__(std::uint32_t place) {
    out.at(view.order[place]) = place < view.facts->finite
                                    ? static_cast<Real>(mean_of_neighbours(view, place))
                                    : static_cast<Real>(NAN);
  });
  check(cudaStreamSynchronize(stream), "neighbours");
}

template void neighbour_distances2(const Rows<const float>&, std::size_t, const Queue&,
                                   const Rows<float>&);
template void neighbour_distances2(const Rows<const float>&, std::size_t, const Queue&,
                                   const Rows<double>&);

}  // namespace qs::cuda::diff
