// SPDX-License-Identifier: MIT
#include "app/train/trainer.h"

#include <chrono>
#include <span>
#include <utility>

#include "app/train/initial.h"
#include "raster/base/fail.h"
#include "raster/kernel/random.h"
#include "raster/scene/image_metrics.h"

namespace qs::train {
namespace {

Image image_of(const Camera& camera, const std::vector<glm::vec3>& pixels) {
  Image image(camera.width, camera.height, 3);
  std::copy_n(&pixels[0][0], image.values.size(), image.values.begin());
  return image;
}

// Measures the stages one after another.
class StageClock {
 public:
  explicit StageClock(std::span<double> seconds) : seconds_(seconds) {}

  /// Ends a stage.
  void next() {
    const auto now = std::chrono::steady_clock::now();
    seconds_[stage_++] = std::chrono::duration<double>(now - begin_).count();
    begin_ = now;
  }

 private:
  std::span<double> seconds_;
  std::size_t stage_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace

Parameters starting_gaussians(const DataSet& data, const TrainSettings& settings,
                              ThreadPool& pool) {
  const Strategy& strategy = find_strategy(settings.strategy);
  const InitialGaussians initial{settings.sh_degree, strategy.initial_opacity,
                                 strategy.initial_scale};
  return gaussians_at(data.points.empty()
                          ? random_points(data, settings.random_points, settings.seed)
                          : data.points,
                      initial, pool);
}

Trainer::Trainer(const TrainSettings& settings, const DataSet& data, ModelState model,
                 ThreadPool& pool)
    : settings_(settings),
      data_(data),
      strategy_(find_strategy(settings.strategy)),
      extent_(data.extent()),
      pool_(pool),
      model_(std::move(model)),
      views_(data.training.size(), settings.seed),
      photographs_(data) {}

RenderSettings Trainer::render_settings(int iteration) const {
  RenderSettings render;
  render.mode = settings_.mode;
  render.sh_degree = sh_degree_at(iteration, settings_.sh_degree);
  render.antialiased = settings_.antialiased;
  render.background = settings_.random_background ? glm::vec3(0) : settings_.background;
  return render;
}

const PhotographView& Trainer::view_of(int iteration) {
  constexpr int kAhead = 4;
  std::array<const PhotographView*, kAhead> next{};
  for (int i = 0; i < kAhead; ++i)
    next[static_cast<std::size_t>(i)] = &data_.training[views_.at(iteration + 1 + i)];
  return photographs_.view(data_.training[views_.at(iteration)], next);
}

StepResult Trainer::step() {
  StepResult result;
  StageClock clock(result.seconds);
  const int iteration = model_.iteration + 1;
  const cpu::train::Rates rates = rates_at(iteration, extent_, strategy_.opacity_rate);
  const ModelContext context{settings_, iteration, extent_, rates, pool_, model_};
  strategy_.prepare(context);
  clock.next();
  if (model_.size() == 0) {
    fail("{}: no Gaussian is left in iteration {}: the photographs do not fit their cameras",
         data_.folder.string(), iteration);
  }
  const PhotographView& view = view_of(iteration);
  RenderSettings render = render_settings(iteration);
  if (settings_.random_background) {
    const Random random =
        Random::of(settings_.seed, RandomUse::background, static_cast<std::uint64_t>(iteration));
    render.background = glm::vec3(random.uniform(0), random.uniform(1), random.uniform(2));
  }
  const cpu::train::StepView step{view.camera, render, pool_};
  forward(step, model_.parameters, frame_);
  clock.next();
  const std::vector<glm::vec3> target = view.target(render.background);
  result.loss = cpu::train::compare<float>(view.camera.width, view.camera.height, frame_.color,
                                           target, pool_, loss_, d_color_, view.mask);
  clock.next();
  cpu::train::backward<float>(step, model_.parameters, frame_, d_color_, backward_, gradients_);
  clock.next();
  strategy_.step({context, view.camera.width, view.camera.height, gradients_});
  clock.next();
  model_.iteration = iteration;
  return result;
}

std::optional<Quality> Trainer::test_quality() {
  if (data_.test.empty()) return std::nullopt;
  const RenderSettings render = render_settings(model_.iteration);
  Quality sum;
  for (std::size_t i = 0; i < data_.test.size(); ++i) {
    const PhotographView* const next = &data_.test[(i + 1) % data_.test.size()];
    const PhotographView& view = photographs_.view(data_.test[i], {&next, 1});
    forward({view.camera, render, pool_}, model_.parameters, frame_);
    Image image = image_of(view.camera, frame_.color);
    clamp_to_unit(image);
    const Image photograph = view.image();
    sum.psnr += psnr(image, photograph, pool_, view.mask);
    sum.ssim += ssim(image, photograph, pool_, SsimBorder::zeros, view.mask);
  }
  const auto count = static_cast<double>(data_.test.size());
  return Quality{sum.psnr / count, sum.ssim / count};
}

GaussianCloud Trainer::cloud() const { return to_cloud(model_.parameters, settings_.antialiased); }

}  // namespace qs::train
