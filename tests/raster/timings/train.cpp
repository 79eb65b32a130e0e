// SPDX-License-Identifier: MIT
// Times of the passes of training on the GPU, medians over iterations, for a scene and its cameras.
//   gpu_train_timings [SCENE CAMERAS [ITERATIONS [WIDTH HEIGHT]]]
// The host waits after each pass; `all` is an iteration with one wait at its end, `flow` one of
// many iterations without a wait in between, and `pairs` the mean number of pairs in the tile
// lists. Then the times of a change of the set of Gaussians and of copies of the whole state; the
// same passes with masks, with a colour field and with codes of shapes; and the times of the
// field's kernels, one after the other.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>
#include <vector>

#include "io/camera/cameras.h"
#include "learn/run/field_model.h"
#include "learn/run/initial.h"
#include "learn/step/cuda/gpu_model.h"
#include "raster/timings/field_stages.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/paths.h"

namespace {

using namespace qs;
namespace fs = std::filesystem;

constexpr int kWarmup = 5;

/// Runs a pass and returns its milliseconds.
template <class Pass>
double timed(const cuda::train::GpuModel& model, const Pass& pass) {
  const auto begin = std::chrono::steady_clock::now();
  pass();
  model.wait();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
      .count();
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// An iteration with the work of strategy adc. Rates of 0 give every iteration the same work.
class Iteration {
 public:
  Iteration(cuda::train::GpuModel& model, const std::vector<Camera>& cameras,
            const RenderSettings& settings)
      : model_(model), cameras_(cameras), settings_(settings) {
    order_.counts_density = true;
  }

  void select(int number) { camera_ = static_cast<std::size_t>(number) % cameras_.size(); }
  void forward() { model_.forward(cameras_[camera_], settings_); }
  void compare() {
    const Camera& camera = cameras_[camera_];
    gray_.resize(static_cast<std::size_t>(3 * camera.width * camera.height), 128);
    model_.compare_with(camera_, {gray_, {}, {}});
  }
  void backward() { model_.backward({}); }
  void step() { model_.step(order_); }
  void all() {
    forward();
    compare();
    backward();
    step();
    model_.recent_loss();
  }

 private:
  cuda::train::GpuModel& model_;
  const std::vector<Camera>& cameras_;
  const RenderSettings settings_;
  train::StepOrder order_;
  std::vector<std::uint8_t> gray_;
  std::size_t camera_ = 0;
};

void measure(cuda::train::GpuModel& model, const std::vector<Camera>& cameras,
             const RenderSettings& settings, int iterations, const char* name) {
  Iteration it(model, cameras, settings);
  std::vector<double> times[5];
  double pairs = 0;
  for (int i = -kWarmup; i < iterations; ++i) {
    it.select(i + kWarmup);
    const double ms[] = {timed(model, [&] { it.forward(); }), timed(model, [&] { it.compare(); }),
                         timed(model, [&] { it.backward(); }), timed(model, [&] { it.step(); }),
                         timed(model, [&] { it.all(); })};
    if (i >= 0) pairs += model.pairs();
    for (std::size_t pass = 0; pass < std::size(ms) && i >= 0; ++pass)
      times[pass].push_back(ms[pass]);
  }
  const double flow = timed(model, [&] {
    for (int i = 0; i < iterations; ++i) {
      it.select(i);
      it.all();
    }
  });
  std::printf("%-14s", name);
  for (auto& pass : times) std::printf(" %9.3f", median(pass));
  std::printf(" %9.3f %11.0f\n", flow / iterations, pairs / iterations);
}

void measure_changes(cuda::train::GpuModel& model) {
  train::Plan plan;
  for (int i = 0; i < 3; ++i) {  // the last run is shown, because the first runs allocate
    const train::GaussianFacts* facts = nullptr;
    const double read = timed(model, [&] { facts = &model.facts(); });
    const double planned = timed(model, [&] { plan.keep_all(*facts, 1); });
    const double applied = timed(model, [&] { model.apply(plan); });
    const double copied = timed(model, [&] { model.state(); });
    if (i == 2) {
      std::printf("facts %.3f, plan %.3f, apply %.3f, state %.3f\n", read, planned, applied,
                  copied);
    }
  }
}

train::Parameters with_dc_only(train::Parameters parameters) {
  const std::size_t stride = parameters.sh_stride();
  for (std::size_t i = 0; i < parameters.size(); ++i) parameters.sh[i] = parameters.sh[i * stride];
  parameters.sh_degree = 0;
  parameters.resize(parameters.size());
  return parameters;
}

// The passes of strategy mask in mode quadbox, with the coefficients of colour and with a field.
void measure_field(cuda::train::GpuModel& model, const std::vector<Camera>& cameras,
                   int iterations) {
  train::ModelState state = train::ModelState::starting_with(train::with_masks(model.parameters()));
  const RenderSettings settings;
  const auto measure_state = [&](const char* name) {
    model.set_state(state);
    measure(model, cameras, settings, iterations, name);
  };
  measure_state("mask");
  state = train::ModelState::starting_with(with_dc_only(std::move(state.parameters)));
  state.color_field = train::starting_field(0);
  measure_state("colour field");
  state.codes = train::first_codes(state, 0, test::pool());
  measure_state("and codes");
  test::measure_field_stages(state, cameras, iterations);
}

int run(const fs::path& scene, const fs::path& camera_file, int iterations, int width, int height) {
  std::vector<Camera> cameras = read_cameras(camera_file);
  for (Camera& camera : cameras) camera = camera.resized(width, height);
  cuda::train::GpuModel model;
  model.set_state(
      train::ModelState::starting_with(train::from_cloud(test::read_scene(scene).cloud)));
  std::printf("%s, %zu Gaussians, %d x %d, ms\n%-14s %9s %9s %9s %9s %9s %9s %11s\n",
              gpu_report().gpus.at(0).name.c_str(), model.size(), width, height, "mode", "forward",
              "compare", "backward", "step", "all", "flow", "pairs");
  for (const char* mode : {"3dgs", "quadbox", "exact"}) {
    RenderSettings settings;
    settings.mode = find_culler(mode);
    measure(model, cameras, settings, iterations, mode);
  }
  measure_changes(model);
  measure_field(model, cameras, iterations);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const fs::path scenes = qs::test::shared_folder() / "scenes";
    return run(argc > 2 ? fs::path(argv[1]) : scenes / "plush.spz",
               argc > 2 ? fs::path(argv[2]) : scenes / "plush/cameras.json",
               argc > 3 ? std::atoi(argv[3]) : 50, argc > 5 ? std::atoi(argv[4]) : 1600,
               argc > 5 ? std::atoi(argv[5]) : 1200);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gpu_train_timings: %s\n", error.what());
    return 3;
  }
}
