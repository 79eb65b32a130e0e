// SPDX-License-Identifier: MIT
#include "raster/cpu/cpu_renderer.h"

#include <algorithm>
#include <cassert>
#include <chrono>

#include "raster/cpu/blend.h"
#include "raster/cpu/reference.h"
#include "raster/cpu/used.h"
#include "raster/scene/fail.h"

namespace qs {
namespace cpu {
namespace {

class Stopwatch {
 public:
  float ms() const {
    return std::chrono::duration<float, std::milli>(std::chrono::steady_clock::now() - start_)
        .count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

class CpuRenderer final : public Renderer {
 public:
  explicit CpuRenderer(int threads) : pool_(threads) {}

  void upload(const GaussianCloud& cloud, const Progress& progress) override {
    progress.update(0);
    active_ = activate(cloud, pool_);
    progress.update(0.5f);
    cloud_ = cloud;  // colours are evaluated from the original coefficients, the reference from
                     // everything
    progress.update(1);
  }

  void submit(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
              const Target& target, std::stop_token stop) override {
    assert(settings.mode >= 0 && settings.mode <= kCullerCount);
    assert(camera.width > 0 && camera.height > 0);
    if (!std::holds_alternative<HostImage>(target)) {
      fail(ErrorKind::device, "backend cpu: it draws into memory of the host only");
    }
    if (std::find(kTileSizes.begin(), kTileSizes.end(), settings.tile_px) == kTileSizes.end()) {
      fail(ErrorKind::device, "backend cpu: tiles of {} pixels: it knows 8, 16 and 32",
           settings.tile_px);
    }
    camera_ = camera;
    settings_ = settings;
    outputs_ = outputs;
    stop_ = std::move(stop);
  }

  // All work happens here: whoever owns the renderer gives it a thread by waiting.
  const Frame& wait() override {
    const Stopwatch frame_clock;
    const TileGrid grid = TileGrid::of_image(camera_.width, camera_.height, settings_.tile_px);
    const FrameContext frame{cloud_, active_, camera_, settings_, grid, pool_, stop_};
    prepare_result(frame.grid);
    if (settings_.mode == kReferenceMode) {
      render_reference(frame, outputs_, result_);
    } else {
      timed(Stage::preprocess, [&] { preprocess(frame, visible_); });
      timed(Stage::sort, [&] { sort(frame, visible_, order_); });
      timed(Stage::bin, [&] { bin(frame, visible_, order_, lists_); });
      if (outputs_.color || outputs_.evaluated) {
        timed(Stage::blend, [&] { blend(frame, visible_, lists_, outputs_, result_); });
      }
      if (outputs_.used) count_used(frame, visible_, lists_, result_);
      collect_lists();
    }
    result_.stats.frame_ms = frame_clock.ms();
    return result_;
  }

 private:
  template <class Work>
  void timed(Stage stage, const Work& work) {
    const Stopwatch clock;
    work();
    result_.stats.stage_ms[static_cast<int>(stage)] = clock.ms();
  }

  void prepare_result(TileGrid grid) {
    const auto pixels =
        static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
    result_.grid = grid;
    result_.stats = {};
    result_.stats.gaussians = static_cast<std::uint32_t>(cloud_.size());
    result_.stats.threads = pool_.size();
    result_.pairs.clear();
    result_.used.clear();
    result_.trace = {};
    result_.evaluated.assign(outputs_.evaluated ? pixels : 0, 0);
    result_.color.width = outputs_.color ? camera_.width : 0;
    result_.color.height = outputs_.color ? camera_.height : 0;
    result_.color.channels = 3;
    result_.color.values.resize(outputs_.color ? pixels * 3 : 0);  // every pixel is written
  }

  void collect_lists() {
    RenderStats& stats = result_.stats;
    stats.visible = visible_.count;
    stats.tile_pairs = lists_.pairs();
    const auto tiles = static_cast<std::size_t>(result_.grid.count());
    for (std::size_t tile = 0; tile < tiles; ++tile) {
      stats.max_pairs_in_a_tile = std::max(stats.max_pairs_in_a_tile, lists_.pairs(tile));
      if (outputs_.pairs) result_.pairs.push_back(lists_.pairs(tile));
    }
    if (outputs_.used) stats.used_pairs = sum_of(result_.used);
    if (outputs_.trace) collect_trace();
  }

  void collect_trace() {
    Trace& trace = result_.trace;
    visible_.for_each([&](std::uint32_t slot) {
      trace.gaussians.push_back(visible_.gaussians[slot]);
      trace.footprints.push_back(visible_.footprints[slot]);
      trace.depths.push_back(visible_.depths[slot]);
      trace.splats.push_back(visible_.records[slot].splat);
    });
    trace.tile_begin = lists_.begin;
    trace.listed.resize(lists_.slots.size());
    for (std::size_t i = 0; i < trace.listed.size(); ++i)
      trace.listed[i] = visible_.gaussians[lists_.slots[i]];
  }

  ThreadPool pool_;
  GaussianCloud cloud_;
  ActivatedCloud active_;
  Camera camera_;
  RenderSettings settings_;
  Outputs outputs_;
  std::stop_token stop_;
  Visible visible_;
  DepthOrder order_;
  TileLists lists_;
  Frame result_;
};

}  // namespace
}  // namespace cpu

std::unique_ptr<Renderer> make_cpu_renderer(int threads) {
  return std::make_unique<cpu::CpuRenderer>(threads);
}

}  // namespace qs
