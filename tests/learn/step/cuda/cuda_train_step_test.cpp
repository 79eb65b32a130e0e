// SPDX-License-Identifier: MIT
// The loss, the optimizer and the density statistics on the GPU, compared with the CPU's.
#include <algorithm>

#include <fmt/format.h>

#include "learn/step/cpu/cpu_model.h"
#include "learn/step/cpu/loss.h"
#include "learn/step/cpu/passes.h"
#include "learn/step/cuda/gpu_model.h"
#include "raster/scene/image_metrics.h"
#include "support/gpu.h"
#include "support/scenes.h"
#include "support/train_scenes.h"

namespace qs::cuda::train {
namespace {

using test::groups_of;
using test::kHeight;
using test::kWidth;
using test::small_scene;
using test::start;
using Scene = cpu::train::Parameters<float>;

constexpr Rates kRates{1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3, 7e-3};

class CudaTrainStep : public test::GpuTest {};

std::vector<glm::vec3> random_target(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0, 1);
  std::vector<glm::vec3> target(static_cast<std::size_t>(width * height));
  for (glm::vec3& pixel : target)
    pixel = glm::vec3(uniform(random), uniform(random), uniform(random));
  return target;
}

std::vector<std::uint8_t> random_bytes(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> byte(0, 255);
  std::vector<std::uint8_t> bytes(count);
  for (std::uint8_t& value : bytes) value = static_cast<std::uint8_t>(byte(random));
  return bytes;
}

std::vector<std::uint8_t> every_third_masked(std::size_t pixels) {
  std::vector<std::uint8_t> mask(pixels, 1);
  for (std::size_t i = 1; i < pixels; i += 3) mask[i] = 0;
  return mask;
}

void draw(GpuModel& model, int width = kWidth, int height = kHeight) {
  model.forward(test::front_camera(width, height), test::settings_of(default_mode(), false));
}

TEST_F(CudaTrainStep, the_loss_and_its_gradient_equal_those_of_the_cpu) {
  GpuModel model;
  start(model, small_scene<float>(200, 1));
  for (const auto& [width, height] : {std::pair{61, 47}, {5, 4}, {1, 30}, {30, 1}}) {
    draw(model, width, height);
    auto target = random_target(width, height, 2);
    const auto color = model.pixels().color;
    target[0] = color[0];  // without a derivative of L1
    for (const bool has_mask : {false, true}) {
      const auto mask = has_mask ? every_third_masked(target.size()) : std::vector<std::uint8_t>();
      model.compare(target, mask);
      cpu::train::SsimFields<float> scratch;
      std::vector<glm::vec3> expected_gradient;
      const Loss expected = cpu::train::compare<float>({width, height, color, target, mask},
                                                       test::pool(), scratch, expected_gradient);
      const Loss loss = model.loss();
      EXPECT_NEAR(loss.total, expected.total, 1e-12);
      EXPECT_NEAR(loss.l1, expected.l1, 1e-12);
      EXPECT_NEAR(loss.ssim, expected.ssim, 1e-12);
      EXPECT_NEAR(loss.squared_error, expected.squared_error, 1e-12);
      EXPECT_EQ(model.pixel_gradients(), expected_gradient)
          << width << "x" << height << (has_mask ? " with a mask" : "");
    }
  }
}

TEST_F(CudaTrainStep, photographs_on_the_gpu_are_compared_over_the_frames_background) {
  constexpr std::size_t kPixels = kWidth * kHeight;
  const auto rgb = random_bytes(3 * kPixels, 6), alpha = random_bytes(kPixels, 7);
  GpuModel model;
  start(model, small_scene<float>(20, 14));
  draw(model);
  const glm::dvec3 background(test::settings_of(default_mode(), false).background);
  for (const bool has_alpha : {false, true}) {
    model.compare_with(has_alpha ? 1 : 0, has_alpha ? qs::train::Photograph{rgb, alpha, {}}
                                                    : qs::train::Photograph{rgb, {}, {}});
    const Loss loss = model.loss();
    const auto gradient = model.pixel_gradients();
    std::vector<glm::vec3> target(kPixels);
    for (std::size_t i = 0; i < kPixels; ++i) {
      const glm::dvec3 color(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]);
      target[i] = (color + (has_alpha ? background * (255.0 - alpha[i]) : glm::dvec3(0))) / 255.0;
    }
    model.compare(target);
    EXPECT_NEAR(loss.total, model.loss().total, 1e-6);
    EXPECT_GT(loss.total, 0.1);
    const auto expected = model.pixel_gradients();
    for (std::size_t i = 0; i < kPixels; ++i) {
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(gradient[i][c], expected[i][c], 1e-7);
    }
  }
}

TEST_F(CudaTrainStep,
       masks_of_photographs_leave_their_pixels_out_whether_the_gpu_keeps_them_or_not) {
  constexpr std::size_t kPixels = kWidth * kHeight;
  const std::vector<std::uint8_t> rgb(3 * kPixels, 150), mask = every_third_masked(kPixels);
  GpuModel model;
  start(model, small_scene<float>(20, 14));
  draw(model);
  model.compare(std::vector<glm::vec3>(kPixels, glm::vec3(150.0f / 255)), mask);
  const Loss expected = model.loss();
  const auto gradient = model.pixel_gradients();
  EXPECT_EQ(gradient[1], glm::vec3(0)) << "masked";
  for (const std::optional<std::size_t> number : {std::optional<std::size_t>(3), {}}) {
    for (int use = 0; use < 2; ++use) {
      model.compare_with(number, {rgb, {}, mask});
      EXPECT_EQ(model.loss().total, expected.total);
      EXPECT_EQ(model.pixel_gradients(), gradient);
      model.compare_with(std::nullopt, {rgb, {}, {}});
      EXPECT_NE(model.loss().total, expected.total);
    }
  }
}

TEST_F(CudaTrainStep, the_quality_of_a_view_is_that_of_the_cpu_and_the_passes_do_not_notice) {
  Scene scene = small_scene<float>(200, 1);
  for (glm::vec3& value : scene.sh) value *= 3;  // values below 0 and above 1
  GpuModel model;
  start(model, scene);
  const auto cpu = qs::train::make_training_model(Backend::cpu, test::pool());
  start(*cpu, scene);
  bool clamps = false;
  for (const auto& [width, height] :
       {std::pair{61, 47}, {5, 4}, {1, 30}, {30, 1}, {16, 16}, {33, 50}}) {
    const auto pixels = static_cast<std::size_t>(width * height);
    const auto alpha = random_bytes(pixels, 22);
    std::vector<std::uint8_t> rgb = random_bytes(3 * pixels, 21);
    for (std::size_t i = 0; i < rgb.size(); ++i)  // over black
      rgb[i] = static_cast<std::uint8_t>(rgb[i] * alpha[i / 3] / 255);
    std::vector<std::uint8_t> one_left(pixels, 0);
    one_left[pixels / 2] = 1;
    draw(model, width, height);
    cpu->forward(test::front_camera(width, height), test::settings_of(default_mode(), false), {});
    Image picture(width, height, 3), target(width, height, 3);
    const auto color = model.pixels().color;
    std::copy_n(&color[0][0], picture.values.size(), picture.values.begin());
    clamps = clamps || std::ranges::any_of(picture.values, [](float v) { return v > 1; });
    clamp_to_unit(picture);
    for (const auto& mask : {std::vector<std::uint8_t>(), every_third_masked(pixels), one_left}) {
      for (const bool has_alpha : {false, true}) {
        SCOPED_TRACE(
            fmt::format("{}x{}, {} masks, alpha {}", width, height, mask.size(), has_alpha));
        const qs::train::Photograph photograph = has_alpha ? qs::train::Photograph{rgb, alpha, mask}
                                                           : qs::train::Photograph{rgb, {}, mask};
        const auto over = photograph.over(test::settings_of(default_mode(), false).background);
        std::copy_n(&over[0][0], target.values.size(), target.values.begin());
        model.compare_with(std::nullopt, photograph);
        const auto gradient = model.pixel_gradients();
        const Loss loss = model.loss();
        const qs::train::Quality quality = model.quality(photograph);
        EXPECT_NEAR(quality.psnr, psnr(picture, target, test::pool(), mask), 1e-9);
        EXPECT_NEAR(quality.ssim, ssim(picture, target, test::pool(), SsimBorder::zeros, mask),
                    1e-9);
        const qs::train::Quality expected = cpu->quality(photograph),
                                 again = model.quality(photograph);
        EXPECT_NEAR(quality.psnr, expected.psnr, 1e-5);
        EXPECT_NEAR(quality.ssim, expected.ssim, 1e-6);
        EXPECT_EQ(quality.psnr, again.psnr);
        EXPECT_EQ(quality.ssim, again.ssim);
        EXPECT_EQ(model.loss().total, loss.total);
        EXPECT_EQ(model.pixel_gradients(), gradient);
      }
    }
  }
  EXPECT_TRUE(clamps);
}

TEST_F(CudaTrainStep, adam_takes_the_steps_of_the_cpu_bit_for_bit) {
  Scene parameters = test::with_masks(small_scene<float>(100, 3));
  auto state = cpu::train::AdamState::like(parameters);
  GpuModel model;
  start(model, parameters);
  const auto target = random_target(kWidth, kHeight, 4);
  for (int step = 0; step < 5; ++step) {
    draw(model);
    model.compare(target);
    model.backward({});
    const Scene by = model.gradients().by;
    model.step(test::counted_step(kRates));
    cpu::train::take_step(parameters, by, kRates, state, test::pool());
  }
  EXPECT_EQ(groups_of(model.state().parameters), groups_of(parameters));
  EXPECT_EQ(groups_of(model.state().adam.first), groups_of(state.first));
  EXPECT_EQ(groups_of(model.state().adam.second), groups_of(state.second));
}

TEST_F(CudaTrainStep, steps_with_summed_gradients_are_those_of_the_cpu_bit_for_bit) {
  Scene parameters = test::with_masks(small_scene<float>(101, 3));
  auto state = cpu::train::AdamState::like(parameters);
  Scene sums;
  GpuModel model;
  start(model, parameters);
  const auto target = random_target(kWidth, kHeight, 4);
  for (const auto& [moves, rest_waits] : {std::pair{true, false},
                                          {false, false},
                                          {true, true},
                                          {true, true},
                                          {true, false},
                                          {false, true},
                                          {false, true},
                                          {true, true}}) {
    draw(model);
    model.compare(target);
    model.backward({});
    const Scene by = model.gradients().by;
    qs::train::StepOrder order = test::counted_step(kRates);
    order.sums = true;
    order.moves = moves;
    order.rest_waits = rest_waits;
    model.step(order);
    cpu::train::add_gradients(by, test::pool(), sums);
    if (moves) {
      cpu::train::take_step(parameters, sums, kRates, state, test::pool(), !rest_waits);
      cpu::train::clear_sums(!rest_waits, sums);
    }
    EXPECT_EQ(groups_of(model.state().summed), groups_of(sums));
    model.set_state(model.state());
  }
  EXPECT_EQ(sums.size(), 101u);
  EXPECT_EQ(groups_of(model.state().parameters), groups_of(parameters));
  EXPECT_EQ(groups_of(model.state().adam.first), groups_of(state.first));
  EXPECT_EQ(groups_of(model.state().adam.second), groups_of(state.second));
  EXPECT_EQ(model.state().adam.steps, state.steps);
  EXPECT_EQ(model.state().adam.rest_steps, state.rest_steps);
  EXPECT_LT(state.rest_steps, state.steps);
}

TEST_F(CudaTrainStep, sparsity_and_noise_are_those_of_the_cpu) {
  const Scene scene = small_scene<float>(80, 16);
  GpuModel model;
  start(model, scene);
  draw(model);
  model.compare(random_target(kWidth, kHeight, 17));
  model.backward({});
  const Scene by = model.gradients().by;
  const auto cpu = qs::train::make_training_model(Backend::cpu, test::pool());
  for (const bool sparse : {true, false}) {
    qs::train::StepOrder order;
    order.moves = sparse;
    order.rates = kRates;
    if (sparse) order.sparsity = Sparsity{30, 20};
    if (!sparse) order.noise = Noise{{1e-2}, Random::of(1, RandomUse::noise, 2)};
    start(model, scene);
    model.step(order);
    Scene expected = scene;
    if (sparse) {
      Scene total = by;
      for (std::size_t i = 0; i < scene.size(); ++i) {
        order.sparsity->add_gradient(80, scene.log_scales[i], scene.opacity_logits[i],
                                     total.log_scales[i], total.opacity_logits[i]);
      }
      auto state = cpu::train::AdamState::like(expected);
      cpu::train::take_step(expected, total, kRates, state, test::pool());
      EXPECT_NE(total.log_scales, by.log_scales);
      EXPECT_NE(total.opacity_logits, by.opacity_logits);
    } else {
      start(*cpu, scene);
      cpu->step(order);
      expected = cpu->state().parameters;
      EXPECT_NE(expected.means, scene.means);
    }
    const auto groups = groups_of(model.state().parameters), wanted = groups_of(expected);
    for (std::size_t group = 0; group < groups.size(); ++group) {
      for (std::size_t i = 0; i < groups[group].size(); ++i)
        ASSERT_NEAR(groups[group][i], wanted[group][i], 1e-6) << "group " << group;
    }
  }
}

TEST_F(CudaTrainStep, the_weight_of_the_mean_mask_is_that_of_the_cpu) {
  const Scene scene = test::with_masks(small_scene<float>(80, 16));
  GpuModel model;
  start(model, scene);
  draw(model);
  model.compare(random_target(kWidth, kHeight, 17));
  model.backward({});
  Scene total = model.gradients().by;
  const std::vector<float> before = total.mask_logits;
  qs::train::StepOrder order;
  order.rates = kRates;
  order.mask_weight = 30;
  model.step(order);
  for (std::size_t i = 0; i < scene.size(); ++i)
    total.mask_logits[i] += mask_weight_gradient(30, 80, scene.mask_logits[i]);
  EXPECT_NE(total.mask_logits, before);
  Scene expected = scene;
  auto state = cpu::train::AdamState::like(expected);
  cpu::train::take_step(expected, total, kRates, state, test::pool());
  const auto groups = groups_of(model.state().parameters), wanted = groups_of(expected);
  for (std::size_t group = 0; group < groups.size(); ++group) {
    for (std::size_t i = 0; i < groups[group].size(); ++i)
      ASSERT_NEAR(groups[group][i], wanted[group][i], 1e-6) << "group " << group;
  }
}

TEST_F(CudaTrainStep, the_memory_in_use_contains_the_colours_and_their_moments) {
  GpuModel model;
  start(model, small_scene<float>(50000, 20));
  EXPECT_GE(model.gpu_memory_bytes(), 3 * 48 * sizeof(float) * 50000);
}

TEST_F(CudaTrainStep, the_recent_loss_is_known_one_comparison_later) {
  GpuModel model;
  start(model, small_scene<float>(30, 18));
  double before = 0;
  for (unsigned i = 0; i < 4; ++i) {
    draw(model);
    model.compare(random_target(kWidth, kHeight, i));
    const double newest = model.loss().total;
    EXPECT_EQ(model.recent_loss().total, i == 0 ? newest : before);
    EXPECT_NE(newest, before);
    before = newest;
  }
}

TEST_F(CudaTrainStep, a_gradient_that_is_not_finite_never_gets_into_a_parameter) {
  GpuModel model;
  start(model, small_scene<float>(50, 5));
  for (const float bad : {NAN, INFINITY, -INFINITY, 3e38f}) {
    draw(model);
    model.set_pixel_gradients(
        std::vector<glm::vec3>(static_cast<std::size_t>(kWidth * kHeight), glm::vec3(bad)));
    model.backward({});
    model.step(test::counted_step(kRates));
  }
  for (const auto& group : groups_of(model.state().parameters)) {
    for (const float value : group) ASSERT_TRUE(std::isfinite(value));
  }
  for (const float sum : model.state().density.sums) ASSERT_TRUE(std::isfinite(sum));
}

TEST_F(CudaTrainStep, density_statistics_equal_those_of_the_cpu) {
  Scene scene = small_scene<float>(100, 7);
  scene.means[3].z = -1;  // in no view
  GpuModel model;
  start(model, scene);
  cpu::train::DensityStatistics expected;
  expected.reset(scene.size());
  for (const auto& [width, height] : {std::pair{kWidth, kHeight}, {33, 50}}) {
    draw(model, width, height);
    model.compare(random_target(width, height, 8));
    model.backward({});
    model.step(test::counted_step({}));
    cpu::train::Gradients<float> gradients;
    const GradientCopies copies = model.gradients();
    gradients.mean_px = copies.mean_px;
    add_view(gradients, copies.visible, width, height, expected);
  }
  EXPECT_EQ(model.state().density.sums, expected.sums);
  EXPECT_EQ(model.state().density.views, expected.views);
  EXPECT_EQ(expected.views[3], 0u);
}

TEST_F(CudaTrainStep, views_count_for_the_gaussians_that_the_mode_lists_on_request) {
  Scene scene = small_scene<float>(100, 7);
  scene.opacity_logits[7] = -7;  // alpha < 1/255: `exact` does not list it
  const auto statistics = [&](qs::train::TrainingModel& model, bool by_mode) {
    model.set_state(qs::train::ModelState::starting_with(scene));
    RenderSettings settings;
    settings.mode = find_culler("3dgs");
    const std::vector<std::uint8_t> rgb(3 * kWidth * kHeight, 90);
    for (const double shift : {0.0, 0.4}) {
      Camera camera = test::front_camera(kWidth, kHeight);
      camera.view_from_world[3].x += shift;
      model.forward(camera, settings);
      model.compare_with({}, {.rgb = rgb, .alpha = {}, .mask = {}});
      model.backward({});
      qs::train::StepOrder order;
      order.iteration = model.iteration() + 1;
      order.counts_density = true;
      order.counts_by_mode = by_mode;
      model.step(order);
    }
    return model.state().density.views;
  };
  GpuModel gpu;
  cpu::train::CpuModel cpu(test::pool());
  const auto exact = statistics(gpu, false), by_mode = statistics(gpu, true);
  EXPECT_EQ(exact, statistics(cpu, false));
  EXPECT_EQ(by_mode, statistics(cpu, true));
  EXPECT_EQ(exact[7], 0u);
  EXPECT_EQ(by_mode[7], 2u);
}

TEST_F(CudaTrainStep, density_statistics_count_absolute_gradients_if_they_were_summed) {
  GpuModel model;
  start(model, small_scene<float>(100, 7));
  cpu::train::DensityStatistics expected;
  expected.reset(100);
  for (const bool absolute : {false, true, true}) {
    draw(model);
    model.compare(random_target(kWidth, kHeight, 8));
    model.backward({.absolute = absolute});
    model.step(test::counted_step({}));
    cpu::train::Gradients<float> gradients;
    const GradientCopies copies = model.gradients();
    EXPECT_EQ(copies.absolute_px.size(), absolute ? 100u : 0u);
    gradients.mean_px = copies.mean_px;
    gradients.absolute_px = copies.absolute_px;
    gradients.visible = copies.visible;
    add_view(gradients, gradients.visible, kWidth, kHeight, expected);
    EXPECT_EQ(model.state().density.absolute, expected.absolute);
    EXPECT_EQ(model.facts().density.absolute, expected.absolute);
  }
  GpuModel other;
  other.set_state(model.state());
  EXPECT_EQ(other.state().density.absolute, expected.absolute);
  qs::train::Plan plan;
  plan.keep_all(model.facts(), 2);
  plan.resets_statistics = true;
  model.apply(plan);
  EXPECT_TRUE(model.state().density.absolute.empty());
}

TEST_F(CudaTrainStep, counts_the_pixels_of_large_errors_as_the_cpu) {
  for (const std::size_t count : {100u, 3000u}) {  // one segment, several segments
    GpuModel model;
    const auto cpu = qs::train::make_training_model(Backend::cpu, test::pool());
    Scene scene = small_scene<float>(count, 7);
    scene.means[3].z = -1;  // in no view
    for (float& logit : scene.opacity_logits) logit -= count > 1000 ? 2 : 0;
    start(model, scene);
    start(*cpu, scene);
    const auto expect_equal_counts = [&] {
      const qs::train::PixelCounts &counts = model.facts().counts, &expected = cpu->facts().counts;
      EXPECT_EQ(counts.blended, expected.blended);
      EXPECT_EQ(counts.flagged, expected.flagged);
    };
    expect_equal_counts();
    std::size_t number = 0;
    for (const auto& [width, height] : {std::pair{kWidth, kHeight}, {33, 50}}) {
      const std::size_t pixels = static_cast<std::size_t>(width * height);
      std::vector<std::uint8_t> rgb(3 * pixels);
      for (std::size_t i = 0; i < rgb.size(); ++i)
        rgb[i] = static_cast<std::uint8_t>(i / 3 % static_cast<std::size_t>(width) * 5);
      const std::vector<std::uint8_t> mask =
          number == 0 ? std::vector<std::uint8_t>() : every_third_masked(pixels);
      for (qs::train::TrainingModel* each :
           {static_cast<qs::train::TrainingModel*>(&model), cpu.get()}) {
        each->forward(test::front_camera(width, height), test::settings_of(default_mode(), false));
        each->count_errors(number, {rgb, {}, mask});
      }
      ++number;
      expect_equal_counts();
    }
    const std::vector<std::uint32_t>& flagged = cpu->facts().counts.flagged;
    EXPECT_GT(*std::max_element(flagged.begin(), flagged.end()), 20u);
    qs::train::Plan plan;
    plan.keep_all(model.facts(), 2);
    model.apply(plan);
    EXPECT_TRUE(model.facts().counts.blended.empty());
  }
}

TEST_F(CudaTrainStep, a_new_model_starts_with_zero_moments_and_statistics) {
  const Scene first = small_scene<float>(60, 9), second = small_scene<float>(40, 10);
  const auto target = random_target(kWidth, kHeight, 11);
  const auto trained = [&](GpuModel& model) {
    start(model, second);
    draw(model);
    model.compare(target);
    model.backward({});
    model.step(test::counted_step(kRates));
    return groups_of(model.state().parameters);
  };
  GpuModel used, fresh;
  start(used, first);
  draw(used);
  used.compare(target);
  used.backward({});
  used.step(test::counted_step(kRates));
  EXPECT_EQ(trained(used), trained(fresh));
  EXPECT_EQ(used.state().density.sums, fresh.state().density.sums);
  EXPECT_EQ(used.state().density.views, fresh.state().density.views);
}

TEST_F(CudaTrainStep, steps_lower_the_loss_as_on_the_cpu) {
  Scene scene = small_scene<float>(60, 12);
  const Camera camera = test::front_camera(kWidth, kHeight);
  const RenderSettings settings = test::settings_of(default_mode(), false);
  GpuModel model;
  start(model, small_scene<float>(60, 13));
  model.forward(camera, settings);
  const auto target = model.pixels().color;  // another scene's picture
  start(model, scene);

  auto state = cpu::train::AdamState::like(scene);
  cpu::train::ForwardFrame<float> frame;
  cpu::train::SsimFields<float> scratch;
  cpu::train::BackwardScratch<float> backward_scratch;
  cpu::train::Gradients<float> gradients;
  std::vector<glm::vec3> d_color;
  double first = 0, last = 0;
  for (int step = 0; step < 8; ++step) {
    model.forward(camera, settings);
    model.compare(target);
    model.backward({});
    model.step(test::counted_step(kRates));
    const cpu::train::StepView view{camera, settings, test::pool()};
    forward(view, scene, frame);
    const Loss expected = cpu::train::compare<float>({kWidth, kHeight, frame.color, target},
                                                     test::pool(), scratch, d_color);
    cpu::train::backward<float>(view, scene, frame, d_color, backward_scratch, gradients);
    cpu::train::take_step(scene, gradients.by, kRates, state, test::pool());
    // Adam divides by the gradient's size, so values of about 0 may step either way.
    last = model.loss().total;
    EXPECT_NEAR(last, expected.total, 1e-3 * expected.total) << "step " << step;
    if (step == 0) first = last;
  }
  EXPECT_LT(last, 0.97 * first);
}

}  // namespace
}  // namespace qs::cuda::train
