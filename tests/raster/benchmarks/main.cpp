// SPDX-License-Identifier: MIT
// The stages of the CPU backend one by one, in both pipelines: a generated scene of the parity
// tests, the bundled scene, and scenes of the shared folder where it is.
//   cpu_benchmarks [Google Benchmark's options]
// Stages run on one thread, so that the column CPU is theirs. `threads/...` are whole frames on 1,
// 2, 4, ... threads, beside `threads/arithmetic`, a loop that needs nothing but cores.
#include <benchmark/benchmark.h>

#include "io/cameras.h"
#include "io/reader.h"
#include "raster/cpu/classic.h"
#include "raster/cpu/fast/blend.h"
#include "raster/cpu/fast/pipeline.h"
#include "support/scenes.h"
#include "support/shared.h"

namespace {

using namespace qs;

struct Subject {
  std::string name;
  GaussianCloud cloud;
  Camera camera;
};

Subject open(const std::string& name, const std::filesystem::path& scene,
             const std::filesystem::path& cameras) {
  return {name, read_scene(scene).cloud, read_cameras(cameras).front().resized(800, 600)};
}

std::vector<Subject> subjects() {
  std::vector<Subject> all;
  all.push_back({"random", test::random_cloud(3000, 3, 42), test::front_camera(320, 200)});
  all.push_back(open("bundled", test::source_path("assets/plush.ply"),
                     test::source_path("assets/cameras.json")));
  for (const char* name : {"plush", "plush_big"}) {
    const auto scene = test::shared_path(std::string("scenes/") + name + ".spz");
    if (std::filesystem::exists(scene))
      all.push_back(open(name, scene, test::shared_path("scenes/plush/cameras.json")));
  }
  const auto biker = test::shared_path("corpus/valid/biker.compressed.ply");
  if (std::filesystem::exists(biker)) {
    all.push_back({"biker", read_scene(biker).cloud,
                   look_at({-1.5, 0.2, -2.5}, {0, 0.2, 0}, {0, -1, 0}, 0.8, 800, 600)});
  }
  return all;
}

/// A frame of one subject whose stages can be repeated one by one.
class Stages {
 public:
  explicit Stages(const Subject& subject)
      : subject_(subject),
        active_(activate(subject.cloud, pool_)),
        blocks_(cpu::fast::make_blocks(active_, pool_)),
        harmonics_(cpu::fast::make_harmonics(subject.cloud, pool_)),
        frame_{subject.cloud,
               active_,
               subject_.camera,
               settings_,
               TileGrid::of_image(subject.camera.width, subject.camera.height),
               pool_,
               {}} {
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
        return preprocess(frame_, visible_);
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
        return preprocess(frame_, blocks_, harmonics_, false, fast_visible_);
      case Stage::sort:
        return sort(frame_, fast_visible_, fast_order_);
      case Stage::bin:
        return bin(frame_, fast_visible_, fast_order_, fast_lists_);
      case Stage::blend:
        return blend(frame_, fast_visible_, fast_lists_, {}, result_);
    }
  }

  const Subject& subject_;
  ThreadPool pool_{1};
  ActivatedCloud active_;
  Array<cpu::fast::Block> blocks_;
  cpu::fast::Harmonics harmonics_;
  RenderSettings settings_;
  cpu::FrameContext frame_;
  Frame result_;

  cpu::Visible visible_;
  cpu::DepthOrder order_;
  cpu::TileLists lists_;
  cpu::fast::Visible fast_visible_;
  cpu::fast::DepthOrder fast_order_;
  cpu::TileLists fast_lists_;
};

void run_frames(benchmark::State& state, const Subject& subject) {
  const auto renderer = make_renderer(Backend::cpu, {.threads = static_cast<int>(state.range(0))});
  renderer->upload(subject.cloud, {});
  renderer->render(subject.camera);  // buffers grow
  for (auto _ : state) renderer->render(subject.camera);
}

/// Multiplies and adds in registers.
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
      ->Range(1, ThreadPool().size())
      ->UseRealTime()
      ->Unit(benchmark::kMillisecond);
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  const std::vector<Subject> all = subjects();
  for (const Subject& subject : all) {
    const auto stages = std::make_shared<Stages>(subject);
    for (const Pipeline pipeline : {Pipeline::classic, Pipeline::fast}) {
      for (int stage = 0; stage < kStageCount; ++stage) {
        const std::string name = subject.name + "/" + kPipelineNames[static_cast<int>(pipeline)] +
                                 "/" + kStageNames[stage];
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
          for (auto _ : state) stages->run(pipeline, static_cast<Stage>(stage));
        })->Unit(benchmark::kMillisecond);
      }
    }
    on_every_thread_count(benchmark::RegisterBenchmark(
        ("threads/" + subject.name).c_str(),
        [&subject](benchmark::State& state) { run_frames(state, subject); }));
  }
  on_every_thread_count(benchmark::RegisterBenchmark("threads/arithmetic", run_arithmetic));
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
