// SPDX-License-Identifier: MIT
#include <array>
#include <cassert>
#include <optional>

#include "raster/cuda/classic/classic.cuh"
#include "raster/cuda/common/gl_target.cuh"
#include "raster/cuda/common/gpu_info.h"
#include "raster/cuda/common/mode_pairs.cuh"
#include "raster/cuda/common/selection.cuh"
#include "raster/cuda/common/stream.cuh"
#include "raster/cuda/fast/pipeline.cuh"
#include "raster/cuda/renderer.h"

namespace qs {
namespace cuda {
namespace {

/// Frames that `classic` draws before `fast` is tried again, if both orders of the scene do not
/// fit: each try uploads the scene twice.
constexpr int kRestOfFast = 100;

class CudaRenderer final : public Renderer {
 public:
  CudaRenderer(ThreadPool& pool, int device)
      : pool_(pool), device_(device), stream_(device, true), gl_target_(device) {
    free_buffers();
  }

  ~CudaRenderer() override {
    cudaSetDevice(device_);
    cudaStreamSynchronize(stream_);  // a cancelled frame may still run
  }

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    select_device();
    clouds_ = {};  // the old scene is uploaded again if the new one does not fit
    making_room([&] { return free_buffers(); },
                [&] { upload_in(Order::space, *cloud, GaussianSet(), progress); });
    scene_ = std::move(cloud);
    drawn_ = GaussianSet();
    drawn_count_ = scene_->size();
    rest_of_fast_ = 0;
  }

  void set_drawn(GaussianSet drawn) override {
    assert(drawn.size() == 0 || drawn.size() == scene_->size());
    drawn_count_ = drawn.size() == 0 ? scene_->size() : drawn.count();
    drawn_ = std::move(drawn);
    change([&](DeviceCloud& cloud) {
      cuda::set_drawn(drawn_, stream_, cloud);
      return true;
    });
  }

  void update(std::span<const std::uint32_t> changed) override {
    change(
        [&](DeviceCloud& cloud) { return cuda::update(*scene_, changed, pool_, stream_, cloud); });
  }

  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override {
    assert(settings.mode >= 0 && settings.mode <= mode_count());
    assert(camera.width > 0 && camera.height > 0);
    if (settings.mode == kReferenceMode)
      throw Error(ErrorKind::device, "cuda: mode reference runs on the backend cpu only");
    if (settings.tile_px != kTileSize)
      throw Error(ErrorKind::device, "cuda: tiles of " + std::to_string(settings.tile_px) +
                                         " pixels run on the backend cpu only");
    select_device();
    const auto* texture = outputs.color ? std::get_if<GlTexture>(&target) : nullptr;
    const TileGrid grid = TileGrid::of_image(camera.width, camera.height);
    const auto frame_of = [&](Order order) {
      const DeviceCloud& cloud = cloud_in(order, stop);
      const auto enqueue_behind = [&, &cloud = cloud] {
        if (texture != nullptr)
          gl_target_.present(pixels_.color.data(), camera.width, camera.height, stream_);
        if (outputs.mode_pairs)
          mode_counter_.enqueue(cloud, outputs.counted.value_or(CountedView{camera, settings}),
                                stream_);
      };
      return FrameContext{cloud, camera, settings, grid, stream_, stop, enqueue_behind};
    };
    prepare_result(grid);
    if (texture != nullptr) gl_target_.map(*texture);
    try {
      const auto draw_by_fast = [&] {
        const FrameContext frame = frame_of(Order::space);
        if (!fast_->draw(frame, outputs, pixels_, clock_)) return false;
        collect(*fast_, frame, outputs, target);
        return true;
      };
      const auto draw_by_classic = [&] {
        const FrameContext frame = frame_of(Order::file);
        classic_->draw(frame, outputs, pixels_, clock_);
        collect(*classic_, frame, outputs, target);
      };
      const bool tries_fast = fast_draws(settings, grid);
      bool is_drawn = false;
      if (tries_fast) {
        is_drawn = making_room([&] { return free_all_but(Order::space); }, draw_by_fast);
        result_.stats.pipeline = Pipeline::fast;
      }
      if (!is_drawn) {
        making_room([&] { return free_all_but(Order::file); }, draw_by_classic);
        if (tries_fast && !cloud(Order::space)) rest_of_fast_ = kRestOfFast;
        result_.stats.pipeline = Pipeline::classic;
      }
      if (texture != nullptr) result_.stats.present_ms = gl_target_.present_ms();
    } catch (...) {
      cudaStreamSynchronize(stream_);
      if (texture != nullptr) gl_target_.unmap();
      throw;
    }
    if (texture != nullptr) gl_target_.unmap();
    return result_;
  }

  void prepare_target(const Target& target) override {
    const auto* texture = std::get_if<GlTexture>(&target);
    select_device();
    if (texture == nullptr)
      gl_target_.unmap();
    else
      gl_target_.map(*texture);
  }

 private:
  void select_device() const { check(cudaSetDevice(device_), "cudaSetDevice"); }

  void prepare_result(TileGrid grid) {
    Image color = std::move(result_.color);  // reuses its memory
    result_ = {};
    result_.color = std::move(color);
    result_.color.channels = 3;
    result_.grid = grid;
    result_.stats.gaussians = static_cast<std::uint32_t>(drawn_count_);
  }

  /// False while `classic` draws because `fast` could not, and both orders do not fit.
  bool fast_draws(const RenderSettings& settings, TileGrid grid) {
    if (settings.pipeline != Pipeline::fast || !fast::FastPipeline::can_draw(grid)) return false;
    if (cloud(Order::space) || rest_of_fast_ == 0) return true;
    return --rest_of_fast_ == 0;
  }

  /// Changes the uploaded orders of the scene. If that fails, the next frame uploads them again.
  template <class Change>
  void change(const Change& change_cloud) {
    select_device();
    for (std::optional<DeviceCloud>& cloud : clouds_) try {
        if (cloud && !change_cloud(*cloud)) cloud.reset();
      } catch (const Error&) {
        cloud.reset();
      }
  }

  /// Frees the buffers of both pipelines, which grow again. Returns true.
  bool free_buffers() {
    cudaStreamSynchronize(stream_);
    fast_.emplace(device_);
    classic_.emplace();
    pixels_ = {};
    return true;
  }

  /// Frees both pipelines' buffers and the other copy of the scene. True, as making_room() expects.
  bool free_all_but(Order order) {
    free_buffers();
    cloud(order == Order::space ? Order::file : Order::space).reset();
    return true;
  }

  /// The scene in one order. It is uploaded when a pipeline first needs it, and stays beside the
  /// other order if memory is plentiful.
  const DeviceCloud& cloud_in(Order order, const std::stop_token& stop) {
    if (!cloud(order).has_value()) {
      const std::uint64_t bytes = scene_bytes(*scene_, order);
      if (bytes > DeviceMemory::now().free / 2) clouds_ = {};
      upload_in(order, *scene_, drawn_, {{}, stop});
    }
    return *cloud(order);
  }

  std::optional<DeviceCloud>& cloud(Order order) {
    return clouds_[static_cast<std::size_t>(order)];
  }

  void upload_in(Order order, const GaussianCloud& scene, const GaussianSet& drawn,
                 const Progress& progress) {
    DeviceCloud uploaded;
    cuda::upload(scene, order, pool_, progress, stream_, uploaded);
    cuda::set_drawn(drawn, stream_, uploaded);
    cloud(order) = std::move(uploaded);
  }

  /// Fills the result from a drawn frame.
  template <class AnyPipeline>
  void collect(AnyPipeline& pipeline, const FrameContext& frame, const Outputs& outputs,
               const Target& target) {
    pipeline.collect(frame, outputs, pixels_, result_);
    if (outputs.used) result_.stats.used_pairs = sum_of(result_.used);
    clock_.read(result_.stats);
    if (outputs.depth) pipeline.draw_depth(frame, pixels_);
    collect_maps(frame.camera, frame.settings.mode, outputs, target);
    if (outputs.seen || outputs.share)
      selection_.fill(frame, pipeline.lists(frame), outputs, result_);
  }

  /// Waits for the frame and copies the requested maps to the host.
  void collect_maps(const Camera& camera, CullMode mode, const Outputs& outputs,
                    const Target& target) {
    check(cudaStreamSynchronize(stream_), "frame");
    if (outputs.mode_pairs) result_.mode_pairs = mode_counter_.result();
    if (outputs.mode_pairs && !outputs.counted && result_.stats.is_occluded) {
      const ModePairs& own = result_.mode_pairs[static_cast<std::size_t>(mode - 1)];
      result_.stats.visible = own.visible;
      result_.stats.tile_pairs = own.tile_pairs;
    }
    const std::size_t pixels = Pixels::count_of(camera);
    const bool stays = std::holds_alternative<DeviceImage>(target);
    const bool wanted = outputs.color && std::holds_alternative<HostImage>(target);
    if (stays && outputs.color) result_.on_device.color = pixels_.color.data();
    result_.color.width = wanted ? camera.width : 0;
    result_.color.height = wanted ? camera.height : 0;
    result_.color.values.resize(wanted ? 3 * pixels : 0);
    copy_to_host(pixels_.color.data(), result_.color.values.data(), result_.color.values.size(),
                 stream_);
    if (outputs.evaluated) result_.evaluated = copied(pixels_.evaluated.data(), pixels, stream_);
    if (!outputs.depth) return;
    const float* const maps = pixels_.depth.data();
    const auto map = [&](std::size_t number) { return maps + number * pixels; };
    if (stays) {
      DeviceMaps& depth = result_.on_device;
      depth.alpha = map(0);
      depth.expected = map(1);
      depth.median = map(2);
    } else {
      result_.depth = {copied(map(0), pixels, stream_), copied(map(1), pixels, stream_),
                       copied(map(2), pixels, stream_)};
    }
  }

  ThreadPool& pool_;
  int device_;
  Stream stream_;
  StageClock clock_;
  std::shared_ptr<const GaussianCloud> scene_ = std::make_shared<const GaussianCloud>();
  GaussianSet drawn_;  // of size 0: all
  std::size_t drawn_count_ = 0;
  std::array<std::optional<DeviceCloud>, 2> clouds_;  // by order, on the GPU
  Pixels pixels_;
  GlTarget gl_target_;
  ModeCounter mode_counter_;
  Selection selection_;
  // Optional, so that their buffers can be freed; never empty.
  std::optional<classic::ClassicPipeline> classic_;
  std::optional<fast::FastPipeline> fast_;
  int rest_of_fast_ = 0;  // frames, see fast_draws()
  Frame result_;
};

}  // namespace
}  // namespace cuda

std::unique_ptr<Renderer> make_cuda_renderer(ThreadPool& pool, int device) {
  cuda::require_gpu(device);
  return std::make_unique<cuda::CudaRenderer>(pool, device);
}

}  // namespace qs
