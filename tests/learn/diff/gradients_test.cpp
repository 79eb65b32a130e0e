// SPDX-License-Identifier: MIT
// The passes of the differentiable rasterizer: their gradients against differences of whole frames
// in double precision, for all rules.
#include <cmath>
#include <functional>
#include <string>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "support/differences.h"
#include "support/stage_scenes.h"

namespace qs {
namespace {

using diff::DrawnView;
using diff::PoseGradient;
using test::BoundaryValues;
using test::expect_close;
using test::off_centre_view;
using test::PictureValues;
using test::pool;
using test::project_backward;
using test::stage_scene;
using test::StageFrame;
using test::StageGradients;
using test::StageScene;
using test::with_channels;

constexpr double kStep = 1e-6;

double difference(double& value, const std::function<double()>& loss) {
  const double before = value;
  value = before + kStep;
  const double above = loss();
  value = before - kStep;
  const double below = loss();
  value = before;
  return (above - below) / (2 * kStep);
}

/// Expects that `gradient` of every `stride`-th value is its difference of the loss.
void expect_differences(std::vector<double>& values, const std::vector<double>& gradient,
                        std::size_t stride, const std::function<double()>& loss,
                        const std::string& name) {
  double scale = 0;
  for (const double value : gradient) scale = std::max(scale, std::abs(value));
  EXPECT_GT(scale, 0) << name;
  for (std::size_t i = 0; i < values.size(); i += stride)
    EXPECT_NEAR(gradient[i], difference(values[i], loss), 2e-6 * scale) << name << " " << i;
}

void expect_differences(StageScene<double>& scene, StageGradients<double>& gradients,
                        const std::function<double()>& loss) {
  std::vector<std::vector<double>> expected;
  gradients.by.for_each_array(
      [&](const char*, int, const std::vector<double>& by) { expected.push_back(by); });
  std::size_t group = 0;
  scene.for_each_array([&](const char* name, int numbers, std::vector<double>& values) {
    expect_differences(values, expected[group++], numbers > 6 ? 13 : 1, loss, name);
  });
}

void expect_pose_differences(DrawnView& view, const PoseGradient& pose,
                             const std::function<double()>& loss) {
  double scale = 0;
  for (int column = 0; column < 4; ++column)
    scale = std::max(scale, glm::length(pose.view_from_world[column]));
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(pose.view_from_world[column][row],
                  difference(view.camera.view_from_world[column][row], loss), 2e-6 * scale)
          << "view " << column << " " << row;
    }
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(pose.position[k], difference((*view.position)[k], loss), 2e-6 * scale)
        << "position " << k;
  }
}

struct Variant {
  const char* name;
  std::function<void(DrawnView&)> change;
};

const std::vector<Variant> kVariants = {
    {"default", [](DrawnView&) {}},
    {"antialiased", [](DrawnView& view) { view.rules.antialiased = true; }},
    {"antialiased without floor, scaled, small dilation",
     [](DrawnView& view) {
       view.rules.antialiased = true;
       view.rules.compensation_floor = 0;
       view.rules.splat_scale = 0.6;
       view.rules.dilation = 0.1;
     }},
    {"splat scale", [](DrawnView& view) { view.rules.splat_scale = 1.7; }},
    {"clamped slopes",
     [](DrawnView& view) {
       view.rules.slopes = diff::SlopeBounds{{-0.15, -0.2}, {0.1, 0.05}};
     }},
    {"rotations as they are", [](DrawnView& view) { view.rules.normalises_rotations = false; }},
    {"clamped alpha without gradient",
     [](DrawnView& view) {
       view.rules.alpha_max = 0.6;
       view.rules.alpha_max_passes = false;
     }},
    {"tight boxes, planes and equal stops",
     [](DrawnView& view) {
       view.mode = find_culler("adr");
       view.rules.near_depth = 2.4;
       view.rules.far_depth = 4.6;
       view.rules.stops_at_equal = true;
     }},
};

/// Calls test(view) under all rules.
void for_each_variant(const std::function<void(DrawnView&)>& test) {
  for (const Variant& variant : kVariants) {
    SCOPED_TRACE(variant.name);
    DrawnView view = off_centre_view();
    variant.change(view);
    test(view);
  }
}

TEST(StageGradient, of_all_inputs_and_of_the_camera_equals_differences_of_all_pictures) {
  for_each_variant([](DrawnView& view) {
    StageScene<double> scene = stage_scene<double>(16, 5);
    auto weights = PictureValues<double>::random(view.camera, 3);
    StageFrame<double> frame, moved;
    const PictureValues<double> pictures = frame.draw(view, scene);
    StageGradients<double> gradients = frame.gradients(view, scene, weights.pictures());
    EXPECT_GT(pictures.dot(pictures), 0);
    const auto loss = [&] { return moved.draw(view, scene).dot(weights); };
    expect_differences(scene, gradients, loss);
    expect_pose_differences(view, gradients.pose, loss);
  });
}

TEST(StageGradient, of_the_boundary_alone_equals_differences_also_where_no_tile_is_listed) {
  for_each_variant([](DrawnView& view) {
    StageScene<double> scene = stage_scene<double>(16, 6);
    scene.means[0] += 9;         // outside of the image
    scene.opacities[1] = 0.001;  // too faint for a pixel
    BoundaryValues<double> weights(scene.size());
    test::ProjectedFrame<double> frame;
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (auto* array :
         {&weights.mean_px, &weights.conic, &weights.depth, &weights.opacity, &weights.color})
      for (double& value : *array) value = uniform(random);
    const auto loss = [&] {
      BoundaryValues<double> values(scene.size());
      project<double>(view, scene.inputs(), {pool(1)}, frame, values.rows());
      double sum = 0;
      const auto add = [&sum](const std::vector<double>& a, const std::vector<double>& b) {
        for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
      };
      add(values.mean_px, weights.mean_px);
      add(values.conic, weights.conic);
      add(values.depth, weights.depth);
      add(values.opacity, weights.opacity);
      add(values.color, weights.color);
      return sum;
    };
    loss();
    StageGradients<double> gradients{scene, BoundaryValues<double>(scene.size()), {}};
    project_backward<double>(view, scene.inputs(), frame.projected, weights.rows(), {pool(1)},
                             StageFrame<double>::rows_of(gradients.by), &gradients.pose);
    if (view.rules.far_depth > 5 && view.rules.near_depth < 2) {
      EXPECT_NE(gradients.by.means[0], 0);
      EXPECT_NE(gradients.by.opacities[1], 0);
    }
    expect_differences(scene, gradients, loss);
    expect_pose_differences(view, gradients.pose, loss);
  });
}

TEST(StageGradient, in_single_precision_equals_double_precision) {
  for_each_variant([](DrawnView& view) {
    StageScene<double> scene = stage_scene<double>(16, 5);
    StageScene<float> rounded = stage_scene<float>(16, 5);
    auto weights = PictureValues<double>::random(view.camera, 3);
    auto rounded_weights = PictureValues<float>::random(view.camera, 3);
    StageFrame<double> frame;
    StageFrame<float> rounded_frame;
    frame.draw(view, scene);
    rounded_frame.draw(view, rounded);
    StageGradients<double> expected = frame.gradients(view, scene, weights.pictures());
    StageGradients<float> gradients =
        rounded_frame.gradients(view, rounded, rounded_weights.pictures());
    std::vector<std::vector<double>> groups;
    expected.by.for_each_array(
        [&](const char*, int, const std::vector<double>& by) { groups.push_back(by); });
    std::size_t group = 0;
    gradients.by.for_each_array([&](const char* name, int, const std::vector<float>& by) {
      SCOPED_TRACE(name);
      expect_close(by, groups[group++], 1e-3);
    });
  });
}

TEST(StageGradient, of_given_covariances_equals_differences) {
  for (const bool antialiased : {false, true}) {
    DrawnView view = off_centre_view();
    view.rules.antialiased = antialiased;
    view.rules.splat_scale = 1.3;
    StageScene<double> scene = stage_scene<double>(12, 8);
    scene.has_covariances = true;
    auto weights = PictureValues<double>::random(view.camera, 3);
    StageFrame<double> frame, moved;
    frame.draw(view, scene);
    StageGradients<double> gradients = frame.gradients(view, scene, weights.pictures());
    const auto loss = [&] { return moved.draw(view, scene).dot(weights); };
    expect_differences(scene, gradients, loss);
    expect_pose_differences(view, gradients.pose, loss);
  }
}

TEST(StageGradient, of_any_number_of_channels_equals_differences) {
  for (const int channels : {1, 2, 3, 5, 9, 32}) {
    SCOPED_TRACE(channels);
    DrawnView view = off_centre_view();
    StageScene<double> scene = with_channels(stage_scene<double>(8, 9), channels);
    auto weights = PictureValues<double>::random(view.camera, channels);
    StageFrame<double> frame, moved;
    frame.draw(view, scene);
    StageGradients<double> gradients = frame.gradients(view, scene, weights.pictures());
    const auto loss = [&] { return moved.draw(view, scene).dot(weights); };
    expect_differences(scene, gradients, loss);
    expect_pose_differences(view, gradients.pose, loss);
  }
}

TEST(StageGradient, of_every_degree_of_colour_equals_differences) {
  for (int degree = 0; degree <= 3; ++degree) {
    SCOPED_TRACE(degree);
    DrawnView view = off_centre_view();
    view.sh_degree = degree;  // below the coefficients' degree, whose rest gets 0
    StageScene<double> scene = stage_scene<double>(8, 10);
    auto weights = PictureValues<double>::random(view.camera, 3);
    StageFrame<double> frame, moved;
    frame.draw(view, scene);
    StageGradients<double> gradients = frame.gradients(view, scene, weights.pictures());
    const auto loss = [&] { return moved.draw(view, scene).dot(weights); };
    expect_differences(scene.sh, gradients.by.sh, 7, loss, "coefficient");
    expect_pose_differences(view, gradients.pose, loss);
  }
}

TEST(StageGradient, of_single_pictures_and_of_the_background_equals_differences) {
  const DrawnView view = off_centre_view();
  StageScene<double> scene = stage_scene<double>(8, 11);
  auto weights = PictureValues<double>::random(view.camera, 3);
  const auto all = weights.pictures();
  const std::vector<double> none(weights.color.size(), 0);
  for (int only = 0; only < 4; ++only) {
    SCOPED_TRACE(only);
    diff::Pictures<const double> some;
    PictureValues<double> kept(view.camera, 3);
    if (only == 0) some.color = all.color, kept.color = weights.color;
    if (only == 1) some.alpha = all.alpha, kept.alpha = weights.alpha;
    if (only == 2) some.depth = all.depth, kept.depth = weights.depth;
    if (only == 3)
      some.inverse_depth = all.inverse_depth, kept.inverse_depth = weights.inverse_depth;
    StageFrame<double> frame, moved;
    frame.draw(view, scene);
    StageGradients<double> gradients = frame.gradients(view, scene, some);
    const auto loss = [&] { return moved.draw(view, scene).dot(kept); };
    expect_differences(scene.means, gradients.by.means, 1, loss, "mean");
    expect_differences(scene.opacities, gradients.by.opacities, 1, loss, "opacity");
    // The picture is linear in the background.
    for (std::size_t c = 0; c < 3; ++c) {
      double expected = 0;
      for (std::size_t i = 0; i < frame.pixels.transmittance.size(); ++i) {
        expected +=
            frame.pixels.transmittance[i] * kept.color[c * frame.pixels.transmittance.size() + i];
      }
      EXPECT_NEAR(gradients.boundary.background[c], expected, 1e-12 * (1 + std::abs(expected)));
    }
  }
}

// Opaque layers: pixels stop long before the end of their lists, and alphas are clamped.
TEST(StageGradient, equals_differences_where_pixels_stop_early) {
  DrawnView view = off_centre_view();
  view.rules.alpha_max_passes = false;
  StageScene<double> scene = stage_scene<double>(40, 12);
  for (double& opacity : scene.opacities) opacity = 1.3;
  for (double& scale : scene.scales) scale *= 2;
  auto weights = PictureValues<double>::random(view.camera, 3);
  StageFrame<double> frame, moved;
  frame.draw(view, scene);
  StageGradients<double> gradients = frame.gradients(view, scene, weights.pictures());
  std::size_t stopped = 0;
  for (std::size_t i = 0; i < frame.pixels.transmittance.size(); ++i)
    stopped += frame.pixels.transmittance[i] < 0.01 ? 1 : 0;
  EXPECT_GT(stopped, 200u);
  const auto loss = [&] { return moved.draw(view, scene).dot(weights); };
  expect_differences(scene.means, gradients.by.means, 1, loss, "mean");
  expect_differences(scene.scales, gradients.by.scales, 1, loss, "scale");
  expect_differences(scene.opacities, gradients.by.opacities, 1, loss, "opacity");
  expect_pose_differences(view, gradients.pose, loss);
}

}  // namespace
}  // namespace qs
