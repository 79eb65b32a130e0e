// SPDX-License-Identifier: MIT
//
// The scenes and frames of stage_scenes.h in the memory of the GPU.
#pragma once

#include "learn/diff/cuda/blend.h"
#include "learn/diff/cuda/project.h"
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

/// PictureValues on the GPU.
class GpuPictures {
 public:
  explicit GpuPictures(const PictureValues<float>& values)
      : host_(values),
        color_(values.color),
        alpha_(values.alpha),
        depth_(values.depth),
        inverse_depth_(values.inverse_depth) {}

  Pictures<float> pictures() {
    Pictures<float> result = host_.pictures();
    result.color.data = color_.data();
    result.alpha.data = alpha_.data();
    result.depth.data = depth_.data();
    result.inverse_depth.data = inverse_depth_.data();
    return result;
  }
  PictureValues<float> values() const {
    PictureValues<float> result = host_;
    result.color = color_.values();
    result.alpha = alpha_.values();
    result.depth = depth_.values();
    result.inverse_depth = inverse_depth_.values();
    return result;
  }

 private:
  PictureValues<float> host_;
  GpuArray<float> color_, alpha_, depth_, inverse_depth_;
};

/// Both stages of a frame on the GPU, as StageFrame.
struct GpuStageFrame {
  GpuMemory gaussians, pairs, pixels;
  cuda::diff::Frame frame;
  GpuArray<float> background;  ///< draw() sets it
  bool with_depth = true;

  void project(const DrawnView& view, const GaussianInputs<float>& in,
               const Boundary<float>& out = {}, const Rows<std::int32_t>& radii = {}) {
    using namespace cuda::diff;
    const GpuHeldSizes sizes = GpuHeldSizes::of(view.camera, in.count);
    gaussians = GpuMemory(bytes_of_gaussians(sizes));
    const GpuMemory projected(bytes_to_project(sizes));
    frame.gaussians = gaussians.data();
    cuda::diff::project(view, in, {}, projected.data(), frame, out, radii);
    pairs = GpuMemory(bytes_of_pairs(frame.sizes));
    frame.pairs = pairs.data();
    const GpuMemory unsorted(bytes_to_list(frame.sizes));
    list(view, {}, projected.data(), unsorted.data(), frame);
  }

  BlendInput<float> input(const DrawnView& view, const GaussianInputs<float>& in) const {
    return {{view.camera.width, view.camera.height},
            view.rules.pixel_rules<float>(),
            in.channel_count,
            in.channels,
            background.data()};
  }

  PictureValues<float> draw(const DrawnView& view, const StageScene<float>& scene) {
    const GpuScene inputs(scene);
    project(view, inputs.inputs());
    std::vector<float> colors;
    for (int c = 0; c < scene.channel_count; ++c)
      colors.push_back(static_cast<float>(0.2 + 0.13 * c));
    background = GpuArray<float>(colors);
    pixels = GpuMemory(bytes_of_pixels(frame.sizes.blended(scene.channel_count, with_depth)));
    pixels.fill(0x7f);
    frame.pixels = pixels.data();
    GpuPictures pictures(PictureValues<float>(view.camera, scene.channel_count));
    Pictures<float> out = pictures.pictures();
    if (!with_depth) out.depth = out.inverse_depth = {};
    cuda::diff::blend(input(view, inputs.inputs()), {}, with_depth, frame, out);
    return pictures.values();
  }

  /// Of a loss with these weights, after draw(). `with_deep`: also by alpha and depths.
  StageGradients<float> gradients(const DrawnView& view, const StageScene<float>& scene,
                                  const PictureValues<float>& weights,
                                  bool with_deep = true) const {
    const GpuScene inputs(scene);
    const GaussianInputs<float> in = inputs.inputs();
    const GpuBoundary boundary(in.count, in.channel_count);
    GpuArray<float> means(scene.means), scales(scene.scales), rotations(scene.rotations),
        covariances(scene.covariances), opacities(scene.opacities), sh(scene.sh),
        channels(scene.channels);
    const GpuArray<PoseGradient> pose(1);
    GpuPictures by(weights);
    Pictures<float> wanted = by.pictures();
    if (!with_deep) wanted.alpha = {};
    if (!with_deep || !with_depth) wanted.depth = wanted.inverse_depth = {};
    BoundaryGradients<float> out{
        boundary.rows(), {}, boundary.absolute_px(), boundary.background()};
    if (scene.has_channels)
      out.channels = Rows<float>::packed(channels.data(), scene.channel_count);
    GpuMemory scratch(cuda::diff::bytes_to_blend_backward(frame.sizes));
    scratch.fill(0x7f);
    cuda::diff::blend_backward(input(view, in), frame, wanted, {}, scratch.data(), out);
    const GpuMemory sums(cuda::diff::bytes_of_pose(frame.sizes));
    cuda::diff::project_backward(
        view, in, frame, boundary.rows(), {}, sums.data(),
        {Rows<float>::packed(means.data(), 3), Rows<float>::packed(scales.data(), 3),
         Rows<float>::packed(rotations.data(), 4), Rows<float>::packed(covariances.data(), 6),
         Rows<float>::packed(opacities.data(), 1),
         ShRows<float>::packed(sh.data(), sh_coefficient_count(scene.sh_degree))},
        pose.data());
    StageGradients<float> result{scene, boundary.values(), pose.values()[0]};
    result.by.means = means.values();
    result.by.scales = scales.values();
    result.by.rotations = rotations.values();
    result.by.covariances = covariances.values();
    result.by.opacities = opacities.values();
    result.by.sh = sh.values();
    result.by.channels = channels.values();
    return result;
  }
};

}  // namespace qs::test
