// SPDX-License-Identifier: MIT
//
// The numbers of all modes on a real GPU: each mode has a sample at once, and samples of a moving
// camera come in turns. Prints the times, which are no part of the test.
#include <chrono>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "app/support/rendering_viewer.h"
#include "io/scene/reader.h"
#include "support/pool.h"
#include "support/shared.h"

namespace qs {
namespace {

class GpuNumbers : public test::RenderingViewer {
 protected:
  void SetUp() override {
    const std::string problem = gpu_report().problem;
    if (!problem.empty()) GTEST_SKIP() << "no GPU: " << problem;
  }

  double ms() const {
    const auto passed = std::chrono::steady_clock::now() - start_;
    return std::chrono::duration<double, std::milli>(passed).count();
  }

  // Shows a scene on the GPU and waits for its numbers.
  void measure(Scene scene, const char* name) {
    const std::size_t gaussians = scene.cloud.size();
    ViewedScene facts;
    facts.name = name;
    facts.path = scene.path = scenes_ / name;
    facts.core = core_box(scene.cloud);
    apply(call(action::resize, 1600, 1200));
    show(std::move(scene), facts, Backend::cuda);
    apply(call(action::frame_scene));
    const FrameRequest request = full_frame(viewer());
    draw(request);
    start_ = std::chrono::steady_clock::now();
    thread_.request(NumbersRequest{request.camera, request.settings, viewer().view_version});
    double first = 0, all = 0;
    while (viewer().numbers.rows.empty() && ms() < 60000) {
      take_reports();
      const std::size_t pairs = viewer().live.pairs.size();
      if (first == 0 && pairs > 0) first = ms();
      if (all == 0 && pairs + 1 == static_cast<std::size_t>(culler_count())) all = ms();
    }
    const double measured = ms();
    EXPECT_EQ(viewer().live.pairs.size() + 1, static_cast<std::size_t>(culler_count()));
    EXPECT_FALSE(viewer().numbers.rows.empty());
    fmt::print(
        "{}: {} Gaussians, first number {:.1f} ms, of all modes {:.1f} ms, measured {:.0f} ms; "
        "{:.2f} times the time of a flight without pairs\n",
        name, gaussians, first, all, measured, flight_ms(true) / flight_ms(false));
  }

  // Milliseconds of 600 frames in motion.
  double flight_ms(bool pairs) {
    FrameRequest request = full_frame(viewer());
    request.moving = true;
    request.pairs = pairs;
    start_ = std::chrono::steady_clock::now();
    for (int i = 0; i < 600; ++i) {
      thread_.request(request);
      while (!thread_.take_frame()) {
      }
    }
    const double result = ms();
    settle();
    return result;
  }

  std::chrono::steady_clock::time_point start_;
};

// Wall time of frames alone, of samples between them, and of frames behind samples.
TEST_F(GpuNumbers, of_frames_beside_samples) {
  const auto renderer = make_renderer(Backend::cuda, test::pool());
  renderer->upload(test::random_cloud(300'000, 3, 1), {});
  const Camera camera = test::front_camera(1600, 1200);
  const auto frame = [&](CullMode mode, const Target& target) {
    RenderSettings settings;
    settings.mode = mode;
    start_ = std::chrono::steady_clock::now();
    renderer->render(camera, settings, {}, target);
    return ms();
  };
  for (const Target& target : {Target(HostImage{}), Target(DeviceImage{})}) {
    for (const Target& other : {Target(HostImage{}), Target(DeviceImage{})}) {
      for (int i = 0; i < 20; ++i) frame(default_mode(), target);
      double alone = 0, sample = 0, behind = 0;
      for (int i = 0; i < 20; ++i) {
        alone += frame(default_mode(), target) / 20;
        sample += frame(1 + i % 4, other) / 20;
        behind += frame(default_mode(), target) / 20;
        frame(default_mode(), target);
      }
      fmt::print(
          "target {}, sample's {}: frame {:.2f} ms, sample {:.2f} ms, frame behind it {:.2f} ms\n",
          target.index(), other.index(), alone, sample, behind);
    }
  }
}

TEST_F(GpuNumbers, of_a_small_scene) {
  QS_NEEDS_SHARED("scenes/plush_small.spz");
  measure(read_scene(test::shared_path("scenes/plush_small.spz"), test::pool()), "plush_small");
}

TEST_F(GpuNumbers, of_a_large_scene) {
  QS_NEEDS_SHARED("scenes/plush_big.spz");
  measure(read_scene(test::shared_path("scenes/plush_big.spz"), test::pool()), "plush_big");
}

TEST_F(GpuNumbers, of_1_2_million_gaussians) {
  Scene scene;
  scene.cloud = test::random_cloud(1'200'000, 3, 1);
  measure(std::move(scene), "random");
}

}  // namespace
}  // namespace qs
