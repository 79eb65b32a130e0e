// SPDX-License-Identifier: MIT
// The passes of the differentiable rasterizer: equal to training, with equal bits in all threads
// and lossless modes, for inputs of all kinds, and under the rules of other rasterizers.
#include "learn/step/cpu/passes.h"

#include <cmath>
#include <limits>
#include <thread>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "support/differences.h"
#include "support/error_of.h"
#include "support/stage_scenes.h"

namespace qs {
namespace {

using diff::DrawnView;
using diff::Rows;
using test::BoundaryValues;
using test::off_centre_view;
using test::PictureValues;
using test::pool;
using test::project_backward;
using test::settings_of;
using test::small_scene;
using test::stage_scene;
using test::StageFrame;
using test::StageGradients;
using test::StageScene;
using test::with_channels;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

/// Training's forward and backward pass of a small scene.
struct Trained {
  Camera camera = test::front_camera(test::kWidth, test::kHeight);
  RenderSettings settings;
  test::Parameters<float> scene = small_scene<float>(300, 21);
  std::vector<glm::vec3> weights = test::pixel_weights<float>();
  cpu::train::ForwardFrame<float> frame;
  cpu::train::Gradients<float> gradients;

  Trained(CullMode mode, bool antialiased) : settings(settings_of(mode, antialiased)) {
    const cpu::train::StepView view{camera, settings, pool()};
    cpu::train::BackwardScratch<float> scratch;
    forward(view, scene, frame);
    cpu::train::backward<float>(view, scene, frame, weights, scratch, gradients,
                                {.absolute = true});
  }

  DrawnView drawn() const {
    DrawnView view;
    view.camera = camera;
    view.mode = settings.mode;
    view.rules.antialiased = *settings.antialiased;
    return view;
  }
  test::BlendInput<float> input() const {
    return {{camera.width, camera.height}, {}, 3, {}, &settings.background[0]};
  }
  diff::Pixels<const float> by_color() const {
    return diff::Pixels<const float>::packed(&weights[0][0], camera.width, 3);
  }
};

TEST(Stages, of_a_trained_frame_give_the_bits_of_training_through_the_boundary) {
  for (const bool antialiased : {false, true}) {
    for (const CullMode mode : {find_culler("3dgs"), default_mode()}) {
      const Trained trained(mode, antialiased);
      const std::size_t count = trained.scene.size();
      // Blend the lists of training.
      test::BlendedFrame<float> pixels;
      pixels.resize(trained.input().size, 3, true);
      blend<float>(trained.input(), trained.frame.view(), {pool()}, pixels.state());
      EXPECT_EQ(pixels.transmittance, trained.frame.transmittance);
      EXPECT_EQ(pixels.last, trained.frame.last);
      for (std::size_t i = 0; i < trained.frame.color.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_EQ(pixels.color[3 * i + c], trained.frame.color[i][static_cast<glm::length_t>(c)]);
        }
      }
      // Go back to the boundary, then to the parameters.
      BoundaryValues<float> boundary(count);
      test::PairScratch<float> scratch;
      blend_backward<float>(
          trained.input(), trained.frame.view(), count, std::as_const(pixels).state(),
          {trained.by_color(), {}, {}, {}}, {pool()}, scratch,
          {boundary.rows(), {}, Rows<float>::packed(boundary.absolute_px.data(), 2)});
      const auto stage_rules = diff::PassRules<float>::of(trained.drawn(), 3);
      const auto& by = trained.gradients.by;
      for (std::size_t i = 0; i < count; ++i) {
        const SplatGradient<float> splat{boundary.rows().mean_px.vec2(i),
                                         boundary.rows().conic.vec3(i), boundary.opacity[i],
                                         boundary.rows().color.vec3(i)};
        EXPECT_EQ(splat.mean_px, trained.gradients.mean_px[i]);
        EXPECT_EQ(glm::vec2(boundary.absolute_px[2 * i], boundary.absolute_px[2 * i + 1]),
                  trained.gradients.absolute_px[i]);
        if (trained.frame.listed[i] == 0) continue;
        const auto& p = trained.scene;
        const glm::quat q = unit_rotation(p.rotations[i]);
        const float opacity = opacity_of(p.opacity_logits[i]);
        const auto placed = placed_gradient(stage_rules, to_view(stage_rules.view, p.means[i]),
                                            covariance_of(p.log_scales[i], q), opacity, splat);
        const auto shape =
            covariance_gradient(p.log_scales[i], p.rotations[i], placed.geometry.covariance);
        EXPECT_EQ(shape.log_scale, by.log_scales[i]);
        EXPECT_EQ(shape.rotation, by.rotations[i]);
        EXPECT_EQ(opacity_gradient(opacity, placed.opacity), by.opacity_logits[i]);
      }
    }
  }
}

// The inputs are the parameters as pixels see them: single precision covariances and opacities.
TEST(Stages, of_given_covariances_give_the_picture_and_the_gradients_of_training) {
  for (const bool antialiased : {false, true}) {
    const Trained trained(default_mode(), antialiased);
    const DrawnView view = trained.drawn();
    StageScene<float> scene = stage_scene<float>(300, 21);
    const auto& p = trained.scene;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      for (int k = 0; k < 3; ++k) scene.means[3 * i + static_cast<std::size_t>(k)] = p.means[i][k];
      const Covariance3<double> c =
          covariance_of(glm::dvec3(p.log_scales[i]), unit_rotation(glm::dquat(p.rotations[i])));
      const double values[] = {c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
      for (std::size_t k = 0; k < 6; ++k)
        scene.covariances[6 * i + k] = static_cast<float>(values[k]);
      scene.opacities[i] = static_cast<float>(opacity_of(static_cast<double>(p.opacity_logits[i])));
    }
    scene.has_covariances = true;
    const auto in = scene.inputs();
    StageFrame<float> frame;
    project<float>(view, in, {pool()}, frame.frame);
    frame.pixels.resize(trained.input().size, 3, false);
    blend<float>(trained.input(), frame.frame.view(), {pool()}, frame.pixels.state());
    for (std::size_t i = 0; i < trained.frame.color.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(frame.pixels.color[3 * i + c],
                  trained.frame.color[i][static_cast<glm::length_t>(c)]);
      }
    }
    EXPECT_EQ(frame.frame.in_view, trained.gradients.visible);
    frame.background = {0.2f, 0.5f, 0.9f};
    const auto gradients = frame.gradients(view, scene, {trained.by_color(), {}, {}, {}}, pool());
    const auto& by = trained.gradients.by;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      EXPECT_EQ(gradients.boundary.mean_px[2 * i], trained.gradients.mean_px[i].x);
      EXPECT_EQ(gradients.boundary.mean_px[2 * i + 1], trained.gradients.mean_px[i].y);
      for (std::size_t k = 0; k < by.sh_stride(); ++k) {
        for (std::size_t c = 0; c < 3; ++c) {
          EXPECT_EQ(gradients.by.sh[3 * (i * by.sh_stride() + k) + c],
                    by.sh[i * by.sh_stride() + k][static_cast<glm::length_t>(c)]);
        }
      }
      const float opacity = scene.opacities[i];
      EXPECT_NEAR(opacity_gradient(opacity, gradients.by.opacities[i]), by.opacity_logits[i],
                  1e-4f * (1 + std::abs(by.opacity_logits[i])));
    }
  }
}

TEST(Stages, of_scales_and_rotations_give_the_gradients_of_training) {
  for (const bool antialiased : {false, true}) {
    const Trained trained(default_mode(), antialiased);
    const DrawnView view = trained.drawn();
    const StageScene<float> scene = stage_scene<float>(300, 21);
    StageFrame<float> frame;
    frame.background = {0.2f, 0.5f, 0.9f};
    frame.draw(view, scene);
    const auto gradients = frame.gradients(view, scene, {trained.by_color(), {}, {}, {}});
    std::vector<double> means, log_scales, rotations, logits;
    std::vector<float> by_log_scales, by_logits;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      const auto& by = trained.gradients.by;
      for (int k = 0; k < 3; ++k) {
        const std::size_t at = 3 * i + static_cast<std::size_t>(k);
        means.push_back(static_cast<double>(by.means[i][k]));
        log_scales.push_back(static_cast<double>(by.log_scales[i][k]));
        by_log_scales.push_back(gradients.by.scales[at] * scene.scales[at]);
      }
      const glm::dquat q(by.rotations[i]);
      rotations.insert(rotations.end(), {q.w, q.x, q.y, q.z});
      logits.push_back(static_cast<double>(by.opacity_logits[i]));
      by_logits.push_back(opacity_gradient(scene.opacities[i], gradients.by.opacities[i]));
    }
    test::expect_close(gradients.by.means, means, 1e-4);
    test::expect_close(by_log_scales, log_scales, 1e-4);
    test::expect_close(gradients.by.rotations, rotations, 1e-4);
    test::expect_close(by_logits, logits, 1e-4);
  }
}

/// All bits that a frame gives.
struct Bits {
  PictureValues<float> pictures;
  std::vector<double> gradients;
  bool operator==(const Bits&) const = default;
};

Bits bits_of(const DrawnView& view, const StageScene<float>& scene, ThreadPool& threads) {
  StageFrame<float> frame;
  PictureValues<float> pictures = frame.draw(view, scene, threads);
  auto weights = PictureValues<float>::random(view.camera, scene.channel_count);
  return {std::move(pictures), frame.gradients(view, scene, weights.pictures(), threads).numbers()};
}

TEST(Stages, have_the_same_bits_with_all_threads_and_lossless_modes) {
  DrawnView view = off_centre_view();
  view.rules.antialiased = true;
  for (const StageScene<float>& scene :
       {stage_scene<float>(5000, 22), with_channels(stage_scene<float>(3000, 23), 5)}) {
    view.mode = find_culler("adr");
    const Bits expected = bits_of(view, scene, pool(1));
    for (CullMode mode = 1; mode <= culler_count(); ++mode) {
      if (!row_of(mode).lossless) continue;
      view.mode = mode;
      for (const int threads : {1, 2, 5})
        EXPECT_TRUE(bits_of(view, scene, pool(threads)) == expected) << mode_name(mode) << threads;
    }
  }
}

TEST(Stages, of_several_frames_wait_for_their_backward_passes_in_any_order_and_thread) {
  const StageScene<float> scene = stage_scene<float>(500, 24);
  DrawnView first = off_centre_view(), second = off_centre_view(71, 20);
  second.rules.splat_scale = 1.4;
  const Bits expected_first = bits_of(first, scene, pool(1)),
             expected_second = bits_of(second, scene, pool(1));
  StageFrame<float> frame, other;
  frame.draw(first, scene, pool(2));
  other.draw(second, scene, pool(2));
  auto weights = PictureValues<float>::random(first.camera, 3);
  auto other_weights = PictureValues<float>::random(second.camera, 3);
  const auto gradients_of_first = [&](ThreadPool& threads) {
    return frame.gradients(first, scene, weights.pictures(), threads).numbers();
  };
  EXPECT_EQ(other.gradients(second, scene, other_weights.pictures(), pool(3)).numbers(),
            expected_second.gradients);
  std::thread([&] {
    ThreadPool own(2);
    EXPECT_EQ(gradients_of_first(own), expected_first.gradients);
  }).join();
  EXPECT_EQ(gradients_of_first(pool(2)), expected_first.gradients) << "a second time";
  // Copies of frames are frames.
  const StageFrame<float> copy = frame;
  frame = StageFrame<float>();
  EXPECT_EQ(copy.gradients(first, scene, weights.pictures(), pool(1)).numbers(),
            expected_first.gradients);
}

TEST(Stages, neither_draw_gaussians_with_numbers_that_are_not_finite_nor_give_them_a_gradient) {
  const DrawnView view = off_centre_view();  // mode 3dgs keeps faint Gaussians
  constexpr std::size_t kBad = 7;
  for (const int kind : {0, 1, 2, 3}) {
    StageScene<float> scene =
        kind == 3 ? with_channels(stage_scene<float>(30, 25), 4) : stage_scene<float>(30, 25);
    scene.has_covariances = kind == 1;
    StageScene<float> without = scene;
    without.opacities[kBad] = 0;  // draws nothing
    const Bits expected = bits_of(view, without, pool(1));
    scene.for_each_array([&](const char* name, int numbers, std::vector<float>& values) {
      for (int k = 0; k < numbers; ++k) {
        for (const float bad : {kNan, kInf, -kInf}) {
          SCOPED_TRACE(std::string(name) + " " + std::to_string(k));
          float& value =
              values[kBad * static_cast<std::size_t>(numbers) + static_cast<std::size_t>(k)];
          const float before = std::exchange(value, bad);
          StageFrame<float> frame;
          EXPECT_TRUE(frame.draw(view, scene) == expected.pictures);
          auto weights = PictureValues<float>::random(view.camera, scene.channel_count);
          auto gradients = frame.gradients(view, scene, weights.pictures());
          EXPECT_EQ(frame.frame.projected[kBad], 0);
          gradients.by.for_each_array(
              [&](const char* by_name, int count, const std::vector<float>& by) {
                for (std::size_t i = 0; i < by.size(); ++i) {
                  ASSERT_TRUE(std::isfinite(by[i])) << by_name << i;
                  if (i / static_cast<std::size_t>(count) == kBad) {
                    ASSERT_EQ(by[i], 0) << by_name;
                  }
                }
              });
          for (const double number : gradients.numbers()) {
            // Arrays that are not given keep their inputs.
            if (!std::isfinite(number)) ADD_FAILURE();
          }
          value = before;
        }
      }
    });
  }
}

TEST(Stages, of_no_gaussians_draw_the_background) {
  const DrawnView view = off_centre_view();
  const StageScene<float> scene;
  StageFrame<float> frame;
  const PictureValues<float> pictures = frame.draw(view, scene);
  for (std::size_t i = 0; i < pictures.alpha.size(); ++i) {
    EXPECT_EQ(pictures.color[i], frame.background[0]);
    EXPECT_EQ(pictures.alpha[i] + pictures.depth[i] + pictures.inverse_depth[i], 0);
  }
  auto weights = PictureValues<float>::random(view.camera, 3);
  const auto gradients = frame.gradients(view, scene, weights.pictures());
  EXPECT_EQ(gradients.pose.view_from_world, glm::dmat4x3(0.0));
  EXPECT_EQ(gradients.pose.position, glm::dvec3(0));
  EXPECT_NE(gradients.boundary.background[0], 0);
}

TEST(Stages, draw_pictures_of_one_pixel) {
  DrawnView view = off_centre_view(1, 1);
  view.camera.center_px = {0, 0};
  const StageScene<float> scene = stage_scene<float>(50, 26);
  const Bits bits = bits_of(view, scene, pool(3));
  EXPECT_GT(bits.pictures.alpha[0], 0);
  EXPECT_TRUE(bits_of(view, scene, pool(1)) == bits);
}

TEST(Stages, refuse_inputs_that_do_not_fit_together) {
  const StageScene<float> scene = stage_scene<float>(3, 27);
  const auto error = [&](const std::function<void(DrawnView&)>& change_view,
                         const std::function<void(test::GaussianInputs<float>&)>& change) {
    DrawnView view = off_centre_view();
    test::GaussianInputs<float> in = scene.inputs();
    if (change_view) change_view(view);
    if (change) change(in);
    test::ProjectedFrame<float> frame;
    return test::error_of([&] { project<float>(view, in, {pool(1)}, frame); });
  };
  EXPECT_EQ(error({}, {}), "");
  EXPECT_EQ(error([](DrawnView& v) { v.camera.width = 0; }, {}),
            "project: the picture has 0 x 35 pixels; both sides must be 1 to 32768");
  EXPECT_EQ(error([](DrawnView& v) { v.camera.height = 40000; }, {}),
            "project: the picture has 45 x 40000 pixels; both sides must be 1 to 32768");
  EXPECT_EQ(error([](DrawnView& v) { v.camera.focal_px.x = 0; }, {}),
            "project: focal lengths must be above 0");
  EXPECT_EQ(error([](DrawnView& v) { v.camera.view_from_world[3][1] = kNan; }, {}),
            "project: the camera has a number that is not finite");
  EXPECT_EQ(error([](DrawnView& v) { v.mode = kReferenceMode; }, {}),
            "project: the culling mode must be a mode that lists tiles");
  EXPECT_EQ(error([](DrawnView& v) { v.rules.far_depth = 0.1; }, {}),
            "project: the far plane must be behind the near plane");
  EXPECT_EQ(error([](DrawnView& v) { v.rules.alpha_max = 1; }, {}),
            "project: the largest alpha must be above 0 and below 1");
  EXPECT_EQ(error([](DrawnView& v) { v.rules.splat_scale = -1; }, {}),
            "project: the scale of splats must be above 0");
  EXPECT_EQ(error({}, [](auto& in) { in.means = {}; }), "project: means and opacities are missing");
  EXPECT_EQ(error({}, [](auto& in) { in.covariances = in.means; }),
            "project: either covariances or both scales and rotations must be given");
  EXPECT_EQ(error({}, [](auto& in) { in.rotations = {}; }),
            "project: either covariances or both scales and rotations must be given");
  EXPECT_EQ(error({}, [](auto& in) { in.channels = in.means; }),
            "project: either coefficients of colour or channels must be given");
  EXPECT_EQ(error({}, [](auto& in) { in.sh.rest = {}; }),
            "project: the coefficients of colour beyond DC are missing");
  EXPECT_EQ(error({}, [](auto& in) { in.channel_count = 33; }),
            "project: the number of channels must be 1 to 32");
  EXPECT_EQ(test::error_of([&] {
              const std::vector<std::uint8_t> projected(2);
              project_backward<float>(off_centre_view(), scene.inputs(), projected, {}, {pool(1)},
                                      {});
            }),
            "project_backward: the frame has 2 Gaussians, the inputs have 3");

  const DrawnView view = off_centre_view();
  StageFrame<float> frame;
  PictureValues<float> pictures = frame.draw(view, scene);
  test::BlendInput<float> blended = frame.input(view, scene.inputs());
  const auto blend_error = [&](bool with_depth) {
    frame.pixels.resize(blended.size, 5, with_depth);
    return test::error_of([&] {
      blend<float>(blended, frame.frame.view(), {pool(1)}, frame.pixels.state(),
                   pictures.pictures());
    });
  };
  EXPECT_EQ(blend_error(false), "blend: depths are wanted, but the frame has no arrays for them");
  blended.channel_count = 5;
  EXPECT_EQ(blend_error(true), "blend: the frame's colours have 3 channels, not 5");
  blended.channel_count = 0;
  EXPECT_EQ(blend_error(true), "blend: there are 0 channels; the number must be 1 to 32");
}

TEST(Stages, outside_of_the_view_have_a_row_in_the_boundary_but_no_gradient_from_pixels) {
  const DrawnView view = off_centre_view();
  StageScene<float> scene = stage_scene<float>(4, 28);
  scene.means[0] += 30;      // beside the image
  scene.means[3 + 2] = -20;  // behind the camera
  StageFrame<float> frame;
  BoundaryValues<float> boundary(4);
  std::vector<std::int32_t> radii(8, -1);
  project<float>(view, scene.inputs(), {pool(1)}, frame.frame, boundary.rows(),
                 Rows<std::int32_t>::packed(radii.data(), 2));
  EXPECT_EQ(frame.frame.projected, (std::vector<std::uint8_t>{1, 0, 1, 1}));
  EXPECT_EQ(frame.frame.listed, (std::vector<std::uint8_t>{0, 0, 1, 1}));
  EXPECT_GT(boundary.depth[0], 0);
  EXPECT_GT(boundary.mean_px[0], test::kWidth);
  EXPECT_EQ(boundary.depth[1], 0);
  EXPECT_EQ(boundary.conic[3], 0);
  EXPECT_EQ(radii[0] + radii[1] + radii[2] + radii[3], 0);
  EXPECT_GT(radii[4], 0);
  frame.draw(view, scene);
  auto weights = PictureValues<float>::random(view.camera, 3);
  const auto gradients = frame.gradients(view, scene, weights.pictures());
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(gradients.by.means[k], 0);
    EXPECT_EQ(gradients.by.scales[k], 0);
    EXPECT_NE(gradients.by.means[k + 6], 0);
  }
}

TEST(Stages, read_and_write_strided_and_expanded_arrays) {
  const DrawnView view = off_centre_view();
  StageScene<float> scene = stage_scene<float>(60, 29);
  for (float& opacity : scene.opacities) opacity = 0.7f;
  const std::size_t count = scene.size();
  const Bits expected = bits_of(view, scene, pool(1));
  // Interleaved means and scales, rotations column by column, one opacity for all, DC apart.
  std::vector<float> both(6 * count), columns(4 * count), dc(3 * count), rest(45 * count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      both[6 * i + k] = scene.means[3 * i + k];
      both[6 * i + 3 + k] = scene.scales[3 * i + k];
      dc[3 * i + k] = scene.sh[48 * i + k];
    }
    for (std::size_t k = 0; k < 4; ++k) columns[k * count + i] = scene.rotations[4 * i + k];
    // Channel by channel.
    for (std::size_t k = 0; k < 15; ++k) {
      for (std::size_t c = 0; c < 3; ++c)
        rest[45 * i + 15 * c + k] = scene.sh[48 * i + 3 * (k + 1) + c];
    }
  }
  test::GaussianInputs<float> in = scene.inputs();
  in.means = {both.data(), 6, 1};
  in.scales = {both.data() + 3, 6, 1};
  in.rotations = {columns.data(), 1, static_cast<std::ptrdiff_t>(count)};
  in.opacities = {scene.opacities.data(), 0, 1};
  in.sh = {{dc.data(), 3, 1}, {rest.data(), 45, 15}, 1};
  StageFrame<float> frame;
  EXPECT_TRUE(frame.draw(view, in) == expected.pictures);

  // One weight for all pixels and channels.
  const float one = 0.25f;
  const diff::Pixels<const float> expanded{&one, 0, 0, 0};
  PictureValues<float> filled(view.camera, 3);
  std::fill(filled.color.begin(), filled.color.end(), one);
  const auto gradients = frame.gradients(view, scene, {filled.pictures().color, {}, {}, {}});
  EXPECT_EQ(frame.gradients(view, scene, {expanded, {}, {}, {}}).numbers(), gradients.numbers());
  std::vector<float> d_both(6 * count), d_columns(4 * count), d_dc(3 * count), d_rest(45 * count);
  BoundaryValues<float> boundary = gradients.boundary;
  project_backward<float>(view, in, frame.frame.projected, boundary.rows(), {pool(1)},
                          {{d_both.data(), 6, 1},
                           {d_both.data() + 3, 6, 1},
                           {d_columns.data(), 1, static_cast<std::ptrdiff_t>(count)},
                           {},
                           {},
                           {{d_dc.data(), 3, 1}, {d_rest.data(), 45, 15}, 1}});
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(d_both[6 * i + k], gradients.by.means[3 * i + k]);
      EXPECT_EQ(d_both[6 * i + 3 + k], gradients.by.scales[3 * i + k]);
      EXPECT_EQ(d_dc[3 * i + k], gradients.by.sh[48 * i + k]);
      EXPECT_EQ(d_rest[45 * i + 15 * k + 14], gradients.by.sh[48 * i + 45 + k]);
    }
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_EQ(d_columns[k * count + i], gradients.by.rotations[4 * i + k]);
  }
}

TEST(Stages, sum_absolute_gradients_over_pixels) {
  const DrawnView view = off_centre_view(19, 18);
  const StageScene<double> scene = stage_scene<double>(12, 30);
  StageFrame<double> frame;
  frame.draw(view, scene);
  auto weights = PictureValues<double>::random(view.camera, 3);
  std::vector<double> expected(2 * scene.size());
  for (int y = 0; y < 18; ++y) {
    for (int x = 0; x < 19; ++x) {
      PictureValues<double> alone(view.camera, 3);
      const auto to = alone.pictures(), from = weights.pictures();
      for (int c = 0; c < 3; ++c) to.color.at(x, y, c) = from.color.at(x, y, c);
      to.alpha.at(x, y) = from.alpha.at(x, y);
      to.depth.at(x, y) = from.depth.at(x, y);
      const auto by = frame.gradients(view, scene, to).boundary.mean_px;
      for (std::size_t k = 0; k < by.size(); ++k) expected[k] += std::abs(by[k]);
    }
  }
  const auto all = weights.pictures();
  const auto gradients = frame.gradients(view, scene, {all.color, all.alpha, all.depth, {}});
  test::expect_close(gradients.boundary.absolute_px, expected, 1e-12);
}

// ---- rules

/// A large Gaussian in front of the camera's middle, of one colour in every direction.
StageScene<double> one_splat(double opacity, double color = 0.5) {
  StageScene<double> scene = stage_scene<double>(1, 31);
  scene.means = {0, 0, 3};
  scene.scales = {0.5, 0.5, 0.5};
  scene.rotations = {1, 0, 0, 0};
  scene.opacities = {opacity};
  scene.sh_degree = 0;
  scene.sh.assign(3, (color - 0.5) / kSh0);
  return scene;
}

DrawnView straight_view() {
  DrawnView view;
  view.camera = test::front_camera(33, 33);
  view.camera.view_from_world = glm::dmat4x3(1.0);
  view.camera.center_px = {16, 16};
  return view;
}
constexpr std::size_t kMiddle = 16 * 33 + 16;

TEST(PassRules, the_largest_alpha_clamps_pixels_and_may_stop_their_gradients) {
  DrawnView view = straight_view();
  const StageScene<double> scene = one_splat(0.9999);
  auto weights = PictureValues<double>(view.camera, 3);
  weights.color[kMiddle] = 1;
  for (const double largest : {0.99, 0.999}) {
    for (const bool passes : {true, false}) {
      view.rules.alpha_max = largest;
      view.rules.alpha_max_passes = passes;
      StageFrame<double> frame;
      EXPECT_DOUBLE_EQ(frame.draw(view, scene).alpha[kMiddle], largest);
      const auto gradients = frame.gradients(view, scene, weights.pictures());
      EXPECT_EQ(gradients.by.opacities[0] != 0, passes);
      EXPECT_NE(gradients.by.sh[0], 0);
    }
  }
}

TEST(PassRules, a_pixel_stops_below_the_least_transmittance_or_also_at_it) {
  DrawnView view = straight_view();
  view.rules.alpha_max = 0.99;
  // Two opaque layers leave a transmittance that becomes the limit.
  StageScene<double> scene = one_splat(1);
  const StageScene<double> layer = scene;
  const auto append = [&](double z) {
    scene.means.insert(scene.means.end(), {0, 0, z});
    scene.scales.insert(scene.scales.end(), layer.scales.begin(), layer.scales.end());
    scene.rotations.insert(scene.rotations.end(), layer.rotations.begin(), layer.rotations.end());
    scene.opacities.push_back(1);
    scene.sh.insert(scene.sh.end(), layer.sh.begin(), layer.sh.end());
  };
  append(4);
  StageFrame<double> frame;
  const auto rules = [&](bool at_equal) {
    view.rules.stops_at_equal = at_equal;
    return view.rules.pixel_rules<double>();
  };
  EXPECT_EQ(rules(false).stops_below, fp64::kTransmittanceMin);
  EXPECT_EQ(rules(true).stops_below, std::nextafter(fp64::kTransmittanceMin, 1.0));
  EXPECT_EQ(view.rules.pixel_rules<float>().stops_below, std::nextafter(kTransmittanceMin, 1.0f));
  // (1 - 0.99)^2 is just at the limit: it rounds to 1e-4 or to its upper neighbour.
  const double next = (1 - 0.99) * (1 - 0.99);
  ASSERT_NEAR(next, 1e-4, 1e-18);
  for (const bool at_equal : {false, true}) {
    const bool stops = next < rules(at_equal).stops_below;
    frame.draw(view, scene);
    EXPECT_EQ(frame.pixels.last[kMiddle], stops ? 1u : 2u) << at_equal;
  }
}

TEST(PassRules, a_channel_of_exactly_0_may_pass_its_gradient) {
  DrawnView view = straight_view();
  auto weights = PictureValues<double>(view.camera, 3);
  weights.color[kMiddle] = 1;
  for (const bool passes : {false, true}) {
    view.rules.zero_color_passes = passes;
    StageScene<double> scene = one_splat(0.5);
    const auto gradient = [&](double coefficient) {
      scene.sh.assign(3, coefficient);
      StageFrame<double> frame;
      frame.draw(view, scene);
      return frame.gradients(view, scene, weights.pictures()).by.sh[0];
    };
    const double black = -0.5 / kSh0;
    ASSERT_EQ(kSh0 * black + 0.5, 0);
    EXPECT_EQ(gradient(black) != 0, passes);
    EXPECT_NE(gradient(black + 1e-9), 0);
    EXPECT_EQ(gradient(black - 1e-9), 0);
  }
}

TEST(PassRules, planes_limit_the_depths_that_are_drawn) {
  DrawnView view = straight_view();
  const StageScene<float> scene = stage_scene<float>(1, 31);
  StageScene<float> at = scene;
  at.means = {0, 0, 3};
  const auto projected = [&](double near_depth, double far_depth) {
    view.rules.near_depth = near_depth;
    view.rules.far_depth = far_depth;
    test::ProjectedFrame<float> frame;
    project<float>(view, at.inputs(), {pool(1)}, frame);
    return frame.projected[0] == 1;
  };
  EXPECT_TRUE(projected(0.2, 1e10));
  EXPECT_TRUE(projected(0, 3)) << "at the far plane";
  EXPECT_FALSE(projected(3, 10)) << "at the near plane";
  EXPECT_FALSE(projected(0, 2.9));
  EXPECT_FALSE(projected(3.1, 10));
}

TEST(PassRules, slopes_have_four_limits) {
  DrawnView view = straight_view();
  StageScene<double> scene = one_splat(0.5);
  scene.scales = {0.1, 0.1, 0.5};  // long in depth: the slope stretches it
  const auto conic_at = [&](double x, double y) {
    scene.means = {3 * x, 3 * y, 3};
    test::ProjectedFrame<double> frame;
    BoundaryValues<double> boundary(1);
    project<double>(view, scene.inputs(), {pool(1)}, frame, boundary.rows());
    return glm::dvec3(boundary.conic[0], boundary.conic[1], boundary.conic[2]);
  };
  view.rules.slopes = diff::SlopeBounds{{-0.1, -0.2}, {0.3, 0.4}};
  EXPECT_EQ(conic_at(-0.2, 0), conic_at(-0.1, 0));
  EXPECT_EQ(conic_at(0.5, 0), conic_at(0.3, 0));
  EXPECT_EQ(conic_at(0, -0.5), conic_at(0, -0.2));
  EXPECT_EQ(conic_at(0, 0.6), conic_at(0, 0.4));
  EXPECT_NE(conic_at(0.2, 0), conic_at(0.3, 0));
  EXPECT_NE(conic_at(-0.05, 0), conic_at(-0.1, 0));
  // The default limits are 1.3 times the half field of view of a centred camera.
  const double half = 0.5 * 33 / view.camera.focal_px.x;
  view.rules.slopes.reset();
  const auto by_default = conic_at(2, -0.2);
  view.rules.slopes = diff::SlopeBounds{glm::dvec2(-1.3 * half), glm::dvec2(1.3 * half)};
  EXPECT_LT(glm::distance(conic_at(2, -0.2), by_default), 1e-12);
}

TEST(PassRules, radii_follow_the_formulas_of_published_code) {
  DrawnView view = straight_view();
  StageScene<float> scene = stage_scene<float>(200, 32);
  scene.opacities[0] = 0.003f;  // below 1/255
  for (std::size_t k = 0; k < 3; ++k) scene.means[k] = k == 2 ? 3.0f : 0.0f;
  const auto radii_by = [&](RadiusRule rule, CullMode mode) {
    view.rules.radius_rule = rule;
    view.mode = mode;
    std::vector<std::int32_t> radii(400, -1);
    test::ProjectedFrame<float> frame;
    project<float>(view, scene.inputs(), {pool(1)}, frame, {},
                   Rows<std::int32_t>::packed(radii.data(), 2));
    return radii;
  };
  BoundaryValues<float> boundary(200);
  test::ProjectedFrame<float> frame;
  project<float>(view, scene.inputs(), {pool(1)}, frame, boundary.rows());
  const auto inria = radii_by(RadiusRule::inria, find_culler("3dgs"));
  const auto square = radii_by(RadiusRule::gsplat_1_4, default_mode());
  const auto tight = radii_by(RadiusRule::gsplat_1_5, default_mode());
  EXPECT_EQ(radii_by(RadiusRule::inria, default_mode()), inria) << "no mode changes them";
  EXPECT_GT(inria[0], 0);
  EXPECT_GT(square[0], 0);
  EXPECT_EQ(tight[0], 0) << "too faint there";
  int inside = 0;
  for (std::size_t i = 0; i < 200; ++i) {
    ASSERT_EQ(frame.projected[i], 1);
    // The covariance is the inverse of the conic.
    const double a = boundary.conic[3 * i], b = boundary.conic[3 * i + 1],
                 c = boundary.conic[3 * i + 2], determinant = a * c - b * b;
    const double xx = c / determinant, yy = a / determinant, mid = (xx + yy) / 2,
                 spread = mid * mid - 1 / determinant;
    const auto sigma = [&](double least) {
      return std::sqrt(mid + std::sqrt(std::max(least, spread)));
    };
    const double x = boundary.mean_px[2 * i] + 0.5, y = boundary.mean_px[2 * i + 1] + 0.5;
    const auto expect_radius = [&](int radius, double expected, const char* what) {
      const double nearest = std::round(expected);
      if (std::abs(expected - nearest) < 1e-3) return;  // either side of the step
      EXPECT_EQ(radius, std::ceil(expected)) << what << i;
    };
    const double half = 3 * sigma(0.01);
    if (x + half > 1 && x - half < 32 && y + half > 1 && y - half < 32) {
      ++inside;
      expect_radius(square[2 * i], half, "gsplat 1.4");
      EXPECT_EQ(square[2 * i], square[2 * i + 1]);
    }
    if (x > 0 && y > 0 && x < 33 && y < 33) {
      expect_radius(inria[2 * i], 3 * sigma(0.1), "inria");
      const double opacity = boundary.opacity[i];
      if (opacity > 1.0 / 255) {
        const double sigmas = std::min(3.33, std::sqrt(2 * std::log(255 * opacity)));
        expect_radius(tight[2 * i], sigmas * std::sqrt(xx), "gsplat 1.5, x");
        expect_radius(tight[2 * i + 1], sigmas * std::sqrt(yy), "gsplat 1.5, y");
      }
    }
    if (x < -half - 1 || y < -half - 1 || x > half + 34 || y > half + 34) {
      EXPECT_EQ(square[2 * i] + tight[2 * i], 0) << i;
    }
  }
  EXPECT_GT(inside, 20);
}

TEST(PassRules, gaussians_with_small_radii_may_be_left_out) {
  DrawnView view = straight_view();
  view.rules.radius_rule = RadiusRule::gsplat_1_4;
  const StageScene<float> scene = stage_scene<float>(100, 33);
  std::vector<std::int32_t> all(200), radii(200);
  test::ProjectedFrame<float> frame;
  project<float>(view, scene.inputs(), {pool(1)}, frame, {},
                 Rows<std::int32_t>::packed(all.data(), 2));
  view.rules.radius_clip = 8;
  project<float>(view, scene.inputs(), {pool(1)}, frame, {},
                 Rows<std::int32_t>::packed(radii.data(), 2));
  int left_out = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    const bool small = all[2 * i] <= 8;
    EXPECT_EQ(frame.projected[i], small ? 0 : 1) << i;
    EXPECT_EQ(radii[2 * i], small ? 0 : all[2 * i]) << i;
    left_out += small ? 1 : 0;
  }
  EXPECT_GT(left_out, 3);
  EXPECT_LT(left_out, 97);
}

}  // namespace
}  // namespace qs
