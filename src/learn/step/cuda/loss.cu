// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>

#include "learn/diff/cuda/ssim_block.cuh"
#include "learn/step/cuda/loss.cuh"
#include "raster/cuda/common/warp.cuh"

namespace qs::cuda::train {
namespace {

using diff::for_own_values;

constexpr int kChannels = 3;
using Shape = diff::SsimShape<kChannels>;
constexpr unsigned kBlock = diff::kSsimBlock;

/// The two pictures, value by value.
struct Pictures {
  const float *color, *target;
  const std::uint8_t* mask;

  __device__ bool masks(std::uint32_t i) const {
    return mask != nullptr && mask[i / kChannels] == 0;
  }
};

/// Derivatives of SSIM by the moments: three fields of a value per value of the picture.
struct Derivatives {
  float* values;
  std::uint32_t size;  ///< size of a field
};

/// Values that one block needs.
template <int kFields, int kMoments>
using Surroundings = diff::Surroundings<kChannels, kFields, kMoments>;

/// One block per 16x16 pixels: SSIM, summed over the block, and its derivatives per value.
__global__ void __launch_bounds__(kBlock)
    measure_similarity(Shape shape, Pictures pictures, Derivatives derivatives, LossSums* sums) {
  __shared__ Surroundings<2, 5> around;
  around.load(shape, [&](int f, int x, int y) {
    const std::uint32_t i = shape.index(x, y);
    if (pictures.masks(i)) return 0.0f;
    return f == 0 ? shown(pictures.color[i]) : pictures.target[i];
  });
  float moments[5][diff::kSsimDown];
  around.blur(shape, diff::SsimMoments{}, moments);
  double value = 0;
  for_own_values(shape, [&](int own, int x, int y) {
    const std::uint32_t i = shape.index(x, y);
    Similarity<float> s{};
    if (!pictures.masks(i)) {
      s = diff::similarity_of(moments, own);
      value += static_cast<double>(s.value);
    }
    derivatives.values[i] = s.by_a;
    derivatives.values[derivatives.size + i] = s.by_aa;
    derivatives.values[2 * derivatives.size + i] = s.by_ab;
  });
  const double total = sum_of_block<kBlock>(value).total;
  if (threadIdx.x == 0) sums[blockIdx.x].ssim = total;
}

/// One block per 16x16 pixels: the gradient, and the differences of the pictures, summed over the
/// block.
__global__ void __launch_bounds__(kBlock)
    loss_gradients(Shape shape, Pictures pictures, Derivatives derivatives,
                   LossGradient<float> gradient, float* d_color, LossSums* sums) {
  __shared__ Surroundings<3, 3> around;
  around.load(shape, [&](int f, int x, int y) {
    return derivatives.values[f * derivatives.size + shape.index(x, y)];
  });
  float blurred[3][diff::kSsimDown];
  around.blur(shape, diff::SameFields{}, blurred);
  double l1 = 0, squared = 0;
  for_own_values(shape, [&](int own, int x, int y) {
    const std::uint32_t i = shape.index(x, y);
    d_color[i] = 0;
    if (pictures.masks(i)) return;
    const float a = pictures.color[i], b = pictures.target[i];
    d_color[i] = gradient.by(a, b, blurred[0][own], blurred[1][own], blurred[2][own]);
    l1 += fabs(static_cast<double>(shown(a) - b));
    const double difference = static_cast<double>(shown(a)) - static_cast<double>(b);
    squared += difference * difference;
  });
  const double l1_total = sum_of_block<kBlock>(l1).total;
  const double squared_total = sum_of_block<kBlock>(squared).total;
  if (threadIdx.x == 0) {
    sums[blockIdx.x].l1 = l1_total;
    sums[blockIdx.x].squared_error = squared_total;
  }
}

/// One block.
__global__ void __launch_bounds__(kThreads)
    add_blocks(const LossSums* sums, std::uint32_t blocks, LossSums* result) {
  LossSums own{0, 0, 0};
  for (std::uint32_t k = threadIdx.x; k < blocks; k += kThreads) {
    own.l1 += sums[k].l1;
    own.ssim += sums[k].ssim;
    own.squared_error += sums[k].squared_error;
  }
  const LossSums total{sum_of_block<kThreads>(own.l1).total, sum_of_block<kThreads>(own.ssim).total,
                       sum_of_block<kThreads>(own.squared_error).total};
  if (threadIdx.x == 0) *result = total;
}

}  // namespace

void compare(const Comparison& pictures, cudaStream_t stream, LossScratch& scratch,
             DeviceBuffer<glm::vec3>& d_color) {
  const Shape shape = Shape::of_image(pictures.width, pictures.height);
  const std::uint32_t count = shape.count();
  const auto blocks = static_cast<unsigned>(shape.blocks_of_picture);
  scratch.derivatives.reserve("the loss", std::size_t{3} * count);
  scratch.of_blocks.reserve("the loss", blocks);
  scratch.of_image.reserve("the loss", 1);
  scratch.blocks = blocks;
  d_color.reserve("the loss", count / kChannels);
  const Pictures values{reinterpret_cast<const float*>(pictures.color),
                        reinterpret_cast<const float*>(pictures.target), pictures.mask};
  const Derivatives derivatives{scratch.derivatives.data(), count};
  LossSums* const sums = scratch.of_blocks.data();
  const Blocks launched(blocks, kBlock);
  launch("measure_similarity", measure_similarity, launched, stream, shape, values, derivatives,
         sums);
  launch("loss_gradients", loss_gradients, launched, stream, shape, values, derivatives,
         LossGradient<float>::of(kChannels * static_cast<double>(pictures.counted)),
         reinterpret_cast<float*>(d_color.data()), sums);
}

void LossCopy::begin(LossScratch& scratch, double values, cudaStream_t stream) {
  launch("add_blocks", add_blocks, 1u, stream, scratch.of_blocks.data(), scratch.blocks,
         scratch.of_image.data());
  values_ = values;
  check(cudaMemcpyAsync(&*sums_, scratch.of_image.data(), sizeof(LossSums), cudaMemcpyDeviceToHost,
                        stream),
        "the loss");
  arrived_.record(stream);
}

Loss LossCopy::wait() {
  arrived_.wait();
  return Loss::of_sums(sums_->l1, sums_->ssim, sums_->squared_error, values_);
}

void DevicePhotograph::upload(const qs::train::Photograph& host, cudaStream_t stream) {
  pixels = 0;
  has_alpha = !host.alpha.empty();
  has_mask = !host.mask.empty();
  const std::size_t size = host.rgb.size() / 3;
  assert(!has_alpha || host.alpha.size() == size);
  assert(!has_mask || host.mask.size() == size);
  copy_to_device("a photograph", host.rgb, rgb, stream);
  copy_to_device("a photograph", host.alpha, alpha, stream);
  copy_to_device("a photograph", host.mask, mask, stream);
  check(cudaStreamSynchronize(stream), "copy to the GPU");
  pixels = size;
  counted = size - static_cast<std::size_t>(
                       std::count(host.mask.begin(), host.mask.end(), std::uint8_t{0}));
}

void DevicePhotograph::over(const glm::vec3& background, cudaStream_t stream,
                            DeviceBuffer<glm::vec3>& target) const {
  target.reserve("the step's image", pixels);
  for_each_item("draw_photograph", static_cast<std::uint32_t>(pixels), stream,
                [=, rgb = rgb.data(), alpha = has_alpha ? alpha.data() : nullptr,
                 target = target.data()] __device__(std::uint32_t i) {
                  glm::vec3 color = photograph_color(rgb + std::size_t{3} * i);
                  if (alpha != nullptr) color += background_behind(alpha[i], background);
                  target[i] = color;
                });
}

}  // namespace qs::cuda::train
