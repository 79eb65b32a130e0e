// SPDX-License-Identifier: MIT
//
// The backward pass of training: from the loss's derivatives by the pixels to its derivatives by
// all parameters. Every pair of a tile and a Gaussian gets its own sum over the tile's pixels, and
// a Gaussian's pairs are summed in the order of tiles, as on the CPU. No sum depends on the order
// in which threads run, so two runs give the same bits.
// learn/diff/cuda/color_sums.cuh computes the sums.
#pragma once

#include "learn/gradient/pixel.h"
#include "learn/step/cuda/forward.cuh"
#include "learn/step/model_state.h"

namespace qs::cuda::train {

/// Memory of backward() that the next step uses again.
struct BackwardScratch {
  DeviceBuffer<PixelSums<float>> pairs;  ///< per place, see ForwardFrame::pairs
  DeviceBuffer<glm::vec2> absolute;      ///< absolute gradients per pair, if asked for
  DeviceBuffer<PixelSums<float>> sums;   ///< per Gaussian
};

/// `frame` is the result of forward() for the same arguments; `d_color` is per pixel, row by row.
/// With `d_outputs`, which has room for all Gaussians, a colour field computed the colours: they
/// become the derivatives by the outputs of its network, and the coefficients of colour have no
/// derivatives. Does not wait. Throws Cancelled, and Error(device) if memory is short.
void backward(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
              const glm::vec3* d_color, const qs::train::BackwardOrder& order,
              BackwardScratch& scratch, Gradients& gradients, glm::vec3* d_outputs = nullptr);

/// Sets gradients.by.sh, for tests, of a model with coefficients up to `sh_degree`.
void expand_colors(int sh_degree, cudaStream_t stream, Gradients& gradients);

}  // namespace qs::cuda::train
