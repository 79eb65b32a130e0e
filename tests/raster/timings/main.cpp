// SPDX-License-Identifier: MIT
// Frame and stage times of both pipelines in every mode on the GPU, with the limits of
// docs/performance.md, for generated scenes of the parity tests and for the scenes, cameras and
// sizes of golden/pairs.json. Also measures the time from a scene's file to its first frame, and
// the time of render() with and without Outputs::mode_pairs.
//   gpu_timings [SHARED_DIR [FRAMES [SET [PIPELINE]]]]     SET: generated, or a set of the file
// Pipelines and modes alternate frame by frame in the order of TurnOrder, so that a drifting clock
// and the frame before affect all of them equally. Frame times come from frames without events
// between stages, whose images stay on the device.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/measure/turn_order.h"
#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "raster/api/renderer.h"
#include "raster/clock/gpu_clock.h"
#include "raster/scene/activated_cloud.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/paths.h"

namespace {

using namespace qs;
namespace fs = std::filesystem;

constexpr int kWarmup = 20;

// Limits in milliseconds. `classic`: times of published implementations on an H200. `fast`: half
// the time of the fastest of these implementations with fp32 quality, for the lossless mode with
// the fewest pairs.
struct Limits {
  const char* set;
  float square, adr, quad_box;
  float fast;

  float of(Pipeline pipeline, const std::string& mode) const {
    if (pipeline == Pipeline::fast) return mode == "exact" ? fast : 0;
    return mode == "3dgs" ? square : mode == "adr" ? adr : mode == "quadbox" ? quad_box : 0;
  }
};
constexpr Limits kLimits[] = {{"plush", 2.993f, 1.536f, 1.348f, 0.46f},
                              {"plush_big", 5.273f, 2.574f, 2.332f, 0.70f},
                              {"plush_big_4k", 16.36f, 6.79f, 5.78f, 1.78f}};

struct Variant {
  Pipeline pipeline;
  CullMode mode;
  std::vector<float> frame, stages[kStageCount];
  double pairs = 0;
};

float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Variant> variants_of(const std::string& only) {
  std::vector<Variant> variants;
  for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
    if (!only.empty() && only != kPipelineNames[static_cast<int>(pipeline)]) continue;
    for (CullMode mode = 1; mode <= culler_count(); ++mode)
      variants.push_back({pipeline, mode, {}, {}});
  }
  return variants;
}

void measure(Renderer& renderer, const Camera& camera, int frames, std::vector<Variant>& variants,
             GpuClock& clock) {
  TurnOrder order;
  for (int round = -kWarmup; round < 2 * frames; ++round) {
    Outputs outputs;
    outputs.stage_times = round >= frames;
    for (const std::size_t turn : order.next(variants.size())) {
      Variant& samples = variants[turn];
      RenderSettings settings;
      settings.pipeline = samples.pipeline;
      settings.mode = samples.mode;
      const RenderStats& stats = renderer.render(camera, settings, outputs, DeviceImage{}).stats;
      if (round >= 0 && round < frames) samples.frame.push_back(stats.frame_ms);
      if (round >= 0) clock.sample();
      for (int stage = 0; stage < kStageCount && outputs.stage_times; ++stage) {
        samples.stages[stage].push_back(stats.stage_ms[stage]);
      }
      if (round == 0) samples.pairs += static_cast<double>(stats.tile_pairs);
    }
  }
}

void print_table(const Limits& limits, std::size_t cameras, std::vector<Variant>& variants) {
  std::printf("%-22s %9s %9s %10s %8s %8s %8s %10s\n", limits.set, "frame ms", "at most",
              "preprocess", "bin", "sort", "blend", "M pairs");
  for (Variant& samples : variants) {
    const std::string mode = mode_name(samples.mode);
    const std::string name =
        kPipelineNames[static_cast<int>(samples.pipeline)] + std::string(" ") + mode;
    const float limit = limits.of(samples.pipeline, mode);
    const float frame = median(samples.frame);
    char limit_text[16] = "-";
    if (limit > 0) std::snprintf(limit_text, sizeof limit_text, "%.3f", static_cast<double>(limit));
    char bin_text[16] = "-";  // part of other stages
    if (is_timed(Backend::cuda, samples.pipeline, Stage::bin))
      std::snprintf(bin_text, sizeof bin_text, "%.3f",
                    static_cast<double>(median(samples.stages[1])));
    std::printf("%-22s %9.3f %9s %10.3f %8s %8.3f %8.3f %10.3f%s\n", name.c_str(),
                static_cast<double>(frame), limit_text,
                static_cast<double>(median(samples.stages[0])), bin_text,
                static_cast<double>(median(samples.stages[2])),
                static_cast<double>(median(samples.stages[3])),
                samples.pairs / static_cast<double>(cameras) * 1e-6,
                limit > 0 && frame > limit ? "  TOO SLOW" : "");
  }
  std::printf("\n");
}

double now_ms() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now).count();
}

/// Prints the time of render() on the host's clock without and with Outputs::mode_pairs, for
/// alternating frames. (frame_ms does not include counting.)
void print_counting(Renderer& renderer, const Camera& camera, int frames, const char* set) {
  for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
    RenderSettings settings;
    settings.pipeline = pipeline;
    std::vector<float> ms[2];  // without, with
    for (int round = -kWarmup; round < frames; ++round) {
      for (int counts = 0; counts < 2; ++counts) {
        Outputs outputs;
        outputs.mode_pairs = counts == 1;
        const double begin = now_ms();
        renderer.render(camera, settings, outputs, DeviceImage{});
        if (round >= 0) ms[counts].push_back(static_cast<float>(now_ms() - begin));
      }
    }
    const auto plain = static_cast<double>(median(ms[0]));
    const auto counted = static_cast<double>(median(ms[1]));
    std::printf("%s %s: render() %.3f ms, with the pairs of all modes %.3f ms, ratio %.3f\n", set,
                kPipelineNames[static_cast<int>(pipeline)], plain, counted, counted / plain);
  }
  std::printf("\n");
}

/// Prints the times of the steps from a file to its first frame. `renderer` then has the scene.
void load(const fs::path& file, const Camera& camera, std::unique_ptr<Renderer>& renderer) {
  const double begin = now_ms();
  const GaussianCloud cloud = test::read_scene(file).cloud;
  const double read = now_ms();
  renderer = make_renderer(Backend::cuda, test::pool());
  const double made = now_ms();
  renderer->upload(cloud, {});
  const double uploaded = now_ms();
  renderer->render(camera, {}, {}, DeviceImage{});
  const double drawn = now_ms();
  activate(cloud, test::pool());
  const double activated = now_ms();
  renderer->upload(cloud, {});
  const double again = now_ms();
  std::printf("%s: read %.0f ms, renderer made %.0f, uploaded %.0f, first frame %.0f: %.0f ms\n",
              file.filename().c_str(), read - begin, made - read, uploaded - made, drawn - uploaded,
              drawn - begin);
  std::printf("  uploaded again: %.0f ms, of which activating takes %.0f\n\n", again - activated,
              activated - drawn);
}

/// The scenes of tests/raster/cuda/cuda_parity_test.cpp.
void measure_generated(int frames, const std::string& pipeline, GpuClock& clock) {
  for (const std::size_t count : {3000u, 20000u}) {
    const auto renderer = make_renderer(Backend::cuda, test::pool());
    renderer->upload(test::random_cloud(count, 3, 42), {});
    std::vector<Variant> variants = variants_of(pipeline);
    measure(*renderer, test::front_camera(320, 200), frames, variants, clock);
    const std::string name = std::to_string(count) + " generated";
    print_table({name.c_str(), 0, 0, 0, 0}, 1, variants);
  }
}

void measure_scenes(const fs::path& shared, int frames, const std::string& only,
                    const std::string& pipeline, GpuClock& clock) {
  const auto sets = nlohmann::json::parse(std::ifstream(shared / "golden/pairs.json"));
  std::string loaded;
  std::unique_ptr<Renderer> renderer;
  for (const Limits& limits : kLimits) {
    if (!only.empty() && only != limits.set) continue;
    const auto& set = sets[limits.set];
    const std::string scene = set["file"];
    const fs::path own = shared / ("golden/" + std::string(limits.set) + ".cameras.json");
    const auto cameras = read_cameras(fs::exists(own) ? own : shared / "scenes/plush/cameras.json");
    if (std::exchange(loaded, scene) != scene)
      load(shared / scene, cameras.at(set["cameras"][0].get<std::size_t>()), renderer);
    std::vector<Variant> variants = variants_of(pipeline);
    for (const auto& index : set["cameras"]) {
      measure(*renderer, cameras.at(index.get<std::size_t>()), frames, variants, clock);
    }
    print_table(limits, set["cameras"].size(), variants);
    print_counting(*renderer, cameras.at(set["cameras"][0].get<std::size_t>()), frames, limits.set);
  }
}

int run(const fs::path& shared, int frames, const std::string& only, const std::string& pipeline) {
  const std::string gpu = gpu_report().gpus.at(0).name;
  GpuClock clock(gpu_sensors(0));
  std::printf("%s, %d frames per mode and camera after %d, medians\n\n", gpu.c_str(), frames,
              kWarmup);
  if (only.empty() || only == "generated") measure_generated(frames, pipeline, clock);
  if (fs::exists(shared / "golden/pairs.json"))
    measure_scenes(shared, frames, only, pipeline, clock);
  const std::optional<GpuClockSummary> summary = clock.summary();
  std::printf("%s\n", clock_text(gpu, summary).c_str());
  if (const std::string warning = throttle_warning(summary); !warning.empty())
    std::printf("warning: %s\n", warning.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc > 1 ? fs::path(argv[1]) : qs::test::shared_folder(), argc > 2 ? std::atoi(argv[2]) : 100,
               argc > 3 ? argv[3] : "", argc > 4 ? argv[4] : "");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gpu_timings: %s\n", error.what());
    return 3;
  }
}
