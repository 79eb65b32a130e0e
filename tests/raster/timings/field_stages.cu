// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

#include "learn/step/cuda/adam.cuh"
#include "learn/step/cuda/codes.cuh"
#include "learn/step/cuda/field.cuh"
#include "raster/timings/field_stages.h"

namespace qs::test {
namespace {

using namespace cuda;
using namespace cuda::train;

constexpr int kWarmup = 5;

// Names and times of steps, in the order of their first call.
class StepTimes {
 public:
  StepTimes() {
    for (cudaEvent_t& event : events_) check(cudaEventCreate(&event), "cudaEventCreate");
  }
  ~StepTimes() {
    for (const cudaEvent_t event : events_) cudaEventDestroy(event);
  }

  template <class Step>
  void add(const char* name, bool counts, cudaStream_t stream, const Step& step) {
    check(cudaEventRecord(events_[0], stream), "cudaEventRecord");
    step();
    check(cudaEventRecord(events_[1], stream), "cudaEventRecord");
    check(cudaEventSynchronize(events_[1]), name);
    float ms = 0;
    check(cudaEventElapsedTime(&ms, events_[0], events_[1]), "cudaEventElapsedTime");
    if (!counts) return;
    if (times_.count(name) == 0) names_.emplace_back(name);
    times_[name].push_back(ms);
  }

  void print() {
    for (const std::string& name : names_) {
      std::vector<float>& times = times_[name];
      const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
      std::nth_element(times.begin(), middle, times.end());
      std::printf("%-28s %9.3f\n", name.c_str(), double{*middle});
    }
  }

 private:
  cudaEvent_t events_[2] = {};
  std::vector<std::string> names_;
  std::map<std::string, std::vector<float>> times_;
};

}  // namespace

void measure_field_stages(const qs::train::ModelState& state, const std::vector<Camera>& cameras,
                          int iterations) {
  const Stream stream(0, true);
  cuda::train::Parameters parameters;
  upload(state.parameters, stream, parameters);
  DeviceField field;
  field.upload(state.color_field, stream);
  cuda::train::ShapeCodes codes;
  codes.upload(state.codes, stream);
  ForwardFrame frame;
  DeviceBuffer<glm::vec3> d_means;
  d_means.reserve("the gradients", parameters.count);
  StepTimes times;
  double visible = 0;
  for (int i = -kWarmup; i < iterations; ++i) {
    const Camera& camera = cameras[static_cast<std::size_t>(i + kWarmup) % cameras.size()];
    const RenderSettings settings;
    const StepView view{camera, settings, stream};
    const ParametersView all = parameters.view();
    const auto time = [&](const char* name, const auto& step) {
      times.add(name, i >= 0, stream, step);
    };
    if (codes.exist()) time("code shapes", [&] { code_shapes(all, codes, stream); });
    project_view(view, all, frame);
    field.reserve(parameters.count);
    const FieldPasses passes{view, all, field, stream};
    time("list visible", [&] { passes.list_visible(frame); });
    time("features of the grid", [&] { passes.find_features(); });
    time("network", [&] { passes.find_colors(frame); });

    const auto tiles = copied(frame.listed.gaussians.tile_counts, parameters.count, stream);
    std::vector<glm::vec3> d_outputs(tiles.size());
    for (std::size_t k = 0; k < tiles.size(); ++k)
      d_outputs[k] = glm::vec3(tiles[k] > 0 ? 1e-6f : 0);
    if (i >= 0)
      visible += static_cast<double>(
          std::count_if(tiles.begin(), tiles.end(), [](std::uint32_t n) { return n > 0; }));
    copy_to_device(d_outputs.data(), field.d_outputs, d_outputs.size(), stream);
    check(cudaMemsetAsync(d_means.data(), 0, parameters.count * sizeof(glm::vec3), stream),
          "clear");
    if (field.has_grid_sums) {
      check(cudaMemsetAsync(field.grid_sums.data(), 0,
                            field.grid_count * sizeof(unsigned long long), stream),
            "clear");
    }
    field.keep_order(all, stream);
    time("list changing", [&] { passes.list_changing(); });
    time("network, backward", [&] { passes.through_network(d_means.data()); });
    time("sums of weights", [&] { passes.sum_weight_gradients(); });
    time("sums of the grid", [&] { passes.sum_grid_gradients(); });
    time("step of the field", [&] { take_field_step(1e-5, field, stream); });
    if (codes.exist()) time("step of codes", [&] { take_code_steps(all, codes, stream); });
  }
  std::printf("colour field, %u Gaussians, %.0f visible, ms\n", parameters.count,
              visible / iterations);
  times.print();
}

}  // namespace qs::test
