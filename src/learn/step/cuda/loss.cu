// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cassert>

#include "learn/step/cuda/loss.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/ssim.h"
#include "raster/scene/image_metrics.h"

namespace qs::cuda::train {
namespace {

constexpr int kChannels = 3;

constexpr int kSide = 16;                // of the pixels of a block
constexpr int kRow = kSide * kChannels;  // values in a row of a block
constexpr int kMargin = kSsimRadius * kChannels;
constexpr int kWideRow = kRow + 2 * kMargin;  // with the values around them that the window reaches
constexpr int kHighSide = kSide + 2 * kSsimRadius;

// A thread computes a run of neighbours of one channel, because they share most of their inputs:
// first kAlong along a row, then kDown down a column.
constexpr int kAlong = 8, kDown = 4;
constexpr unsigned kBlock = kRow * kSide / kDown;  // threads
static_assert(kSide % kAlong == 0 && kHighSide * kRow / kAlong <= int{kBlock});

/// A picture as rows of values, with the channels of a pixel side by side.
struct Shape {
  int row;                  ///< values in a row
  int height;               ///< rows
  int columns;              ///< blocks side by side
  float window[kSsimSize];  ///< weights along one axis

  static Shape of_image(int width, int height) {
    Shape shape{width * kChannels, height, (width + kSide - 1) / kSide, {}};
    const auto weights = ssim_window();
    for (int k = 0; k < kSsimSize; ++k) assert(weights[k] == weights[kSsimSize - 1 - k]);
    std::copy(weights.begin(), weights.end(), shape.window);
    return shape;
  }

  std::uint32_t count() const { return static_cast<std::uint32_t>(row * height); }
  unsigned blocks() const {
    return static_cast<unsigned>(columns * ((height + kSide - 1) / kSide));
  }

  // Of the first value of the running block.
  __device__ int left() const { return static_cast<int>(blockIdx.x) % columns * kRow; }
  __device__ int top() const { return static_cast<int>(blockIdx.x) / columns * kSide; }

  __device__ bool contains(int x, int y) const { return x >= 0 && x < row && y >= 0 && y < height; }
};

/// Values of a block and the values around them that the window reaches, in shared memory. They are
/// zero outside of the picture. Rows have odd lengths, so that a column is in all memory banks.
template <int kFields, int kMoments>
struct Surroundings {
  float values[kFields][kHighSide][kWideRow + 1];
  float rows[kMoments][kHighSide][kRow + 1];  ///< moments, blurred along the rows

  /// Sets every value of every field f: value_at(f, i) of the picture. A barrier must follow.
  template <class ValueAt>
  __device__ void load(const Shape& shape, const ValueAt& value_at) {
    for (int n = static_cast<int>(threadIdx.x); n < kHighSide * kWideRow; n += int{kBlock}) {
      const int x = shape.left() + n % kWideRow - kMargin;
      const int y = shape.top() + n / kWideRow - kSsimRadius;
      const bool inside = shape.contains(x, y);
      for (int f = 0; f < kFields; ++f)
        values[f][n / kWideRow][n % kWideRow] =
            inside ? value_at(f, static_cast<std::uint32_t>(y * shape.row + x)) : 0.0f;
    }
  }

  /// Convolves the moments with the window, for the thread's kDown values. set(in, out) computes
  /// the moments of a value from its fields. The order of the sums is the CPU's. All threads call
  /// it.
  template <class Set>
  __device__ void blur(const Shape& shape, const Set& set, float (&sums)[kMoments][kDown]) {
    __syncthreads();
    blur_along_rows(shape, set);
    __syncthreads();
    const int x = own_column(), top = own_top();
    clear(sums);
#pragma unroll
    for (int j = 0; j < kDown + kSsimSize - 1; ++j) {
      float moments[kMoments];
#pragma unroll
      for (int m = 0; m < kMoments; ++m) moments[m] = rows[m][top + j][x];
      add_to_run(shape, j, moments, sums);
    }
  }

  static __device__ int own_column() { return static_cast<int>(threadIdx.x) % kRow; }
  static __device__ int own_top() { return static_cast<int>(threadIdx.x) / kRow * kDown; }

 private:
  template <int kRun>
  static __device__ void clear(float (&sums)[kMoments][kRun]) {
#pragma unroll
    for (int m = 0; m < kMoments; ++m)
#pragma unroll
      for (int own = 0; own < kRun; ++own) sums[m][own] = 0;
  }

  /// Adds input j of a run to the sums that it belongs to.
  template <int kRun>
  static __device__ void add_to_run(const Shape& shape, int j, const float (&moments)[kMoments],
                                    float (&sums)[kMoments][kRun]) {
#pragma unroll
    for (int own = 0; own < kRun; ++own) {
      const int k = j - own;
      if (k < 0 || k >= kSsimSize) continue;
      // The window is symmetric, so a product with a weight serves two sums.
      const float weight = shape.window[k <= kSsimRadius ? k : kSsimSize - 1 - k];
#pragma unroll
      for (int m = 0; m < kMoments; ++m) sums[m][own] += weight * moments[m];
    }
  }

  template <class Set>
  __device__ void blur_along_rows(const Shape& shape, const Set& set) {
    const int n = static_cast<int>(threadIdx.x);
    if (n >= kHighSide * kRow / kAlong) return;
    const int y = n % kHighSide, run = n / kHighSide;
    const int begin = run / kChannels * kAlong * kChannels + run % kChannels;
    float sums[kMoments][kAlong];
    clear(sums);
#pragma unroll
    for (int j = 0; j < kAlong + kSsimSize - 1; ++j) {
      float in[kFields], moments[kMoments];
#pragma unroll
      for (int f = 0; f < kFields; ++f) in[f] = values[f][y][begin + j * kChannels];
      set(in, moments);
      add_to_run(shape, j, moments, sums);
    }
#pragma unroll
    for (int m = 0; m < kMoments; ++m)
#pragma unroll
      for (int own = 0; own < kAlong; ++own) rows[m][y][begin + own * kChannels] = sums[m][own];
  }
};

/// Calls visit(k, i) for the thread's values inside the picture: k counts them, i is the index.
template <class Visit>
__device__ void for_own_values(const Shape& shape, const Visit& visit) {
  const int n = static_cast<int>(threadIdx.x);
#pragma unroll
  for (int own = 0; own < kDown; ++own) {
    const int x = shape.left() + n % kRow, y = shape.top() + n / kRow * kDown + own;
    if (shape.contains(x, y)) visit(own, static_cast<std::uint32_t>(y * shape.row + x));
  }
}

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

/// One block per 16x16 pixels: SSIM, summed over the block, and its derivatives per value.
__global__ void __launch_bounds__(kBlock)
    measure_similarity(Shape shape, Pictures pictures, Derivatives derivatives, LossSums* sums) {
  __shared__ Surroundings<2, 5> around;
  around.load(shape, [&](int f, std::uint32_t i) {
    if (pictures.masks(i)) return 0.0f;
    return f == 0 ? shown(pictures.color[i]) : pictures.target[i];
  });
  float moments[5][kDown];
  const auto products = [](const float(&in)[2], float(&out)[5]) {
    const float a = in[0], b = in[1];
    out[0] = a;
    out[1] = b;
    out[2] = a * a;
    out[3] = b * b;
    out[4] = a * b;
  };
  around.blur(shape, products, moments);
  double value = 0;
  for_own_values(shape, [&](int own, std::uint32_t i) {
    Similarity<float> s{};
    if (!pictures.masks(i)) {
      s = Similarity<float>::of(moments[0][own], moments[1][own], moments[2][own], moments[3][own],
                                moments[4][own]);
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
  around.load(shape,
              [&](int f, std::uint32_t i) { return derivatives.values[f * derivatives.size + i]; });
  float blurred[3][kDown];
  const auto same = [](const float(&in)[3], float(&out)[3]) {
    for (int f = 0; f < 3; ++f) out[f] = in[f];
  };
  around.blur(shape, same, blurred);
  double l1 = 0, squared = 0;
  for_own_values(shape, [&](int own, std::uint32_t i) {
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

void copy_bytes(std::span<const std::uint8_t> from, DeviceBuffer<std::uint8_t>& to,
                cudaStream_t stream) {
  to.reserve("a photograph", from.size());
  if (from.empty()) return;
  check(cudaMemcpyAsync(to.data(), from.data(), from.size(), cudaMemcpyHostToDevice, stream),
        "copy to the GPU");
}

}  // namespace

void compare(const Comparison& pictures, cudaStream_t stream, LossScratch& scratch,
             DeviceBuffer<glm::vec3>& d_color) {
  const Shape shape = Shape::of_image(pictures.width, pictures.height);
  const std::uint32_t count = shape.count();
  const unsigned blocks = shape.blocks();
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
  copy_bytes(host.rgb, rgb, stream);
  copy_bytes(host.alpha, alpha, stream);
  copy_bytes(host.mask, mask, stream);
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
