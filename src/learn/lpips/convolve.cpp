// SPDX-License-Identifier: MIT
#include "learn/lpips/convolve.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "learn/lpips/convolve.cpp"
#include "base/simd.h"

HWY_BEFORE_NAMESPACE();
namespace qs::lpips {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

constexpr int kVectors = 2;  // of output channels
#if HWY_TARGET <= HWY_AVX3   // 32 registers
constexpr int kPixels = 12;
#else
constexpr int kPixels = 6;
#endif

/// `kCount` pixels from pixel x on, kVectors vectors of outputs from `output` on. All sums stay in
/// registers.
template <int kCount>
HWY_INLINE void convolve_pixels(const RowBlock& block, int x, std::size_t output) {
  const D d;
  const std::size_t lanes = hn::Lanes(d), step = block.step;
  V sum[kCount][kVectors];
  for (int v = 0; v < kVectors; ++v) {
    const V bias = hn::LoadU(d, block.bias + output + static_cast<std::size_t>(v) * lanes);
    for (int p = 0; p < kCount; ++p) sum[p][v] = bias;
  }
  for (int row = 0; row < block.row_count; ++row) {
    if (block.rows[row] == nullptr) continue;
    const float* weights =
        block.weights + static_cast<std::size_t>(row) * block.run * kBlock + output;
    const float* in = block.rows[row] + static_cast<std::size_t>(x) * step;
    for (std::size_t i = 0; i < block.run; ++i, ++in, weights += kBlock) {
      V weight[kVectors];
      for (int v = 0; v < kVectors; ++v)
        weight[v] = hn::LoadU(d, weights + static_cast<std::size_t>(v) * lanes);
      for (int p = 0; p < kCount; ++p) {
        const V value = hn::Set(d, in[static_cast<std::size_t>(p) * step]);
        for (int v = 0; v < kVectors; ++v) sum[p][v] = hn::MulAdd(value, weight[v], sum[p][v]);
      }
    }
  }
  for (int p = 0; p < kCount; ++p) {
    float* out = block.out + static_cast<std::size_t>(x + p) * block.out_step + output;
    for (int v = 0; v < kVectors; ++v)
      hn::StoreU(hn::Max(sum[p][v], hn::Zero(d)), d, out + static_cast<std::size_t>(v) * lanes);
  }
}

void convolve_block(const RowBlock& block) {
  const std::size_t outputs = kVectors * hn::Lanes(D());
  for (std::size_t output = 0; output < kBlock; output += outputs) {
    int x = 0;
    for (; x + kPixels <= block.width; x += kPixels) convolve_pixels<kPixels>(block, x, output);
    for (; x + 4 <= block.width; x += 4) convolve_pixels<4>(block, x, output);
    for (; x + 2 <= block.width; x += 2) convolve_pixels<2>(block, x, output);
    for (; x < block.width; ++x) convolve_pixels<1>(block, x, output);
  }
}

// The sums have eight parts each, which the compiler keeps in vectors.
constexpr std::size_t kParts = 8;

HWY_INLINE double added(const double* parts) {
  double sum = 0;
  for (std::size_t i = 0; i < kParts; ++i) sum += parts[i];
  return sum;
}

HWY_INLINE double inverse_length(const float* values, std::size_t count) {
  double parts[kParts] = {};
  for (std::size_t c = 0; c < count; c += kParts) {
    for (std::size_t i = 0; i < kParts; ++i) {
      const double value = static_cast<double>(values[c + i]);
      parts[i] += value * value;
    }
  }
  return 1 / (std::sqrt(added(parts)) + 1e-10);
}

double row_distance(const float* f, const float* g, const float* lin, int width,
                    std::size_t channels) {
  double sum = 0;
  for (int x = 0; x < width; ++x, f += channels, g += channels) {
    const double of_f = inverse_length(f, channels), of_g = inverse_length(g, channels);
    double parts[kParts] = {};
    for (std::size_t c = 0; c < channels; c += kParts) {
      for (std::size_t i = 0; i < kParts; ++i) {
        const double difference =
            static_cast<double>(f[c + i]) * of_f - static_cast<double>(g[c + i]) * of_g;
        parts[i] += static_cast<double>(lin[c + i]) * difference * difference;
      }
    }
    sum += added(parts);
  }
  return sum;
}

}  // namespace HWY_NAMESPACE
}  // namespace qs::lpips
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace qs::lpips {

HWY_EXPORT(convolve_block);
HWY_EXPORT(row_distance);

void convolve(const RowBlock& block) { HWY_DYNAMIC_DISPATCH(convolve_block)(block); }

double feature_distance(const float* f, const float* g, const float* lin, int width,
                        std::size_t channels) {
  return HWY_DYNAMIC_DISPATCH(row_distance)(f, g, lin, width, channels);
}

}  // namespace qs::lpips
#endif
