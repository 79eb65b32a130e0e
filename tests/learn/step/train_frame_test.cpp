// SPDX-License-Identifier: MIT
// The forward and the backward pass of training: against the renderer, and against differences of
// whole frames.
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "learn/step/cpu/passes.h"
#include "raster/cpu/renderer.h"
#include "support/differences.h"
#include "support/golden_field.h"
#include "support/pool.h"
#include "support/scenes.h"
#include "support/train_scenes.h"

namespace qs::cpu::train {
namespace {

using test::for_each_group;
using test::groups_of;
using test::kHeight;
using test::kWidth;
using test::pixel_weights;
using test::pool;
using test::settings_of;
using test::small_scene;

template <class Real>
Gradients<Real> gradients_of(const Parameters<Real>& scene, const RenderSettings& settings,
                             int threads = 2, const BackwardOrder& order = {},
                             Projection projection = Projection::pinhole) {
  const Camera camera = test::with_projection(test::front_camera(kWidth, kHeight), projection);
  const StepView view{camera, settings, pool(threads)};
  ForwardFrame<Real> frame;
  BackwardScratch<Real> scratch;
  Gradients<Real> gradients;
  forward(view, scene, frame);
  backward<Real>(view, scene, frame, pixel_weights<Real>(), scratch, gradients, order);
  return gradients;
}

// Antialiased or not, and the projections of training.
constexpr std::pair<bool, Projection> kViews[] = {{false, Projection::pinhole},
                                                  {true, Projection::pinhole},
                                                  {false, Projection::face},
                                                  {true, Projection::face}};

TEST(TrainFrame, equals_the_renderers_picture) {
  for (const auto& [antialiased, projection] : kViews) {
    const Parameters<float> scene = small_scene<float>(300, 1);
    const Camera camera = test::with_projection(test::front_camera(kWidth, kHeight), projection);
    const RenderSettings settings = settings_of(default_mode(), antialiased);
    ForwardFrame<float> frame;
    forward({camera, settings, pool()}, scene, frame);
    const auto renderer = make_cpu_renderer(pool());
    renderer->upload(to_cloud(scene, antialiased), {});
    const Image& expected = renderer->render(camera, settings).color;
    for (std::size_t i = 0; i < frame.color.size(); ++i) {
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(frame.color[i][c], expected.values[3 * i + static_cast<std::size_t>(c)], 2e-5);
    }
  }
}

TEST(TrainFrame, gradients_of_every_parameter_equal_differences) {
  for (const auto& [antialiased, projection] : kViews) {
    const RenderSettings settings = settings_of(find_culler("3dgs"), antialiased);
    Parameters<double> scene = small_scene<double>(24, 6);
    const Camera camera = test::with_projection(test::front_camera(kWidth, kHeight), projection);
    const auto weights = pixel_weights<double>();
    const Gradients<double> gradients = gradients_of(scene, settings, 2, {}, projection);
    ForwardFrame<double> frame;
    const auto loss = [&] {
      forward({camera, settings, pool(1)}, scene, frame);
      double sum = 0;
      for (std::size_t i = 0; i < weights.size(); ++i) sum += glm::dot(weights[i], frame.color[i]);
      return sum;
    };
    const auto expected = groups_of(gradients.by);
    std::size_t group = 0;
    for_each_group(scene, [&](const char* name, std::size_t values, double* first) {
      double scale = 0;
      for (const double value : expected[group]) scale = std::max(scale, std::abs(value));
      EXPECT_GT(scale, 0);
      // Only some of the coefficients are tested, because they are many and the frame is linear in
      // each.
      const std::size_t step = values > 4 ? 11 : 1;
      for (std::size_t i = 0; i < values * scene.size(); i += step) {
        const double before = first[i], h = 1e-6;
        first[i] = before + h;
        const double above = loss();
        first[i] = before - h;
        const double below = loss();
        first[i] = before;
        EXPECT_NEAR(expected[group][i], (above - below) / (2 * h), 1e-6 * scale)
            << name << " " << i << (antialiased ? ", antialiased" : "")
            << (projection == Projection::face ? ", a face" : "");
      }
      ++group;
    });
  }
}

// The threshold has no derivative. The mask that replaces it is 1 plus the change of the sigmoid.
TEST(TrainFrame, gradients_of_masks_equal_differences_of_scales_and_opacities_times_the_mask) {
  for (const bool antialiased : {false, true}) {
    const RenderSettings settings = settings_of(find_culler("3dgs"), antialiased);
    const Parameters<double> scene = test::with_masks(small_scene<double>(24, 5));
    const Camera camera = test::front_camera(kWidth, kHeight);
    const auto weights = pixel_weights<double>();
    const std::vector<double> by = gradients_of(scene, settings).by.mask_logits;
    ForwardFrame<double> frame;
    double scale = 0;
    for (const double value : by) scale = std::max(scale, std::abs(value));
    ASSERT_GT(scale, 0);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const auto loss = [&](double change) {
        Parameters<double> moved = scene;
        const double logit = scene.mask_logits[i];
        const double mask = 1 + opacity_of(logit + change) - opacity_of(logit);
        moved.log_scales[i] += std::log(mask);
        const double opacity = mask * opacity_of(scene.opacity_logits[i]);
        moved.opacity_logits[i] = std::log(opacity / (1 - opacity));
        forward({camera, settings, pool(1)}, moved, frame);
        double sum = 0;
        for (std::size_t k = 0; k < weights.size(); ++k)
          sum += glm::dot(weights[k], frame.color[k]);
        return sum;
      };
      constexpr double kStep = 1e-6;
      EXPECT_NEAR(by[i], (loss(kStep) - loss(-kStep)) / (2 * kStep), 1e-6 * scale) << i;
      EXPECT_EQ(by[i] == 0, scene.is_masked_out(i)) << i;
    }
  }
}

TEST(TrainFrame, gaussians_that_are_masked_out_are_neither_drawn_nor_counted_nor_saved) {
  const Parameters<float> scene = test::with_masks(small_scene<float>(300, 1));
  Parameters<float> rest = scene;
  rest.has_masks = false;
  rest.resize(0);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (scene.is_masked_out(i)) continue;
    rest.means.push_back(scene.means[i]);
    rest.log_scales.push_back(scene.log_scales[i]);
    rest.rotations.push_back(scene.rotations[i]);
    rest.opacity_logits.push_back(scene.opacity_logits[i]);
    for (std::size_t k = 0; k < scene.sh_stride(); ++k)
      rest.sh.push_back(scene.sh[i * scene.sh_stride() + k]);
  }
  ASSERT_EQ(rest.size(), 257u);
  EXPECT_EQ(qs::train::count_existing(scene), rest.size());
  EXPECT_EQ(qs::train::count_existing(rest), rest.size());
  const Camera camera = test::front_camera(kWidth, kHeight);
  const RenderSettings settings = settings_of(default_mode(), false);
  ForwardFrame<float> frame, expected;
  forward({camera, settings, pool()}, scene, frame);
  forward({camera, settings, pool()}, rest, expected);
  EXPECT_EQ(frame.color, expected.color);
  for (std::size_t i = 0; i < scene.size(); ++i) {
    if (scene.is_masked_out(i)) {
      EXPECT_EQ(frame.in_view[i] + frame.listed[i], 0) << i;
    }
  }
  const GaussianCloud cloud = to_cloud(scene, false), expected_cloud = to_cloud(rest, false);
  EXPECT_EQ(cloud.size(), rest.size());
  EXPECT_EQ(cloud.positions, expected_cloud.positions);
  EXPECT_EQ(cloud.log_scales, expected_cloud.log_scales);
  EXPECT_EQ(cloud.rotations, expected_cloud.rotations);
  EXPECT_EQ(cloud.opacity_logits, expected_cloud.opacity_logits);
  EXPECT_EQ(cloud.sh, expected_cloud.sh);
}

// A tiny colour field with parameters that follow a rule.
template <class Real>
struct TinyField {
  ColorField field = test::tiny_field();
  std::vector<Real> grid{field.grid_values.begin(), field.grid_values.end()};
  std::vector<Real> weights{field.weights.begin(), field.weights.end()};

  FieldGradient<Real> gradient() const { return {field.grid, field.width, grid, weights}; }
  Gradients<Real> gradients_of(const Parameters<Real>& scene, const RenderSettings& settings,
                               int threads = 2) const {
    const Camera camera = test::front_camera(kWidth, kHeight);
    const StepView view{camera, settings, pool(threads)};
    const FieldGradient<Real> own = gradient();
    ForwardFrame<Real> frame;
    BackwardScratch<Real> scratch;
    Gradients<Real> gradients;
    forward(view, scene, frame, &own);
    backward<Real>(view, scene, frame, pixel_weights<Real>(), scratch, gradients, {}, &own);
    return gradients;
  }
};

TEST(TrainFrame, gradients_of_a_colour_field_equal_differences) {
  TinyField<double> field;
  const RenderSettings settings = settings_of(find_culler("3dgs"), false);
  const Parameters<double> scene = small_scene<double>(24, 5);
  const Camera camera = test::front_camera(kWidth, kHeight);
  const auto weights = pixel_weights<double>();
  const Gradients<double> gradients = field.gradients_of(scene, settings);
  const auto loss = [&] {
    const FieldGradient<double> moved = field.gradient();
    ForwardFrame<double> frame;
    forward({camera, settings, pool(1)}, scene, frame, &moved);
    double sum = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) sum += glm::dot(weights[i], frame.color[i]);
    return sum;
  };
  const auto expect_differences = [&](std::vector<double>& values, std::size_t stride,
                                      const auto& by) {
    double scale = 0;
    for (std::size_t i = 0; i < values.size(); ++i) scale = std::max(scale, std::abs(by(i)));
    ASSERT_GT(scale, 0);
    for (std::size_t i = 0; i < values.size(); i += stride) {
      const double before = values[i], h = 1e-6;
      values[i] = before + h;
      const double above = loss();
      values[i] = before - h;
      const double below = loss();
      values[i] = before;
      EXPECT_NEAR(by(i), (above - below) / (2 * h), 1e-6 * scale) << i;
    }
  };
  expect_differences(field.grid, 7, [&](std::size_t i) { return gradients.by_field.grid.sum(i); });
  expect_differences(field.weights, 23,
                     [&](std::size_t i) { return gradients.by_field.weights[i]; });
  for (const glm::dvec3& by : gradients.by.sh) EXPECT_EQ(by, glm::dvec3(0));
}

TEST(TrainFrame, threads_and_lossless_modes_do_not_change_the_gradients_of_a_colour_field) {
  const TinyField<float> field;
  const Parameters<float> scene = small_scene<float>(3000, 7);
  const auto values_of = [](const Gradients<float>& gradients) {
    std::vector<double> values(gradients.by_field.weights.begin(),
                               gradients.by_field.weights.end());
    for (std::size_t i = 0; i < gradients.by_field.grid.size(); ++i)
      values.push_back(gradients.by_field.grid.sum(i));
    return values;
  };
  const Gradients<float> expected =
      field.gradients_of(scene, settings_of(find_culler("adr"), false), 1);
  for (const char* mode : {"adr", "quadbox", "exact"}) {
    for (const int threads : {1, 3}) {
      const Gradients<float> gradients =
          field.gradients_of(scene, settings_of(find_culler(mode), false), threads);
      EXPECT_EQ(values_of(gradients), values_of(expected)) << mode << threads;
      EXPECT_EQ(gradients.by.means, expected.by.means) << mode << threads;
    }
  }
}

TEST(TrainFrame, gradients_in_single_precision_equal_those_in_double_precision) {
  for (const bool antialiased : {false, true}) {
    const RenderSettings settings = settings_of(default_mode(), antialiased);
    const auto values =
        groups_of(gradients_of(test::with_masks(small_scene<float>(24, 5)), settings).by);
    const auto expected =
        groups_of(gradients_of(test::with_masks(small_scene<double>(24, 5)), settings).by);
    for (std::size_t group = 0; group < values.size(); ++group) {
      SCOPED_TRACE(group);
      test::expect_close(values[group], expected[group], 1e-3);
    }
  }
}

TEST(TrainFrame, every_lossless_mode_gives_the_same_gradients) {
  const Parameters<float> scene = small_scene<float>(200, 7);
  const Gradients<float> expected = gradients_of(scene, settings_of(find_culler("adr"), false));
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    // Mode 3dgs keeps Gaussians of alpha < 1/255 but loses some pixels of other Gaussians.
    if (!row_of(mode).lossless) continue;
    const Gradients<float> gradients = gradients_of(scene, settings_of(mode, false));
    EXPECT_EQ(groups_of(gradients.by), groups_of(expected.by)) << mode_name(mode);
    EXPECT_EQ(gradients.visible, expected.visible) << mode_name(mode);
  }
}

TEST(TrainFrame, gradients_do_not_depend_on_the_number_of_threads) {
  const Parameters<float> scene = small_scene<float>(5000, 9);
  const RenderSettings settings = settings_of(default_mode(), true);
  const Gradients<float> expected = gradients_of(scene, settings, 1);
  for (const int threads : {2, 3, 7}) {
    const Gradients<float> gradients = gradients_of(scene, settings, threads);
    EXPECT_EQ(groups_of(gradients.by), groups_of(expected.by)) << threads;
    EXPECT_EQ(gradients.mean_px, expected.mean_px) << threads;
    EXPECT_EQ(gradients.visible, expected.visible) << threads;
  }
}

TEST(TrainFrame, absolute_gradients_are_the_sums_of_each_pixels_absolute_gradient) {
  constexpr int kSmallWidth = 19, kSmallHeight = 18;
  const Parameters<double> scene = small_scene<double>(12, 6);
  const Camera camera = test::front_camera(kSmallWidth, kSmallHeight);
  const RenderSettings settings = settings_of(default_mode(), false);
  const StepView view{camera, settings, pool()};
  ForwardFrame<double> frame;
  BackwardScratch<double> scratch;
  Gradients<double> gradients;
  forward(view, scene, frame);
  const auto weights = pixel_weights<double>(kSmallWidth, kSmallHeight);
  std::vector<glm::dvec2> expected(scene.size());
  for (std::size_t pixel = 0; pixel < weights.size(); ++pixel) {
    std::vector<glm::dvec3> alone(weights.size());
    alone[pixel] = weights[pixel];
    backward<double>(view, scene, frame, alone, scratch, gradients);
    EXPECT_TRUE(gradients.absolute_px.empty()) << "only if asked for";
    for (std::size_t i = 0; i < scene.size(); ++i) expected[i] += glm::abs(gradients.mean_px[i]);
  }
  backward<double>(view, scene, frame, weights, scratch, gradients, {.absolute = true});
  ASSERT_EQ(gradients.absolute_px.size(), scene.size());
  for (std::size_t i = 0; i < scene.size(); ++i) {
    EXPECT_LT(glm::distance(gradients.absolute_px[i], expected[i]), 1e-12);
    EXPECT_GE(gradients.absolute_px[i].x, std::abs(gradients.mean_px[i].x));
  }
}

TEST(TrainFrame, absolute_gradients_have_the_same_bits_with_all_threads_and_lossless_modes) {
  const Parameters<float> scene = small_scene<float>(1000, 8);
  const auto absolute = [&](CullMode mode, int threads) {
    return gradients_of(scene, settings_of(mode, false), threads, {.absolute = true}).absolute_px;
  };
  const auto expected = absolute(find_culler("adr"), 1);
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    if (!row_of(mode).lossless) continue;
    EXPECT_EQ(absolute(mode, 3), expected) << mode_name(mode);
  }
}

TEST(TrainFrame, gaussians_outside_of_the_view_get_no_gradient) {
  Parameters<float> scene = small_scene<float>(3, 11);
  scene.means[1].z = -3;
  const Gradients<float> gradients = gradients_of(scene, settings_of(default_mode(), false));
  EXPECT_EQ(gradients.visible, (std::vector<std::uint8_t>{1, 0, 1}));
  EXPECT_EQ(gradients.by.means[1], glm::vec3(0));
  EXPECT_NE(gradients.by.means[0], glm::vec3(0));
}

// Both means are 1.8 standard deviations outside of the image. At an opacity of 0.01, alpha falls
// below 1/255 at 1.4 standard deviations.
TEST(TrainFrame, views_that_a_faint_gaussian_does_not_reach_do_not_count_in_any_mode) {
  const Camera camera = test::front_camera(kWidth, kHeight);
  constexpr double kDepth = 3, kSigmaPx = 6;
  Parameters<float> scene = small_scene<float>(2, 13);
  for (std::size_t i = 0; i < 2; ++i) {
    const double x_px = -1.8 * kSigmaPx;
    scene.means[i] =
        glm::dvec3((x_px - camera.center_px.x) / camera.focal_px.x * kDepth, 0, kDepth);
    scene.log_scales[i] = glm::vec3(glm::dvec3(std::log(kSigmaPx * kDepth / camera.focal_px.x)));
  }
  scene.opacity_logits = {static_cast<float>(std::log(0.01 / 0.99)), 2};
  for (CullMode mode = 1; mode <= culler_count(); ++mode) {
    EXPECT_EQ(gradients_of(scene, settings_of(mode, false)).visible,
              (std::vector<std::uint8_t>{0, 1}))
        << mode_name(mode);
  }
}

}  // namespace
}  // namespace qs::cpu::train
