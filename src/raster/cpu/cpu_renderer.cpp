// SPDX-License-Identifier: MIT
#include "raster/cpu/cpu_renderer.h"

#include <algorithm>
#include <cassert>

#include "raster/base/fail.h"
#include "raster/cpu/classic/classic.h"
#include "raster/cpu/fast/pipeline.h"
#include "raster/cpu/reference.h"
#include "raster/cpu/stage_clock.h"

namespace qs {
namespace cpu {
namespace {

class CpuRenderer final : public Renderer {
 public:
  explicit CpuRenderer(int threads) : pool_(threads) {}

  void upload(const GaussianCloud& cloud, const Progress& progress) override {
    progress.update(0);
    active_ = activate(cloud, pool_);
    progress.update(0.5f);
    fast_.upload(cloud, active_, pool_);
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
    } else if (settings_.pipeline == qs::Pipeline::classic || settings_.tile_px != kTileSize) {
      classic_.draw(frame, outputs_, result_);
    } else {
      fast_.draw(frame, outputs_, result_);
      if (outputs_.used) classic_.count_used(frame, result_);
    }
    result_.stats.frame_ms = frame_clock.ms();
    return result_;
  }

 private:
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

  ThreadPool pool_;
  GaussianCloud cloud_;
  ActivatedCloud active_;
  Camera camera_;
  RenderSettings settings_;
  Outputs outputs_;
  std::stop_token stop_;
  Classic classic_;
  fast::Pipeline fast_;
  Frame result_;
};

}  // namespace
}  // namespace cpu

std::unique_ptr<Renderer> make_cpu_renderer(int threads) {
  return std::make_unique<cpu::CpuRenderer>(threads);
}

}  // namespace qs
