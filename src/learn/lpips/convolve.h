// SPDX-License-Identifier: MIT
//
// The inner loops of LPIPS, in vectors. Every output value is a sum in a fixed order, so results do
// not depend on the number of threads. Instruction sets without fused multiply-add differ in the
// last bits.
#pragma once

#include <cstddef>

namespace qs::lpips {

inline constexpr std::size_t kBlock = 32;  ///< output channels that are computed together

/// One row of pixels and one block of output channels of a convolution. Channels of a pixel are
/// interleaved, so the values of one input row below a filter are `run` consecutive floats.
struct RowBlock {
  const float* const* rows;  ///< `row_count` input rows, at the first pixel's filter; null: zeros
  int row_count;             ///< side of the filter
  std::size_t run;           ///< side of the filter * input channels
  std::size_t step;          ///< floats from a pixel's first input to the next pixel's
  const float* weights;      ///< (row_count, run, kBlock)
  const float* bias;         ///< kBlock values
  int width;                 ///< output pixels
  float* out;                ///< the first pixel's block
  std::size_t out_step;      ///< output channels of a pixel
};

/// Convolution, bias and ReLU.
void convolve(const RowBlock& block);

/// The sum over pixels of lin * (f/|f| - g/|g|)^2, for rows of `width` pixels with `channels`
/// interleaved values, a multiple of 8. |f| has 1e-10 added to it.
double feature_distance(const float* f, const float* g, const float* lin, int width,
                        std::size_t channels);

}  // namespace qs::lpips
