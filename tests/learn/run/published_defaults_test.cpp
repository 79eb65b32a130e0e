// SPDX-License-Identifier: MIT
// Every number of the published methods, against the value in its paper or published code. Values
// that the code does not show are found by trying: the first iteration, or the threshold, at which
// the behaviour changes.
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

#include "app/support/training.h"
#include "learn/gradient/density.h"
#include "learn/gradient/loss.h"
#include "learn/run/initial.h"
#include "learn/run/schedule.h"
#include "learn/run/strategy.h"
#include "raster/kernel/ssim.h"
#include "support/pool.h"

namespace qs::train {
namespace {

/// A number of this program and its published value.
struct Published {
  const char* name;
  double ours, published;
};

void expect_published(const std::vector<Published>& rows) {
  for (const Published& row : rows)
    EXPECT_NEAR(row.ours, row.published, 1e-4 * std::abs(row.published)) << row.name;
}

/// The value between `low` and `high` above which `holds`.
double threshold(double low, double high, const std::function<bool(double)>& holds) {
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    (holds(middle) ? high : low) = middle;
  }
  return high;
}

/// The iterations up to 30,001 with a change before them, as "after" counts: minus 1.
std::vector<int> changes_of(const char* strategy, const TrainSettings& settings) {
  std::vector<int> after;
  for (int iteration = 1; iteration <= 30'001; ++iteration) {
    if (find_strategy(strategy).changes_before(settings, iteration)) after.push_back(iteration - 1);
  }
  return after;
}

/// One Gaussian before the change of a strategy.
struct One {
  float gradient = 0;   ///< mean on the image, ndc
  double scale = 1e-3;  ///< largest, world units
  double opacity = 0.5;
};

/// The set after the change behind iteration `after`, in a world of extent 1.
ModelState changed_by(const char* strategy, int after, const One& one, std::size_t count = 1) {
  TrainSettings settings;
  settings.sh_degree = 0;
  settings.strategy = strategy;
  Parameters parameters = test::ball_of_gaussians(count, 1);
  const auto logit = static_cast<float>(std::log(one.opacity / (1 - one.opacity)));
  for (float& value : parameters.opacity_logits) value = logit;
  for (glm::vec3& value : parameters.log_scales)
    value = glm::vec3(static_cast<float>(std::log(one.scale)));
  ModelState model = ModelState::starting_with(std::move(parameters));
  for (std::size_t i = 0; i < count; ++i) {
    model.density.sums[i] = one.gradient;
    model.density.views[i] = 1;
  }
  Plan plan;
  find_strategy(strategy).plan({settings, after + 1, 1.0, {}}, facts_of(model), plan);
  return changed(model, plan);
}

std::size_t size_after(int after, const One& one) { return changed_by("adc", after, one).size(); }

float first_log_scale(const ModelState& model) { return model.parameters.log_scales[0].x; }

TEST(PublishedDefaults, of_rates_and_schedule) {
  const Rates first = rates_at(0, 1, 0), middle = rates_at(15'000, 1, 0),
              last = rates_at(30'000, 1, 0);
  const auto first_with_degree = [](int degree) {
    int iteration = 0;
    while (sh_degree_at(iteration, 3) < degree) ++iteration;
    return static_cast<double>(iteration);
  };
  const AdamStep step = AdamStep::number(1);
  expect_published(
      {{"rate of means, first", first.mean, 1.6e-4},
       {"rate of means, half", middle.mean, 1.6e-5},
       {"rate of means, last", last.mean, 1.6e-6},
       {"rate of means in a larger world", rates_at(0, 5, 0).mean, 8e-4},
       {"rate of scales", first.log_scale, 5e-3},
       {"rate of rotations", last.rotation, 1e-3},
       {"rate of opacities, adc", find_strategy("adc").opacity_rate, 2.5e-2},
       {"rate of opacities, mcmc", find_strategy("mcmc").opacity_rate, 5e-2},
       {"rate of opacities is passed on", rates_at(0, 1, 0.7).opacity, 0.7},
       {"rate of DC", first.sh_dc, 2.5e-3},
       {"rate of SH", first.sh_rest, 1.25e-4},
       {"SH degree 1", first_with_degree(1), 1000},
       {"SH degree 2", first_with_degree(2), 2000},
       {"SH degree 3", first_with_degree(3), 3000},
       {"Adam's beta 1", kAdamBeta1, 0.9},
       {"Adam's beta 2", kAdamBeta2, 0.999},
       {"Adam's epsilon", kAdamEpsilon, 1e-15},
       {"Adam's first correction", step.first, 10},
       {"Adam's second correction", step.second, std::sqrt(1000)},
       {"iterations", 1.0 * TrainSettings().iterations, 30'000},
       {"SH degree", 1.0 * TrainSettings().sh_degree, 3},
       {"random points", static_cast<double>(TrainSettings().random_points), 100'000}});
}

TEST(PublishedDefaults, of_the_loss) {
  expect_published({{"lambda of DSSIM", kSsimWeight, 0.2},
                    {"window of SSIM", kSsimSize, 11},
                    {"C1 of SSIM", kSsimC1, 0.0001},
                    {"C2 of SSIM", kSsimC2, 0.0009},
                    {"loss of l1 = 0.5, SSIM = 0.25", Loss::of_sums(0.5, 0.25, 0, 1).total, 0.55}});
}

TEST(PublishedDefaults, of_the_start) {
  const auto start = [](const char* strategy) {
    const Strategy& row = find_strategy(strategy);
    return InitialGaussians{0, row.initial_opacity, row.initial_scale};
  };
  // Points in the corners of a square of side 2: the three distances are 2, 2 and 2 sqrt 2.
  const std::vector<ScenePoint> points = {
      {{0, 0, 0}, {1, 0, 0}}, {{2, 0, 0}, {}}, {{0, 2, 0}, {}}, {{2, 2, 0}, {}}};
  const std::vector<ScenePoint> copies(4, ScenePoint{{0, 0, 0}, {}});
  const Parameters adc = gaussians_at(points, start("adc"), test::pool());
  const Parameters mcmc = gaussians_at(points, start("mcmc"), test::pool());
  const Parameters least = gaussians_at(copies, start("adc"), test::pool());
  const double size = std::sqrt((4 + 4 + 8) / 3.0);
  expect_published(
      {{"opacity, adc", opacity(adc, 0), 0.1},
       {"opacity, mcmc", opacity(mcmc, 0), 0.5},
       {"scale, adc", largest_scale(adc, 0), size},
       {"scale, mcmc", largest_scale(mcmc, 0), 0.1 * size},
       {"least scale", largest_scale(least, 0), std::sqrt(1e-7)},
       {"DC of red 1", adc.sh[0].x, 0.5 * 2 * std::sqrt(std::numbers::pi)},
       {"limit of adc", static_cast<double>(find_strategy("adc").default_max_gaussians), 0},
       {"limit of mcmc", static_cast<double>(find_strategy("mcmc").default_max_gaussians), 1e6}});
}

TEST(PublishedDefaults, of_adaptive_density_control) {
  const auto grows = [](double gradient) {
    return size_after(600, {.gradient = static_cast<float>(gradient)}) == 2;
  };
  const auto splits = [](double scale) {
    const One one{.gradient = 1, .scale = scale};
    return first_log_scale(changed_by("adc", 600, one)) < std::log(scale) - 0.1;
  };
  const auto is_kept = [](double value) { return size_after(600, {.opacity = value}) == 1; };
  const auto is_huge = [](double scale) { return size_after(3600, {.scale = scale}) == 0; };
  const ModelState split = changed_by("adc", 600, {.gradient = 1, .scale = 0.5});
  const ModelState reset = changed_by("adc", 3000, {});
  expect_published({{"gradient of growth", threshold(0, 1e-2, grows), 2e-4},
                    {"scale of splits", threshold(0, 1, splits), 0.01},
                    {"shrinking by splits", 0.5 / std::exp(first_log_scale(split)), 1.6},
                    {"children of a split", static_cast<double>(split.size()), 2},
                    {"least opacity", threshold(0.001, 0.2, is_kept), 0.005},
                    {"largest scale", threshold(0.001, 5, is_huge), 0.1},
                    {"largest scale before the first reset",
                     static_cast<double>(size_after(3000, {.scale = 5})), 1},
                    {"opacity after a reset", opacity(reset.parameters, 0), 0.01}});
}

TEST(PublishedDefaults, of_the_iterations_that_change_the_set) {
  std::vector<int> every_100, resets;
  for (int after = 600; after < 15'000; after += 100) every_100.push_back(after);
  EXPECT_EQ(changes_of("adc", {}), every_100);
  TrainSettings white;
  white.background = glm::vec3(1);
  every_100.insert(every_100.begin(), 500);
  EXPECT_EQ(changes_of("adc", white), every_100);
  for (int after = 100; after <= 16'000; after += 100) {
    const ModelState model = changed_by("adc", after, {});
    if (model.size() == 1 && opacity(model.parameters, 0) < 0.1) resets.push_back(after);
  }
  EXPECT_EQ(resets, (std::vector{3000, 6000, 9000, 12'000}));
  every_100.clear();
  for (int after = 600; after < 25'000; after += 100) every_100.push_back(after);
  EXPECT_EQ(changes_of("mcmc", {}), every_100);
}

TEST(PublishedDefaults, of_markov_chain_monte_carlo) {
  const TrainSettings settings;
  IterationContext context{settings, 700, 1.0, {}};
  context.rates.mean = 1e-4;
  const StepOrder step = find_strategy("mcmc").step(context);
  const auto grown = changed_by("mcmc", 600, {}, 100);
  expect_published({{"dead up to", kDeadOpacity, 0.005},
                    {"growth of 100", static_cast<double>(grown.size()), 105},
                    {"weight of opacities", step.sparsity->opacity_weight, 0.01},
                    {"weight of scales", step.sparsity->scale_weight, 0.01},
                    {"noise", step.noise->shape.size, 5e5 * 1e-4}});
}

}  // namespace
}  // namespace qs::train
