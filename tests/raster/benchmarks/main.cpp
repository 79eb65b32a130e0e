// SPDX-License-Identifier: MIT
// Benchmarks of the CPU backend's stages in both pipelines, on a generated scene of the parity
// tests, the bundled scene, and scenes of the shared folder if that exists.
//   cpu_benchmarks [Google Benchmark's options]
// Stages run on one thread, so that the column CPU contains all of their time. `threads/...` are
// whole frames on 1, 2, 4, ... threads; `threads/arithmetic` is a loop that uses only registers, to
// show the scaling of the machine itself. `counts/...` alternates frames of 1280x720 with and
// without Outputs::mode_pairs: medians of the CPU time of all threads in ms, and their ratio.
// `lpips/NETWORK/BACKEND` compares two pictures of 1024x1024 pixels on all threads, or on the GPU.
#include <algorithm>
#include <ctime>
#include <functional>
#include <memory>

#include <benchmark/benchmark.h>

#include "io/camera/cameras.h"
#include "io/scene/reader.h"
#include "learn/lpips/metric.h"
#include "raster/cpu/classic/classic.h"
#include "raster/cpu/fast/pipeline.h"
#include "support/lpips_weights.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace {

using namespace qs;

struct Subject {
  GaussianCloud cloud;
  Camera camera;
};

Subject open(const std::filesystem::path& scene, const std::filesystem::path& cameras) {
  return {test::read_scene(scene).cloud, read_cameras(cameras).front().resized(800, 600)};
}

/// The middle of the view, 1 / factor of its width and height, at the same size in pixels.
Subject zoomed(Subject subject, double factor) {
  subject.camera.focal_px *= factor;
  return subject;
}

Subject biker() {
  return {test::read_scene(test::shared_path("corpus/valid/biker.compressed.ply")).cloud,
          look_at({-0.4, -1.5, -2.6}, {-0.1, -1.5, 0}, {0, -1, 0}, 0.9, 800, 600)};
}

/// A frame of one subject. Its stages can be repeated one by one.
class Stages {
 public:
  explicit Stages(const Subject& subject)
      : subject_(subject),
        active_(activate(subject.cloud, pool_)),
        scene_(cpu::fast::make_scene(subject.cloud, pool_)),
        frame_{subject.cloud, subject_.camera,
               settings_,     TileGrid::of_image(subject.camera.width, subject.camera.height),
               pool_,         {}} {
    result_.color = Image(subject.camera.width, subject.camera.height, 3);
    for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
      for (const Stage stage : {Stage::preprocess, Stage::sort, Stage::bin, Stage::blend})
        run(pipeline, stage);
    }
  }

  void run(Pipeline pipeline, Stage stage) {
    pipeline == Pipeline::classic ? run_classic(stage) : run_fast(stage);
  }

 private:
  void run_classic(Stage stage) {
    using namespace cpu;
    switch (stage) {
      case Stage::preprocess:
        return preprocess(frame_, active_, visible_);
      case Stage::sort:
        return sort(frame_, visible_, order_);
      case Stage::bin:
        return bin(frame_, visible_, order_, lists_);
      case Stage::blend:
        return blend(frame_, visible_, lists_, {}, result_);
    }
  }

  void run_fast(Stage stage) {
    using namespace cpu::fast;
    switch (stage) {
      case Stage::preprocess:
        return preprocess(frame_, scene_, false, fast_visible_);
      case Stage::sort:
        return sort(frame_, fast_visible_, fast_bands_);
      case Stage::bin:
        return bin(frame_, fast_visible_, fast_bands_, fast_lists_);
      case Stage::blend:
        return blend(frame_, fast_visible_, fast_lists_, fast_queue_, {}, result_);
    }
  }

  const Subject& subject_;
  ThreadPool pool_{1};
  ActivatedCloud active_;
  cpu::fast::SceneBlocks scene_;
  RenderSettings settings_;
  cpu::FrameContext frame_;
  Frame result_;

  cpu::Visible visible_;
  cpu::DepthOrder order_;
  cpu::TileLists lists_;
  cpu::fast::FastVisible fast_visible_;
  cpu::fast::Bands fast_bands_;
  cpu::TileLists fast_lists_;
  cpu::fast::TileQueue fast_queue_;
};

/// The measured scenes, each read when the first benchmark needs it.
class Case {
 public:
  Case(std::string name, std::function<Subject()> open_it)
      : name_(std::move(name)), open_(std::move(open_it)) {}

  const std::string& name() const { return name_; }

  const Subject& subject() {
    if (!subject_) subject_ = std::make_unique<Subject>(open_());
    return *subject_;
  }
  Stages& stages() {
    if (!stages_) stages_ = std::make_unique<Stages>(subject());
    return *stages_;
  }

 private:
  std::string name_;
  std::function<Subject()> open_;
  std::unique_ptr<Subject> subject_;
  std::unique_ptr<Stages> stages_;
};

using Cases = std::vector<std::shared_ptr<Case>>;

Cases all_cases() {
  Cases cases;
  const auto add = [&](const std::string& name, std::function<Subject()> open_it) {
    cases.push_back(std::make_shared<Case>(name, std::move(open_it)));
  };
  add("random", [] {
    return Subject{test::random_cloud(3000, 3, 42), test::front_camera(320, 200)};
  });
  add("bundled", [] {
    return open(test::source_path("assets/plush.ply"), test::source_path("assets/cameras.json"));
  });
  for (const char* name : {"plush", "plush_big"}) {
    const auto scene = test::shared_path(std::string("scenes/") + name + ".spz");
    if (!std::filesystem::exists(scene)) continue;
    const auto open_it = [scene] {
      return open(scene, test::shared_path("scenes/plush/cameras.json"));
    };
    add(name, open_it);
    add(std::string(name) + "_zoomed", [open_it] { return zoomed(open_it(), 6); });
  }
  if (std::filesystem::exists(test::shared_path("corpus/valid/biker.compressed.ply")))
    add("biker", biker);
  return cases;
}

void run_frames(benchmark::State& state, const Subject& subject) {
  const auto renderer = make_renderer(Backend::cpu, test::pool(static_cast<int>(state.range(0))));
  renderer->upload(subject.cloud, {});
  renderer->render(subject.camera);  // buffers grow
  for (auto _ : state) renderer->render(subject.camera);
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void run_counts(benchmark::State& state, const Subject& subject) {
  const auto renderer = make_renderer(Backend::cpu, test::pool());
  renderer->upload(subject.cloud, {});
  const Camera camera = subject.camera.resized(1280, 720);
  std::vector<double> plain, counted;
  const auto draw = [&](bool counts, std::vector<double>& times) {
    Outputs outputs;
    outputs.mode_pairs = counts;
    const std::clock_t begin = std::clock();
    renderer->render(camera, {}, outputs);
    times.push_back(static_cast<double>(std::clock() - begin) * 1000 / CLOCKS_PER_SEC);
  };
  draw(true, counted);  // buffers grow
  counted.clear();
  for (auto _ : state) {
    draw(false, plain);
    draw(true, counted);
  }
  state.counters["frame_ms"] = median(plain);
  state.counters["counting_ms"] = median(counted);
  state.counters["ratio"] = median(counted) / median(plain);
}

void run_lpips(benchmark::State& state, const lpips::Network& network, Backend backend) {
  const int device = backend == Backend::cuda ? first_gpu() : 0;
  const LpipsDistance distance =
      make_lpips(backend, test::golden_weights(network), test::pool(), device);
  const auto [a, b] = test::golden_pictures(1024, 1024);
  if (backend == Backend::cuda) distance(a, b, lpips::InputRange::unit);  // buffers grow
  for (auto _ : state) benchmark::DoNotOptimize(distance(a, b, lpips::InputRange::unit));
}

/// Arithmetic in registers.
void run_arithmetic(benchmark::State& state) {
  ThreadPool pool(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    pool.for_chunks(64, 1, [](std::size_t, std::size_t, int) {
      float x[8] = {1, 2, 3, 4, 5, 6, 7, 8};
      for (int i = 0; i < 100'000; ++i) {
        for (float& value : x) value = value * 0.999f + 0.001f;
      }
      benchmark::DoNotOptimize(x);
    });
  }
}

void on_every_thread_count(benchmark::internal::Benchmark* benchmark) {
  benchmark->RangeMultiplier(2)
      ->Range(1, test::pool().size())
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  for (const auto& one : all_cases()) {
    for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
      for (int stage = 0; stage < kStageCount; ++stage) {
        const std::string name = one->name() + "/" + kPipelineNames[static_cast<int>(pipeline)] +
                                 "/" + kStageNames[stage];
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
          Stages& stages = one->stages();
          for (auto _ : state) stages.run(pipeline, static_cast<Stage>(stage));
        })->Unit(benchmark::kMillisecond);
      }
    }
    on_every_thread_count(benchmark::RegisterBenchmark(
        ("threads/" + one->name()).c_str(),
        [one](benchmark::State& state) { run_frames(state, one->subject()); }));
    benchmark::RegisterBenchmark(
        ("counts/" + one->name()).c_str(),
        [one](benchmark::State& state) { run_counts(state, one->subject()); })
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
  }
  for (const lpips::Network& network : lpips::kNetworks) {
    for (const Backend backend : available_backends()) {
      const std::string name =
          "lpips/" + std::string(network.name) + "/" + kBackendNames[static_cast<int>(backend)];
      benchmark::RegisterBenchmark(
          name.c_str(),
          [&network, backend](benchmark::State& state) { run_lpips(state, network, backend); })
          ->MeasureProcessCPUTime()
          ->UseRealTime()
          ->Unit(benchmark::kSecond);
    }
  }
  on_every_thread_count(benchmark::RegisterBenchmark("threads/arithmetic", run_arithmetic));
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
