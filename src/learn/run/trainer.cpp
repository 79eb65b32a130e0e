// SPDX-License-Identifier: MIT
#include "learn/run/trainer.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <numeric>
#include <utility>

#include "base/fail.h"
#include "io/camera/lens.h"
#include "learn/run/field_model.h"
#include "learn/run/initial.h"
#include "raster/kernel/random.h"

namespace qs::train {
namespace {

constexpr double kMostPsnr = 100;  // of equal pictures, so that means are finite

// Measures the stages one after another.
class StageClock {
 public:
  using Seconds = std::array<double, kTrainPasses.size()>;

  /// Ends a stage.
  void next() {
    const auto now = std::chrono::steady_clock::now(), begin = std::exchange(begin_, now);
    seconds_[stage_++] = std::chrono::duration<double>(now - begin).count();
  }

  /// Ends the last stage. The times of all stages; `passes` replace the host's times.
  Seconds finish(const std::optional<PassSeconds>& passes) {
    next();
    const double total = std::accumulate(seconds_.begin(), seconds_.end(), 0.0);
    if (passes) {
      const double on_gpu[] = {passes->forward, passes->loss, passes->backward, passes->step};
      std::copy(std::begin(on_gpu), std::end(on_gpu), seconds_.begin() + 1);
    }
    seconds_.back() = total - std::accumulate(seconds_.begin(), seconds_.end() - 1, 0.0);
    return seconds_;
  }

 private:
  Seconds seconds_{};
  std::size_t stage_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace

RunFacts run_facts_of(const DataSet& data, const Pace& pace) {
  RunFacts facts{.views = data.training.size(), .pace = pace};
  const std::vector<PhotographView>& views = data.training;
  for (std::size_t i = 0; i < views.size();) {
    const PhotographView& first = views[i];
    std::uint64_t pixels = 0;  // of a photograph
    for (; i < views.size() && views[i].source.file == first.source.file; ++i)
      pixels += std::uint64_t{1} * static_cast<unsigned>(views[i].camera.width) *
                static_cast<unsigned>(views[i].camera.height);
    // Its faces have more pixels, of which many show nothing.
    const LensCamera taken{first.camera, first.lens};
    const glm::dvec2 size = taken.photograph_size();
    if (taken.is_face()) pixels = std::min(pixels, static_cast<std::uint64_t>(size.x * size.y));
    facts.pixels += pixels;
  }
  return facts;
}

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

Trainer::Trainer(const TrainSettings& settings, const DataSet& data,
                 std::unique_ptr<TrainingModel> model, ThreadPool& pool,
                 std::vector<GuardRow> measured, std::vector<Pace::Row> pace)
    : settings_(settings),
      data_(data),
      strategy_(find_strategy(settings.strategy)),
      extent_(data.extent()),
      pool_(pool),
      model_(std::move(model)),
      run_(run_facts_of(data, pace.empty() ? settings.given_pace() : Pace(std::move(pace)))),
      guard_(settings.guard ? Guard(data.training.size(), settings.seed, std::move(measured))
                            : Guard()),
      views_(data.training.size(), settings.seed),
      trained_views_(guard_.trained().size(), settings.seed),
      photographs_(data),
      reduced_(data.training.size(),
               settings.dash_of_paper ? ReductionFilter::lanczos2 : ReductionFilter::triangle,
               pool) {
  run_.stopped_after = guard_.stopped_after();
}

void Trainer::prepare(const Progress& progress) {
  if (schedule_) return;
  if (!settings_.reduced_photographs) {
    schedule_.emplace();
    return;
  }
  PhotographSpectra spectra;
  const std::size_t count = data_.training.size();
  for (std::size_t i = 0; i < count; ++i) {
    progress.update(static_cast<float>(i) / static_cast<float>(count));
    const PhotographView* const next = &data_.training[(i + 1) % count];
    spectra.add(photographs_.view(data_.training[i], {&next, 1}).image(), pool_);
  }
  schedule_.emplace(spectra, settings_.reduced_until());
}

IterationContext Trainer::context_of(int iteration) const {
  MeanRateStart start;
  if (strategy_.reduces_photographs) start = {schedule_->details_from(), !settings_.dash_of_paper};
  const double opacity_rate =
      settings_.opacity_rate > 0 ? settings_.opacity_rate : strategy_.opacity_rate;
  return {settings_,
          iteration,
          extent_,
          rates_at(iteration, extent_, opacity_rate, start),
          schedule_->factor_in(iteration - 1),
          run_};
}

RenderSettings Trainer::render_settings(int iteration) const {
  const int steps = strategy_.sh_steps;
  return {.mode = settings_.mode,
          .sh_degree = steps > 0
                           ? std::min(settings_.sh_degree, run_.pace.steps(iteration, 0, 1, steps))
                           : sh_degree_at(iteration, settings_.sh_degree),
          .background = settings_.random_background ? glm::vec3(0) : settings_.background,
          .antialiased = settings_.antialiased};
}

StepOrder Trainer::step_order(const IterationContext& context) const {
  StepOrder order = strategy_.step(context);
  order.counts_by_mode = settings_.count_views == CountViews::mode;
  if (settings_.step_before_densify) order.moves = true;
  return order;
}

// The number of the view that an iteration trains.
std::size_t Trainer::view_at(int iteration) {
  return guard_.trains_all(run_.pace, iteration) ? views_.at(iteration)
                                                 : guard_.trained()[trained_views_.at(iteration)];
}

const PhotographView& Trainer::view_of(int iteration) {
  const PhotographView& view = data_.training[view_at(iteration)];
  if (!data_.on_disk()) return view;
  std::array<const PhotographView*, 2 * PhotographCache::kMostThreads> next{};
  for (std::size_t i = 0; i < next.size(); ++i)
    next[i] = &data_.training[view_at(iteration + 1 + static_cast<int>(i))];
  return photographs_.view(view, next);
}

// The pixels of a data set that is too large for the memory are only in the cache.
std::optional<std::size_t> Trainer::number_of(std::size_t view) const {
  return data_.on_disk() ? std::nullopt : std::optional(view);
}

void Trainer::count_errors(int iteration, int views) {
  const bool all = guard_.trains_all(run_.pace, iteration);
  std::vector<std::size_t> drawn =
      drawn_views(all ? data_.training.size() : guard_.trained().size(),
                  static_cast<std::size_t>(views), settings_.seed, iteration);
  if (!all)
    for (std::size_t& view : drawn) view = guard_.trained()[view];
  const RenderSettings render = render_settings(iteration);
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const PhotographView* const next =
        &data_.training[i + 1 < drawn.size() ? drawn[i + 1] : view_at(iteration)];
    const PhotographView& full = photographs_.view(data_.training[drawn[i]], {&next, 1});
    const PhotographView& view = reduced_.view(drawn[i], full, !data_.on_disk());
    forward(view, render);
    model_->count_errors(number_of(drawn[i]), view.photograph());
  }
}

void Trainer::correct_pace(double elapsed, PaceControl& control) {
  const double number = static_cast<double>(gaussians());
  const double target =
      run_.stopped_after > 0 ? number : static_cast<double>(paced_target(settings_, run_));
  control.correct(elapsed, iteration(), number, target, kPacedGrowthEnd, run_.pace);
}

void Trainer::measure_if_due() {
  if (!guard_.due(run_.pace, iteration())) return;
  const auto psnr_of_views = [&](const std::vector<std::size_t>& numbers) {
    std::vector<const PhotographView*> views;
    for (const std::size_t number : numbers) views.push_back(&data_.training[number]);
    return std::min(mean_quality(views).psnr, kMostPsnr);
  };
  guard_.add({iteration(), psnr_of_views(guard_.reserved()), psnr_of_views(guard_.neighbours())});
  run_.stopped_after = guard_.stopped_after();
}

void Trainer::require_codes() {
  if (has_codes_) return;
  ModelState state = model_->state();
  if (!state.codes.exist()) {
    state.codes = first_codes(state, settings_.seed, pool_);
    model_->set_state(std::move(state));
  }
  has_codes_ = true;
}

StepResult Trainer::step() {
  StepResult result;
  StageClock clock;
  const int iteration = model_->iteration() + 1;
  prepare();
  measure_if_due();  // an error may have prevented it behind the last step
  if (reduced_.set_factor(schedule_->factor_in(iteration))) model_->forget_photographs();
  if (settings_.color_field && iteration > kCodesAfter) require_codes();
  const IterationContext context = context_of(iteration);
  // The change was already made if an earlier attempt at this iteration ran out of memory after it.
  if (strategy_.changes_before(settings_, iteration, context.run) &&
      model_->changed_before() != iteration) {
    count_errors(iteration, strategy_.scored_views(settings_, iteration, context.run));
    strategy_.plan(context, model_->facts(), plan_);
    model_->apply(plan_);
  }
  clock.next();
  if (model_->size() == 0)
    fail("{}: no Gaussian is left in iteration {}: {}", data_.folder.string(), iteration,
         settings_.color_field ? "all are masked out: train with --strategy adc"
                               : "the photographs do not fit their cameras");
  const PhotographView& view =
      reduced_.view(view_at(iteration), view_of(iteration), !data_.on_disk());
  RenderSettings render = render_settings(iteration);
  if (settings_.random_background) {
    const Random random =
        Random::of(settings_.seed, RandomUse::background, static_cast<std::uint64_t>(iteration));
    render.background = glm::vec3(random.uniform(0), random.uniform(1), random.uniform(2));
  }
  forward(view, render);
  clock.next();
  model_->compare_with(number_of(view_at(iteration)), view.photograph());
  clock.next();
  const StepOrder order = step_order(context);
  model_->backward({.absolute = order.counts_density && strategy_.absolute_gradients(settings_)});
  clock.next();
  model_->step(order);
  clock.next();
  result.loss = model_->recent_loss();
  measure_if_due();
  result.seconds = clock.finish(model_->pass_seconds());
  return result;
}

void Trainer::forward(const PhotographView& view, const RenderSettings& render) {
  model_->forward(compared_camera(view.camera, view.lens), render);
}

Quality Trainer::mean_quality(std::span<const PhotographView* const> views,
                              const Progress& progress) {
  const RenderSettings render = render_settings(iteration());
  const auto count = static_cast<double>(views.size());
  Quality mean;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const PhotographView& view = photographs_.view(*views[i], {&views[(i + 1) % views.size()], 1});
    forward(view, render);
    const Quality quality = model_->quality(view.photograph());
    mean.psnr += quality.psnr / count;
    mean.ssim += quality.ssim / count;
    progress.update(static_cast<float>(i + 1) / static_cast<float>(views.size()));
  }
  return mean;
}

std::optional<Quality> Trainer::test_quality(const Progress& progress) {
  if (data_.test.empty()) return std::nullopt;
  std::vector<const PhotographView*> views;
  for (const PhotographView& view : data_.test) views.push_back(&view);
  return mean_quality(views, progress);
}

GaussianCloud Trainer::cloud() const {
  GaussianCloud cloud = settings_.color_field
                            ? fitted_cloud(model_->state(), settings_.antialiased, pool_)
                            : to_cloud(model_->parameters(), settings_.antialiased);
  cloud.origin = data_.origin;
  return cloud;
}

}  // namespace qs::train
