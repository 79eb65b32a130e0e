// SPDX-License-Identifier: MIT
//
// Small scenes for the passes of the differentiable rasterizer: inputs in arrays, a loss over all
// pictures, and the derivatives of the loss by all inputs.
#pragma once

#include <functional>
#include <random>
#include <vector>

#include "learn/diff/cpu/blend.h"
#include "learn/diff/cpu/project.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/train_scenes.h"

namespace qs::test {

using cpu::diff::BlendedFrame;
using cpu::diff::BlendInput;
using cpu::diff::PairScratch;
using cpu::diff::project_backward;
using cpu::diff::ProjectedFrame;
using diff::Boundary;
using diff::BoundaryGradients;
using diff::DrawnView;
using diff::GaussianInputs;
using diff::InputGradients;
using diff::Pictures;
using diff::Pixels;
using diff::PoseGradient;
using diff::Rows;
using diff::ShRows;

/// Inputs of project(), or derivatives by them.
template <class Real>
struct StageScene {
  std::vector<Real> means, scales, rotations, covariances, opacities, sh, channels;
  int sh_degree = 3, channel_count = 3;
  bool has_covariances = false, has_channels = false;

  std::size_t size() const { return opacities.size(); }

  GaussianInputs<Real> inputs() const {
    GaussianInputs<Real> in;
    in.count = size();
    in.means = Rows<const Real>::packed(means.data(), 3);
    if (has_covariances) {
      in.covariances = Rows<const Real>::packed(covariances.data(), 6);
    } else {
      in.scales = Rows<const Real>::packed(scales.data(), 3);
      in.rotations = Rows<const Real>::packed(rotations.data(), 4);
    }
    in.opacities = Rows<const Real>::packed(opacities.data(), 1);
    in.sh_degree = sh_degree;
    in.channel_count = channel_count;
    if (has_channels)
      in.channels = Rows<const Real>::packed(channels.data(), channel_count);
    else
      in.sh = ShRows<const Real>::packed(sh.data(), sh_coefficient_count(sh_degree));
    return in;
  }

  /// Calls visit(name, values per Gaussian, values) for all given arrays.
  template <class Visit>
  void for_each_array(const Visit& visit) {
    visit("mean", 3, means);
    if (has_covariances) {
      visit("covariance", 6, covariances);
    } else {
      visit("scale", 3, scales);
      visit("rotation", 4, rotations);
    }
    visit("opacity", 1, opacities);
    if (has_channels)
      visit("channel", channel_count, channels);
    else
      visit("coefficient", 3 * sh_coefficient_count(sh_degree), sh);
  }
};

/// small_scene() with activated values.
template <class Real>
StageScene<Real> stage_scene(std::size_t count, unsigned seed) {
  const Parameters<double> scene = small_scene<double>(count, seed);
  StageScene<Real> result;
  const auto add = [](std::vector<Real>& to, double value) {
    to.push_back(static_cast<Real>(value));
  };
  for (std::size_t i = 0; i < count; ++i) {
    const glm::dquat& q = scene.rotations[i];
    for (int k = 0; k < 3; ++k) add(result.means, scene.means[i][k]);
    for (int k = 0; k < 3; ++k) add(result.scales, std::exp(scene.log_scales[i][k]));
    for (const double value : {q.w, q.x, q.y, q.z}) add(result.rotations, value);
    add(result.opacities, opacity_of(scene.opacity_logits[i]));
    const Covariance3<double> c = covariance_of(scene.log_scales[i], unit_rotation(q));
    for (const double value : {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz}) add(result.covariances, value);
  }
  for (const glm::dvec3& coefficient : scene.sh) {
    for (int c = 0; c < 3; ++c) add(result.sh, coefficient[c]);
  }
  return result;
}

template <class Real>
StageScene<Real> with_channels(StageScene<Real> scene, int channel_count) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(-1, 1);
  scene.has_channels = true;
  scene.channel_count = channel_count;
  scene.channels.resize(scene.size() * static_cast<std::size_t>(channel_count));
  for (Real& value : scene.channels) value = static_cast<Real>(uniform(random));
  return scene;
}

/// A camera whose principal point is not in the middle, turned, with an independent position.
inline DrawnView off_centre_view(int width = kWidth, int height = kHeight) {
  DrawnView view;
  view.camera = look_at({0.2, -0.1, -0.3}, {0.1, 0.05, 3}, {0.1, -1, 0}, 1.1, width, height);
  view.camera.center_px += glm::dvec2(4.5, -3.25);
  view.position = view.camera.position() + glm::dvec3(0.05, 0.02, -0.03);
  view.mode = find_culler("3dgs");
  return view;
}

/// Numbers per pixel of all pictures: pictures, or the weights of a loss.
template <class Real>
struct PictureValues {
  int width, height, channel_count;
  std::vector<Real> color, alpha, depth, inverse_depth;  ///< color: a plane per channel

  PictureValues(const Camera& camera, int channels)
      : width(camera.width), height(camera.height), channel_count(channels) {
    const auto pixels = static_cast<std::size_t>(width * height);
    color.resize(pixels * static_cast<std::size_t>(channels));
    alpha.resize(pixels);
    depth.resize(pixels);
    inverse_depth.resize(pixels);
  }
  static PictureValues random(const Camera& camera, int channels, unsigned seed = 3) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    PictureValues values(camera, channels);
    for (auto* picture : {&values.color, &values.alpha, &values.depth, &values.inverse_depth}) {
      for (Real& value : *picture) value = static_cast<Real>(uniform(random));
    }
    return values;
  }

  Pictures<Real> pictures() {
    const std::ptrdiff_t plane = std::ptrdiff_t{width} * height;
    return {{color.data(), width, 1, plane},
            {alpha.data(), width, 1, 0},
            {depth.data(), width, 1, 0},
            {inverse_depth.data(), width, 1, 0}};
  }

  double dot(const PictureValues& other) const {
    double sum = 0;
    const auto add = [&sum](const std::vector<Real>& a, const std::vector<Real>& b) {
      for (std::size_t i = 0; i < a.size(); ++i)
        sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
    };
    add(color, other.color);
    add(alpha, other.alpha);
    add(depth, other.depth);
    add(inverse_depth, other.inverse_depth);
    return sum;
  }
  bool operator==(const PictureValues&) const = default;
};

/// The boundary's numbers, or the derivatives by them.
template <class Real>
struct BoundaryValues {
  std::vector<Real> mean_px, conic, depth, opacity, color, absolute_px, background;

  explicit BoundaryValues(std::size_t count, int channels = 3)
      : mean_px(2 * count),
        conic(3 * count),
        depth(count),
        opacity(count),
        color(3 * count),
        absolute_px(2 * count),
        background(static_cast<std::size_t>(channels)) {}

  Boundary<Real> rows() {
    return {Rows<Real>::packed(mean_px.data(), 2), Rows<Real>::packed(conic.data(), 3),
            Rows<Real>::packed(depth.data(), 1), Rows<Real>::packed(opacity.data(), 1),
            Rows<Real>::packed(color.data(), 3)};
  }
  bool operator==(const BoundaryValues&) const = default;
};

template <class Real>
struct StageGradients {
  StageScene<Real> by;
  BoundaryValues<Real> boundary;
  PoseGradient pose;

  /// All numbers one after the other.
  std::vector<double> numbers() const {
    std::vector<double> all;
    for (const auto* array :
         {&by.means, &by.scales, &by.rotations, &by.covariances, &by.opacities, &by.sh,
          &by.channels, &boundary.mean_px, &boundary.conic, &boundary.depth, &boundary.opacity,
          &boundary.color, &boundary.absolute_px, &boundary.background})
      all.insert(all.end(), array->begin(), array->end());
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row) all.push_back(pose.view_from_world[column][row]);
    }
    for (int k = 0; k < 3; ++k) all.push_back(pose.position[k]);
    return all;
  }
};

/// Both stages of a frame.
template <class Real>
struct StageFrame {
  ProjectedFrame<Real> frame;
  BlendedFrame<Real> pixels;
  std::vector<Real> background;  ///< if it is empty, draw() sets it

  BlendInput<Real> input(const DrawnView& view, const GaussianInputs<Real>& in) const {
    return {{view.camera.width, view.camera.height},
            view.rules.pixel_rules<Real>(),
            in.channel_count,
            in.channels,
            background.data()};
  }

  PictureValues<Real> draw(const DrawnView& view, const GaussianInputs<Real>& in,
                           ThreadPool& threads = pool(1)) {
    project<Real>(view, in, {threads}, frame);
    if (background.empty()) {
      for (int c = 0; c < in.channel_count; ++c)
        background.push_back(static_cast<Real>(0.2 + 0.13 * c));
    }
    PictureValues<Real> values(view.camera, in.channel_count);
    const BlendInput<Real> blended = input(view, in);
    pixels.resize(blended.size, in.channel_count, true);
    blend<Real>(blended, frame.view(), {threads}, pixels.state(), values.pictures());
    return values;
  }
  PictureValues<Real> draw(const DrawnView& view, const StageScene<Real>& scene,
                           ThreadPool& threads = pool(1)) {
    return draw(view, scene.inputs(), threads);
  }

  /// Of a loss with these weights, after draw().
  StageGradients<Real> gradients(const DrawnView& view, const StageScene<Real>& scene,
                                 const Pictures<const Real>& weights,
                                 ThreadPool& threads = pool(1)) const {
    const GaussianInputs<Real> in = scene.inputs();
    StageGradients<Real> result{scene, BoundaryValues<Real>(in.count, in.channel_count), {}};
    StageScene<Real>& by = result.by;
    BoundaryValues<Real>& boundary = result.boundary;
    PairScratch<Real> scratch;
    BoundaryGradients<Real> out{boundary.rows(),
                                {},
                                Rows<Real>::packed(boundary.absolute_px.data(), 2),
                                boundary.background.data()};
    if (scene.has_channels)
      out.channels = Rows<Real>::packed(by.channels.data(), scene.channel_count);
    blend_backward<Real>(input(view, in), frame.view(), in.count, pixels.state(), weights,
                         {threads}, scratch, out);
    project_backward<Real>(view, in, frame.projected, boundary.rows(), {threads}, rows_of(by),
                           &result.pose);
    return result;
  }

  static InputGradients<Real> rows_of(StageScene<Real>& by) {
    return {Rows<Real>::packed(by.means.data(), 3),
            Rows<Real>::packed(by.scales.data(), 3),
            Rows<Real>::packed(by.rotations.data(), 4),
            Rows<Real>::packed(by.covariances.data(), 6),
            Rows<Real>::packed(by.opacities.data(), 1),
            ShRows<Real>::packed(by.sh.data(), sh_coefficient_count(by.sh_degree))};
  }
};

}  // namespace qs::test
