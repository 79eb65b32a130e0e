// SPDX-License-Identifier: MIT
//
// The second pass of the differentiable rasterizer on the GPU, as learn/diff/cpu/blend.h:
// composites the listed Gaussians to pictures, and its backward pass, from the pictures to the
// boundary. All pointers are to device memory. Every pair of a tile and a Gaussian gets its own sum
// over the tile's pixels, and a Gaussian's pairs are summed in the order of tiles. So two runs, and
// all lossless modes, give the same bits. Alphas differ from the CPU's by rounding.
#pragma once

#include "learn/diff/cuda/frame.h"
#include "learn/diff/gaussians.h"
#include "learn/gradient/pixel.h"

namespace qs::cuda::diff {

using BlendInput = qs::diff::BlendInput<float>;

/// Draws a frame that list() has filled into its block `pixels`, whose sizes are
/// frame.sizes.blended(in.channel_count, with depths or not), and into all wanted pictures; sets
/// these sizes. Does not wait. Throws Error(usage) if inputs do not fit together, Error(device) and
/// Cancelled.
void blend(const BlendInput& in, const Queue& queue, bool with_depth, Frame& frame,
           const Pictures<float>& out = {});

/// Bytes of scratch memory of blend_backward(), which may be used again after it.
std::size_t bytes_to_blend_backward(const GpuHeldSizes& sizes);

/// `frame` is the result of blend() for the same arguments; `by` are the derivatives by the
/// pictures, each of which may be missing. Writes all rows of the wanted arrays. Does not wait.
/// Throws Error(usage), Error(device) and Cancelled.
void blend_backward(const BlendInput& in, const Frame& frame, const Pictures<const float>& by,
                    const Queue& queue, void* scratch, const BoundaryGradients<float>& out);

/// The sums of each Gaussian over its pixels, which blend_backward() leaves in its scratch memory.
/// The frame must have states.
GaussianSums sums_of_pixels(const Frame& frame, void* scratch);

/// Sets counts.at(i), for each Gaussian of a frame that list() has filled, as count_pixels() of the
/// CPU does. It composites as the CPU does too, so the counts are equal. Does not wait. Throws
/// Error(device) and Cancelled.
void count_pixels(const PixelRules<float>& rules, const Frame& frame, float behind,
                  const Queue& queue, const Rows<std::int32_t>& counts);

}  // namespace qs::cuda::diff
