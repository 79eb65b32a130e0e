// SPDX-License-Identifier: MIT
//
// The scenes and frames of stage_scenes.h in the memory of the GPU.
#pragma once

#include "raster/cuda/stages/project.h"
#include "support/gpu_memory.h"
#include "support/stage_scenes.h"

namespace qs::test {

/// The inputs of a scene on the GPU.
class GpuScene {
 public:
  explicit GpuScene(const StageScene<float>& scene)
      : host_(&scene),
        means_(scene.means),
        scales_(scene.scales),
        rotations_(scene.rotations),
        covariances_(scene.covariances),
        opacities_(scene.opacities),
        sh_(scene.sh),
        channels_(scene.channels) {}

  GaussianInputs<float> inputs() const {
    GaussianInputs<float> in = host_->inputs();
    in.means.data = means_.data();
    if (in.scales) in.scales.data = scales_.data();
    if (in.rotations) in.rotations.data = rotations_.data();
    if (in.covariances) in.covariances.data = covariances_.data();
    in.opacities.data = opacities_.data();
    if (in.channels) in.channels.data = channels_.data();
    if (in.sh) in.sh = ShRows<const float>::packed(sh_.data(), sh_coefficient_count(in.sh_degree));
    return in;
  }

 private:
  const StageScene<float>* host_;
  GpuArray<float> means_, scales_, rotations_, covariances_, opacities_, sh_, channels_;
};

/// BoundaryValues on the GPU.
class GpuBoundary {
 public:
  explicit GpuBoundary(std::size_t count, int channels = 3)
      : mean_px_(2 * count),
        conic_(3 * count),
        depth_(count),
        opacity_(count),
        color_(3 * count),
        absolute_px_(2 * count),
        background_(static_cast<std::size_t>(channels)) {}

  Boundary<float> rows() const {
    return {Rows<float>::packed(mean_px_.data(), 2), Rows<float>::packed(conic_.data(), 3),
            Rows<float>::packed(depth_.data(), 1), Rows<float>::packed(opacity_.data(), 1),
            Rows<float>::packed(color_.data(), 3)};
  }
  Rows<float> absolute_px() const { return Rows<float>::packed(absolute_px_.data(), 2); }
  float* background() const { return background_.data(); }

  BoundaryValues<float> values() const {
    BoundaryValues<float> result(0);
    result.mean_px = mean_px_.values();
    result.conic = conic_.values();
    result.depth = depth_.values();
    result.opacity = opacity_.values();
    result.color = color_.values();
    result.absolute_px = absolute_px_.values();
    result.background = background_.values();
    return result;
  }

 private:
  GpuArray<float> mean_px_, conic_, depth_, opacity_, color_, absolute_px_, background_;
};

/// The first stage of a frame on the GPU.
struct GpuStageFrame {
  GpuMemory gaussians, pairs;
  cuda::stages::Frame frame;

  void project(const DrawnView& view, const GaussianInputs<float>& in,
               const Boundary<float>& out = {}, const Rows<std::int32_t>& radii = {}) {
    using namespace cuda::stages;
    const HeldSizes sizes = HeldSizes::of(view.camera, in.count);
    gaussians = GpuMemory(bytes_per_gaussian(sizes));
    const GpuMemory projected(bytes_to_project(sizes));
    frame.gaussians = gaussians.data();
    cuda::stages::project(view, in, {}, projected.data(), frame, out, radii);
    pairs = GpuMemory(bytes_per_pair(frame.sizes));
    frame.pairs = pairs.data();
    const GpuMemory unsorted(bytes_to_list(frame.sizes));
    list(view, {}, projected.data(), unsorted.data(), frame);
  }
};

}  // namespace qs::test
