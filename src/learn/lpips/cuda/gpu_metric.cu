// SPDX-License-Identifier: MIT
//
// A feature map holds both pictures: (picture, row, column, channel). A convolution is a product of
// matrices, (pixels, inputs below a filter) times (inputs below a filter, outputs), of which the
// first is never written: a block reads its part from the feature map.
#include <algorithm>
#include <numeric>
#include <vector>

#include "learn/lpips/convolve.h"
#include "learn/lpips/cuda/gpu_metric.h"
#include "raster/cuda/common/gpu_info.h"
#include "raster/cuda/common/stream.cuh"
#include "raster/cuda/common/warp.cuh"

namespace qs::cuda::lpips {
namespace {

using qs::lpips::Convolution;
using qs::lpips::InputRange;
using qs::lpips::kBlock;

// A block computes a tile of pixels and outputs, in steps over kTileInputs inputs. A thread
// computes kThreadPixels consecutive pixels and kThreadOutputs consecutive outputs.
constexpr unsigned kTilePixels = 128, kTileOutputs = 64, kTileInputs = 16;
constexpr unsigned kThreadPixels = 8, kThreadOutputs = 4;
constexpr unsigned kRun = 8;      // consecutive inputs that a thread loads for a pixel
constexpr unsigned kPadding = 4;  // floats between rows of shared memory, against bank conflicts
static_assert(kTilePixels * kTileOutputs == kThreads * kThreadPixels * kThreadOutputs);
static_assert(kTilePixels * kTileInputs == kThreads * kRun);
static_assert(kTileInputs * kTileOutputs == kThreads * kThreadOutputs);

constexpr unsigned kCompareBlocks = 1024;
constexpr unsigned kCompareWarps = kCompareBlocks * kThreads / kWarp;

struct alignas(16) Four {
  float v[4];
};

/// Both pictures' feature maps.
struct Maps {
  int width, height, channels;

  __host__ __device__ std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  __host__ __device__ std::size_t size() const {
    return 2 * pixels() * static_cast<std::size_t>(channels);
  }
};

struct ConvolutionInput {
  Maps in, out;
  int size, stride, padding;
  const float* values;
  const float* filters;  ///< (outputs / kBlock, inputs below a filter, kBlock)
  const float* biases;
};

/// The inputs below the filter of one output pixel.
struct Patch {
  int row, column;  ///< row and column of the first input; the column in floats
  const float* picture;

  __device__ static Patch of(const ConvolutionInput& c, std::size_t pixel) {
    const std::size_t side = pixel / c.out.pixels(), rest = pixel % c.out.pixels();
    const int y = static_cast<int>(rest / static_cast<std::size_t>(c.out.width));
    const int x = static_cast<int>(rest % static_cast<std::size_t>(c.out.width));
    return {y * c.stride - c.padding, (x * c.stride - c.padding) * c.in.channels,
            c.values + side * c.in.pixels() * static_cast<std::size_t>(c.in.channels)};
  }

  /// Input `i` of filter row `filter_row`; 0 outside of the picture.
  __device__ float at(const ConvolutionInput& c, int filter_row, int i) const {
    const int y = row + filter_row, x = column + i, length = c.in.width * c.in.channels;
    const bool inside = y >= 0 && y < c.in.height && x >= 0 && x < length;
    return inside ? picture[static_cast<std::size_t>(y) * static_cast<std::size_t>(length) +
                            static_cast<std::size_t>(x)]
                  : 0.0f;
  }
};

/// Convolution, bias and ReLU. A block per tile.
__global__ void __launch_bounds__(kThreads) convolve(ConvolutionInput c, float* out) {
  __shared__ Four patches[kTileInputs][(kTilePixels + kPadding) / 4];
  __shared__ Four weights[kTileInputs][kTileOutputs / 4];
  const int run = c.size * c.in.channels, inputs = c.size * run;
  const auto outputs = static_cast<unsigned>(c.out.channels);
  const unsigned tiles = (outputs + kTileOutputs - 1) / kTileOutputs;
  const unsigned first_output = blockIdx.x % tiles * kTileOutputs;
  const std::size_t first_pixel = static_cast<std::size_t>(blockIdx.x / tiles) * kTilePixels;
  const std::size_t pixels = 2 * c.out.pixels();

  // The parts that this thread loads.
  const unsigned load_pixel = threadIdx.x % kTilePixels, load_run = threadIdx.x / kTilePixels;
  const std::size_t patch_pixel = first_pixel + load_pixel;
  const bool has_patch = patch_pixel < pixels;
  const Patch patch = Patch::of(c, has_patch ? patch_pixel : 0);
  const unsigned load_input = threadIdx.x / (kTileOutputs / 4);
  const unsigned load_output = threadIdx.x % (kTileOutputs / 4) * 4;
  const unsigned weight_output = first_output + load_output;
  const float* const weight =
      c.filters +
      static_cast<std::size_t>(weight_output / kBlock) * static_cast<std::size_t>(inputs) * kBlock +
      weight_output % kBlock;

  // The part that it computes.
  const unsigned own_output = threadIdx.x % (kTileOutputs / kThreadOutputs) * kThreadOutputs;
  const unsigned own_pixel = threadIdx.x / (kTileOutputs / kThreadOutputs) * kThreadPixels;
  float sums[kThreadPixels][kThreadOutputs];
  for (unsigned o = 0; o < kThreadOutputs; ++o) {
    const unsigned output = first_output + own_output + o;
    const float bias = output < outputs ? c.biases[output] : 0.0f;
    for (unsigned p = 0; p < kThreadPixels; ++p) sums[p][o] = bias;
  }

  for (int first = 0; first < inputs; first += static_cast<int>(kTileInputs)) {
    float* const column = &patches[0][0].v[0] + load_pixel;
    const int load_first = first + static_cast<int>(load_run * kRun);
    int filter_row = load_first / run, i = load_first % run;
#pragma unroll
    for (unsigned k = 0; k < kRun; ++k) {
      const bool exists = has_patch && filter_row < c.size;
      column[(load_run * kRun + k) * (kTilePixels + kPadding)] =
          exists ? patch.at(c, filter_row, i) : 0.0f;
      if (++i == run) {
        i = 0;
        ++filter_row;
      }
    }
    const int input = first + static_cast<int>(load_input);
    weights[load_input][load_output / 4] =
        input < inputs && weight_output < outputs
            ? *reinterpret_cast<const Four*>(weight + static_cast<std::size_t>(input) * kBlock)
            : Four{};
    __syncthreads();
#pragma unroll
    for (unsigned k = 0; k < kTileInputs; ++k) {
      const Four low = patches[k][own_pixel / 4], high = patches[k][own_pixel / 4 + 1];
      const Four w = weights[k][own_output / 4];
#pragma unroll
      for (unsigned p = 0; p < kThreadPixels; ++p) {
        const float value = p < 4 ? low.v[p % 4] : high.v[p % 4];
#pragma unroll
        for (unsigned o = 0; o < kThreadOutputs; ++o) sums[p][o] = fmaf(value, w.v[o], sums[p][o]);
      }
    }
    __syncthreads();
  }

  if (first_output + own_output >= outputs) return;
  for (unsigned p = 0; p < kThreadPixels; ++p) {
    const std::size_t pixel = first_pixel + own_pixel + p;
    if (pixel >= pixels) break;
    Four result;
    for (unsigned o = 0; o < kThreadOutputs; ++o) result.v[o] = fmaxf(sums[p][o], 0.0f);
    *reinterpret_cast<Four*>(out + pixel * outputs + first_output + own_output) = result;
  }
}

/// The maximum of size x size values at every second pixel.
void pool(const Maps& in, const Maps& out, int size, const float* values, float* result,
          cudaStream_t stream) {
  for_each_item("pool", out.size(), stream, [=] __device__(std::size_t i) {
    const auto channels = static_cast<std::size_t>(out.channels);
    const std::size_t channel = i % channels, pixel = i / channels % out.pixels();
    const std::size_t side = i / channels / out.pixels();
    const auto width = static_cast<std::size_t>(out.width);
    const std::size_t x = 2 * (pixel % width), y = 2 * (pixel / width);
    float largest = 0;  // a ReLU comes before
    for (std::size_t row = 0; row < static_cast<std::size_t>(size); ++row) {
      for (std::size_t column = 0; column < static_cast<std::size_t>(size); ++column) {
        const std::size_t from =
            side * in.pixels() + (y + row) * static_cast<std::size_t>(in.width) + x + column;
        largest = fmaxf(largest, values[from * channels + channel]);
      }
    }
    result[i] = largest;
  });
}

__device__ double sum_of_warp(double value) {
  for (unsigned distance = kWarp / 2; distance > 0; distance /= 2)
    value += __shfl_sync(kAllLanes, value, lane_index() ^ distance);
  return value;
}

/// One warp per pixel, in turns: the sum of lin (f/|f| - g/|g|)^2. A warp writes the sum of its
/// pixels.
__global__ void __launch_bounds__(kThreads)
    compare(Maps maps, const float* values, const float* lin, double* sums) {
  const unsigned warp = (blockIdx.x * blockDim.x + threadIdx.x) / kWarp, lane = lane_index();
  const auto channels = static_cast<std::size_t>(maps.channels);
  double sum = 0;
  for (std::size_t pixel = warp; pixel < maps.pixels(); pixel += kCompareWarps) {
    const float* const f = values + pixel * channels;
    const float* const g = f + maps.pixels() * channels;
    double ff = 0, gg = 0;
    for (std::size_t c = lane; c < channels; c += kWarp) {
      const double of_f = static_cast<double>(f[c]), of_g = static_cast<double>(g[c]);
      ff += of_f * of_f;
      gg += of_g * of_g;
    }
    const double scale_f = 1 / (sqrt(sum_of_warp(ff)) + 1e-10);
    const double scale_g = 1 / (sqrt(sum_of_warp(gg)) + 1e-10);
    for (std::size_t c = lane; c < channels; c += kWarp) {
      const double difference =
          static_cast<double>(f[c]) * scale_f - static_cast<double>(g[c]) * scale_g;
      sum += static_cast<double>(lin[c]) * difference * difference;
    }
  }
  sum = sum_of_warp(sum);
  if (lane == 0) sums[warp] = sum;
}

constexpr const char* kWhat = "the features of LPIPS";

}  // namespace

struct GpuMetric::State {
  State(const qs::lpips::Network& network_, int device_)
      : network(network_), device(device_), stream(device_, true) {}

  const qs::lpips::Network& network;
  int device;
  Stream stream;  // selects the GPU
  std::vector<DeviceBuffer<float>> filters, biases, linear;
  DeviceBuffer<float> maps, next;
  DeviceBuffer<double> sums;
};

GpuMetric::GpuMetric(const qs::lpips::Weights& weights, int device) {
  require_gpu(device);
  state_ = std::make_unique<State>(*weights.network, device);
  State& s = *state_;
  std::vector<std::vector<float>> packed;
  for (std::size_t i = 0; i < weights.filters.size(); ++i) {
    packed.push_back(qs::lpips::pack(s.network.convolutions[i], weights.filters[i]));
    copy_to_device("the filters of LPIPS", packed.back(), s.filters.emplace_back(), s.stream);
    copy_to_device("the biases of LPIPS", weights.biases[i], s.biases.emplace_back(), s.stream);
  }
  for (const std::vector<float>& linear : weights.linear)
    copy_to_device("the weights of LPIPS", linear, s.linear.emplace_back(), s.stream);
  s.sums.reserve("the sums of LPIPS", kCompareWarps);
  check(cudaStreamSynchronize(s.stream), "the weights of LPIPS");
}

GpuMetric::~GpuMetric() = default;

double GpuMetric::distance(const Image& a, const Image& b, InputRange range) {
  State& s = *state_;
  check(cudaSetDevice(s.device), "cudaSetDevice");
  Maps maps{a.width, a.height, 3};
  s.maps.reserve(kWhat, maps.size());
  s.next.reserve(kWhat, maps.size());
  const Image* const images[] = {&a, &b};
  for (std::size_t side = 0; side < 2; ++side)
    check(cudaMemcpyAsync(s.next.data() + side * maps.size() / 2, images[side]->values.data(),
                          maps.size() / 2 * sizeof(float), cudaMemcpyHostToDevice, s.stream),
          "the pictures of LPIPS");
  for_each_item("scale_input", maps.size(), s.stream,
                [in = s.next.data(), symmetric = range == InputRange::symmetric,
                 out = s.maps.data()] __device__(std::size_t i) {
                  constexpr double kShift[] = {-.030, -.088, -.188}, kScale[] = {.458, .448, .450};
                  const double unit = static_cast<double>(in[i]);
                  const double value = symmetric ? 2 * unit - 1 : unit;
                  out[i] = static_cast<float>((value - kShift[i % 3]) / kScale[i % 3]);
                });
  double distance = 0;
  std::size_t number = 0, compared = 0;
  for (const Convolution& layer : s.network.convolutions) {
    if (layer.pooled_before) {
      const int size = s.network.pool_size;
      const Maps pooled{(maps.width - size) / qs::lpips::kPoolStride + 1,
                        (maps.height - size) / qs::lpips::kPoolStride + 1, maps.channels};
      s.next.reserve(kWhat, pooled.size());
      pool(maps, pooled, size, s.maps.data(), s.next.data(), s.stream);
      s.maps.swap(s.next);
      maps = pooled;
    }
    const Maps out{layer.side_of(maps.width), layer.side_of(maps.height), layer.outputs};
    s.next.reserve(kWhat, out.size());
    const ConvolutionInput input{maps,
                                 out,
                                 layer.size,
                                 layer.stride,
                                 layer.padding,
                                 s.maps.data(),
                                 s.filters[number].data(),
                                 s.biases[number].data()};
    const std::size_t tiles =
        (2 * out.pixels() + kTilePixels - 1) / kTilePixels *
        ((static_cast<unsigned>(out.channels) + kTileOutputs - 1) / kTileOutputs);
    launch("convolve", convolve, static_cast<unsigned>(tiles), s.stream, input, s.next.data());
    s.maps.swap(s.next);
    maps = out;
    ++number;
    if (!layer.compared) continue;
    launch("compare", compare, kCompareBlocks, s.stream, maps, s.maps.data(),
           s.linear[compared++].data(), s.sums.data());
    const std::vector<double> sums = copied(s.sums.data(), kCompareWarps, s.stream);
    distance += std::accumulate(sums.begin(), sums.end(), 0.0) / static_cast<double>(maps.pixels());
  }
  return distance;
}

}  // namespace qs::cuda::lpips
