// SPDX-License-Identifier: MIT
#include "raster/cpu/renderer.h"

#include <algorithm>
#include <cassert>

#include "base/fail.h"
#include "raster/cpu/classic/classic.h"
#include "raster/cpu/common/frame_context.h"
#include "raster/cpu/common/reference.h"
#include "raster/cpu/fast/pipeline.h"

namespace qs {
namespace cpu {
namespace {

class CpuRenderer final : public Renderer {
 public:
  explicit CpuRenderer(ThreadPool& pool) : pool_(pool) {}

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    progress.update(0);
    const std::function<void()> show = prepare_upload(std::move(cloud), pool_);
    progress.update(1);
    show();
  }

  std::function<void()> prepare_upload(std::shared_ptr<const GaussianCloud> cloud,
                                       ThreadPool& pool) override {
    const auto scene = std::make_shared<fast::SceneBlocks>(fast::make_scene(*cloud, pool));
    return [this, cloud = std::move(cloud), scene] {
      cloud_ = cloud;
      fast_.exchange(*scene);
      classic_ = {};
      drawn_ = GaussianSet();
      drawn_count_ = cloud_->size();
    };
  }

  void set_drawn(GaussianSet drawn) override {
    assert(drawn.size() == 0 || drawn.size() == cloud_->size());
    fast_.set_drawn(drawn, pool_);
    drawn_count_ = drawn.size() == 0 ? cloud_->size() : drawn.count();
    drawn_ = std::move(drawn);
  }

  void update(std::span<const std::uint32_t> changed) override {
    classic_.update(*cloud_, changed);
    if (fast_.update(*cloud_, changed, pool_)) return;
    fast_.upload(fast::make_scene(*cloud_, pool_));
    fast_.set_drawn(drawn_, pool_);
  }

  void report_frames_to(std::function<void(float fraction)> report) override {
    report_ = std::move(report);
  }

  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override {
    assert(settings.mode >= 0 && settings.mode <= mode_count());
    assert(camera.width > 0 && camera.height > 0);
    if (!std::holds_alternative<HostImage>(target))
      fail(ErrorKind::device, "backend cpu: it renders only into host memory");
    if (std::find(kTileSizes.begin(), kTileSizes.end(), settings.tile_px) == kTileSizes.end())
      fail(ErrorKind::device, "backend cpu: cannot use tiles of {} pixels, only 8, 16 or 32",
           settings.tile_px);
    const bool reference = settings.mode == kReferenceMode;
    const bool classic =
        !reference && (settings.pipeline == Pipeline::classic || settings.tile_px != kTileSize);
    if (classic || (!reference && outputs.used)) classic_.activate_once(*cloud_, pool_);

    const Stopwatch frame_clock;
    const double processor_seconds = pool_.processor_seconds();
    FrameContext frame{*cloud_,  camera,
                       settings, TileGrid::of_image(camera.width, camera.height, settings.tile_px),
                       pool_,    std::move(stop),
                       report_,  drawn(),
                       {}};
    if (outputs.seen && !outputs.share && !outputs.blends() && !outputs.pairs && !outputs.depth &&
        !outputs.trace)
      frame.only = outputs.seen->box;
    prepare_result(frame, outputs);
    if (classic) result_.stats.pipeline = Pipeline::classic;  // tiles of other sizes, too
    if (reference) {
      render_reference(frame, outputs, result_);
    } else if (classic) {
      classic_.draw(frame, outputs, result_);
    } else {
      fast_.draw(frame, outputs, result_);
      if (outputs.used) classic_.list(frame);
      if (outputs.used) classic_.count_used(frame, result_);
    }
    result_.stats.frame_ms = frame_clock.ms();
    result_.stats.cpu_ms =
        static_cast<float>(1e3 * (pool_.processor_seconds() - processor_seconds));
    if ((outputs.depth || outputs.seen || outputs.share) && !reference)
      fast_.pass_again(frame, !classic, outputs, result_);
    if (outputs.mode_pairs) count_modes(frame, outputs.counted);
    return result_;
  }

 private:
  const GaussianSet* drawn() const { return drawn_.size() == 0 ? nullptr : &drawn_; }

  void count_modes(const FrameContext& frame, const std::optional<CountedView>& counted) {
    const Stopwatch clock;
    const auto& [camera, settings] = counted.value_or(CountedView{frame.camera, frame.settings});
    const TileGrid grid = TileGrid::of_image(camera.width, camera.height, settings.tile_px);
    const FrameContext view{*cloud_, camera, settings, grid, pool_, frame.stop, {}, drawn()};
    mode_sums_.begin(pool_);
    if (settings.pipeline == Pipeline::fast && settings.tile_px == kTileSize) {
      fast_.count_modes(view, mode_sums_);
    } else {
      classic_.activate_once(*cloud_, pool_);
      classic_.count_modes(view, mode_sums_);
    }
    mode_sums_.store(result_);
    result_.stats.count_ms = clock.ms();
  }

  void prepare_result(const FrameContext& frame, const Outputs& outputs) {
    const int width = frame.camera.width, height = frame.camera.height;
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    result_.grid = frame.grid;
    result_.stats = {};
    result_.stats.gaussians = static_cast<std::uint32_t>(drawn_count_);
    result_.stats.threads = pool_.size();
    result_.stats.pipeline = frame.settings.pipeline;
    result_.pairs.clear();
    result_.used.clear();
    result_.mode_pairs.clear();
    result_.trace = {};
    result_.seen = GaussianSet(outputs.seen ? cloud_->size() : 0);
    result_.share.assign(outputs.share ? pixels : 0, 0.0f);
    for (std::vector<float>* map :
         {&result_.depth.alpha, &result_.depth.expected, &result_.depth.median}) {
      map->assign(outputs.depth ? pixels : 0, 0.0f);
    }
    result_.evaluated.assign(outputs.evaluated ? pixels : 0, 0);
    result_.color.width = outputs.color ? width : 0;
    result_.color.height = outputs.color ? height : 0;
    result_.color.channels = 3;
    result_.color.values.resize(outputs.color ? pixels * 3 : 0);  // every pixel is written
  }

  ThreadPool& pool_;
  std::shared_ptr<const GaussianCloud> cloud_ = std::make_shared<const GaussianCloud>();
  GaussianSet drawn_;  // of size 0: all
  std::size_t drawn_count_ = 0;
  std::function<void(float fraction)> report_;
  Classic classic_;
  fast::FastPipeline fast_;
  ModeSums mode_sums_;
  Frame result_;
};

}  // namespace
}  // namespace cpu

std::unique_ptr<Renderer> make_cpu_renderer(ThreadPool& pool) {
  return std::make_unique<cpu::CpuRenderer>(pool);
}

}  // namespace qs
