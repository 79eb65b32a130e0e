// SPDX-License-Identifier: MIT
//
// The first pass of the differentiable rasterizer on the GPU, as learn/diff/cpu/project.h:
// projects activated Gaussians, lists them in tiles and sorts the lists. Its backward pass goes
// from the boundary to all inputs and to the camera. All pointers are to device memory. Lists,
// radii and which Gaussians have a row are equal to the CPU's. Sums have a fixed order, so two runs
// give the same bits.
#pragma once

#include "learn/diff/cuda/frame.h"
#include "learn/diff/gaussians.h"
#include "learn/diff/rules.h"
#include "learn/gradient/pixel.h"

namespace qs::cuda::diff {

// Bytes of scratch memory, which may be used again after a pass: of project() and of the list()
// after it, of list() alone, and of project_backward() with a pose.
std::size_t bytes_to_project(const GpuHeldSizes& sizes);
std::size_t bytes_to_list(const GpuHeldSizes& sizes);
std::size_t bytes_of_pose(const GpuHeldSizes& sizes);

/// Fills `frame.gaussians`, whose size follows from GpuHeldSizes::of(view.camera, gaussians.count),
/// and all wanted arrays of the boundary. `radii` gets 2 numbers per Gaussian by the rules'
/// formula. Sets `frame.sizes`: the host waits for the number of pairs. Throws Error(usage) for
/// inputs that do not fit together, Error(device) if there are too many pairs, and Cancelled.
void project(const DrawnView& view, const GaussianInputs<float>& gaussians, const Queue& queue,
             void* scratch, Frame& frame, const Boundary<float>& out = {},
             const Rows<std::int32_t>& radii = {});

/// Fills `frame.pairs` after project() for the same view. `projected` is the scratch memory of
/// project(). Does not wait. Throws Error(device) and Cancelled.
void list(const DrawnView& view, const Queue& queue, void* projected, void* scratch,
          const Frame& frame);

/// `frame` is the frame of project() for the same view and Gaussians; `by` are the derivatives by
/// the boundary, each of which may be missing. Writes all rows of the wanted arrays of given
/// inputs: 0 for Gaussians without a row in the boundary. Also writes `pose`, in device memory, if
/// it is not null; its sums are in double precision. `scratch` is only used with a pose. Does not
/// wait. Throws Error(usage), Error(device) and Cancelled.
void project_backward(const DrawnView& view, const GaussianInputs<float>& gaussians,
                      const Frame& frame, const Boundary<const float>& by, const Queue& queue,
                      void* scratch, const InputGradients<float>& out,
                      PoseGradient* pose = nullptr);

/// The same after blend_backward() of a frame with states. `by` is sums_of_pixels(), from which the
/// derivatives by the boundary follow: no rows of them are written.
void project_backward_of_sums(const DrawnView& view, const GaussianInputs<float>& gaussians,
                              const Frame& frame, const GaussianSums& by, const Queue& queue,
                              void* scratch, const InputGradients<float>& out,
                              PoseGradient* pose = nullptr);

}  // namespace qs::cuda::diff
