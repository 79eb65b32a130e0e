// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/ssim.h"
#include "learn/diff/cuda/ssim_block.cuh"
#include "raster/cuda/common/warp.cuh"

namespace qs::cuda::diff {
namespace {

using PlaneShape = SsimShape<1>;

/// Sums of a block.
struct MeanSums {
  double ssim, l1;
};

/// The running block's plane of the pictures.
struct Plane {
  int picture, channel;
  std::uint32_t first;  ///< its first value in a field of `terms`

  static __device__ Plane of(const PlaneShape& shape, const BatchSizes& sizes) {
    const int plane = shape.picture();
    return {plane / sizes.channels, plane % sizes.channels,
            static_cast<std::uint32_t>(plane) * static_cast<std::uint32_t>(shape.row) *
                static_cast<std::uint32_t>(shape.height)};
  }
};

/// One block per 48x16 pixels of a plane.
__global__ void __launch_bounds__(kSsimBlock)
    sum_similarity(PlaneShape shape, ComparedPictures compared, std::size_t field, float* terms,
                   MeanSums* sums) {
  __shared__ Surroundings<1, 2, 5> around;
  const BatchSizes& sizes = compared.sizes;
  const Plane plane = Plane::of(shape, sizes);
  around.load(shape, [&](int f, int x, int y) {
    return (f == 0 ? compared.a : compared.b).at(plane.picture, plane.channel, x, y);
  });
  float moments[5][kSsimDown];
  around.blur(shape, SsimMoments{}, moments);
  MeanSums own_sums{0, 0};
  for_own_values(shape, [&](int own, int x, int y) {
    Similarity<float> s{};
    if (x >= sizes.margin && x + sizes.margin < sizes.width && y >= sizes.margin &&
        y + sizes.margin < sizes.height) {
      s = similarity_of(moments, own);
      own_sums.ssim += static_cast<double>(s.value);
    }
    const int column = x - shape.left() + kSsimRadius, row = y - shape.top() + kSsimRadius;
    own_sums.l1 +=
        fabs(static_cast<double>(around.values[0][row][column] - around.values[1][row][column]));
    if (terms == nullptr) return;
    const std::size_t i = std::size_t{plane.first} + shape.index(x, y);
    terms[i] = s.by_a;
    terms[field + i] = s.by_aa;
    terms[2 * field + i] = s.by_ab;
  });
  const MeanSums total{sum_of_block<kSsimBlock>(own_sums.ssim).total,
                       sum_of_block<kSsimBlock>(own_sums.l1).total};
  if (threadIdx.x == 0) sums[blockIdx.x] = total;
}

constexpr unsigned kMeanBlock = 1024;

/// One block.
__global__ void __launch_bounds__(kMeanBlock)
    find_means(const MeanSums* sums, unsigned blocks, double counted, double values, float* ssim,
               float* l1) {
  MeanSums own{0, 0};
  for (unsigned k = threadIdx.x; k < blocks; k += kMeanBlock) {
    own.ssim += sums[k].ssim;
    own.l1 += sums[k].l1;
  }
  const double ssim_sum = sum_of_block<kMeanBlock>(own.ssim).total;
  const double l1_sum = sum_of_block<kMeanBlock>(own.l1).total;
  if (threadIdx.x != 0) return;
  *ssim = static_cast<float>(ssim_sum / counted);
  if (l1 != nullptr) *l1 = static_cast<float>(l1_sum / values);
}

/// One block per 48x16 pixels of a plane.
__global__ void __launch_bounds__(kSsimBlock)
    find_gradient(PlaneShape shape, ComparedPictures compared, std::size_t field,
                  const float* terms, const float* by_ssim, const float* by_l1, double counted,
                  double values, PictureBatch<float> by_a) {
  __shared__ Surroundings<1, 3, 3> around;
  const Plane plane = Plane::of(shape, compared.sizes);
  around.load(shape, [&](int f, int x, int y) {
    return terms[static_cast<std::size_t>(f) * field + plane.first + shape.index(x, y)];
  });
  float blurred[3][kSsimDown];
  around.blur(shape, SameFields{}, blurred);
  const auto weight = static_cast<float>(static_cast<double>(*by_ssim) / counted);
  const float l1_weight =
      by_l1 == nullptr ? 0.0f : static_cast<float>(static_cast<double>(*by_l1) / values);
  for_own_values(shape, [&](int own, int x, int y) {
    const float a = compared.a.at(plane.picture, plane.channel, x, y);
    const float b = compared.b.at(plane.picture, plane.channel, x, y);
    float gradient =
        weight * similarity_by(a, b, blurred[0][own], blurred[1][own], blurred[2][own]);
    if (by_l1 != nullptr) gradient += l1_weight * static_cast<float>((a > b) - (a < b));
    by_a.at(plane.picture, plane.channel, x, y) = gradient;
  });
}

PlaneShape shape_of(const BatchSizes& sizes) {
  return PlaneShape::of_image(sizes.width, sizes.height);
}

unsigned blocks_of(const BatchSizes& sizes) {
  return static_cast<unsigned>(shape_of(sizes).blocks_of_picture) *
         static_cast<unsigned>(sizes.planes());
}

std::size_t field_of(const BatchSizes& sizes) {
  return sizes.planes() * static_cast<std::size_t>(sizes.width) *
         static_cast<std::size_t>(sizes.height);
}

}  // namespace

std::size_t bytes_for_similarity(const BatchSizes& sizes) {
  return blocks_of(sizes) * sizeof(MeanSums);
}

void similarity(const ComparedPictures& compared, const Queue& queue, void* scratch, float* ssim,
                float* l1, float* terms) {
  const BatchSizes& sizes = compared.sizes;
  const unsigned blocks = blocks_of(sizes);
  auto* const sums = static_cast<MeanSums*>(scratch);
  launch("sum_similarity", sum_similarity, Blocks(blocks, kSsimBlock), stream_of(queue),
         shape_of(sizes), compared, field_of(sizes), terms, sums);
  launch("find_means", find_means, Blocks(1, kMeanBlock), stream_of(queue), sums, blocks,
         sizes.counted(), sizes.values(), ssim, l1);
}

void similarity_backward(const ComparedPictures& compared, const float* terms, const float* by_ssim,
                         const float* by_l1, const Queue& queue, const PictureBatch<float>& by_a) {
  const BatchSizes& sizes = compared.sizes;
  launch("find_gradient", find_gradient, Blocks(blocks_of(sizes), kSsimBlock), stream_of(queue),
         shape_of(sizes), compared, field_of(sizes), terms, by_ssim, by_l1, sizes.counted(),
         sizes.values(), by_a);
}

}  // namespace qs::cuda::diff
