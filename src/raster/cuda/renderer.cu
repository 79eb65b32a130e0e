// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <cassert>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

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

/// The memory of one frame at a time, and its result.
struct Lane {
  explicit Lane(int device) : stream(device, true), fast(std::in_place, device) {}
  Lane& operator=(Lane&&) = delete;
  ~Lane() { cudaStreamSynchronize(stream); }  // a cancelled frame may still run

  Stream stream;
  Event uploaded;  ///< the scene, which this lane uploads
  StageClock clock;
  Pixels pixels;
  ModeCounter mode_counter;
  std::optional<fast::FastPipeline> fast;  // so that its buffers can be freed; never empty
  Frame result;
};

/// The number of frames of `pixels` each that are drawn at the same time: as many as fill a GPU,
/// because a small frame leaves most of its multiprocessors idle. `made`: lanes that there are. New
/// ones take at most a quarter of the free memory. For measurements and tests QUADSPLAT_LANES=N
/// overrides it.
std::size_t lanes_for(std::size_t pixels, std::size_t gaussians, std::size_t made) {
  constexpr std::size_t kMost = 24, kPixels = 24 << 20;
  constexpr std::size_t kBytesOfGaussian = 104, kBytesOfPixel = 25;  // see fast::Scratch
  if (const char* forced = std::getenv("QUADSPLAT_LANES")) {
    unsigned lanes = 0;
    if (std::sscanf(forced, "%u", &lanes) == 1 && lanes > 0) return lanes;
  }
  const std::size_t wanted = std::min(kMost, kPixels / pixels + 1);
  if (wanted <= made) return wanted;
  const std::size_t fitting =
      DeviceMemory::now().free / 4 / (gaussians * kBytesOfGaussian + pixels * kBytesOfPixel + 1);
  return std::min(wanted, made + fitting);
}

class CudaRenderer final : public Renderer {
 public:
  CudaRenderer(ThreadPool& pool, int device) : pool_(pool), device_(device), gl_target_(device) {
    lanes_.emplace_back(device);
    free_buffers();
  }

  ~CudaRenderer() override { cudaSetDevice(device_); }

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    select_device();
    clouds_ = {};  // the old scene is uploaded again if the new one does not fit
    making_room([&] { return free_buffers(); },
                [&] { upload_in(Order::space, *cloud, GaussianSet(), progress); });
    show(std::move(cloud));
  }

  std::function<void()> prepare_upload(std::shared_ptr<const GaussianCloud> cloud,
                                       ThreadPool& pool) override {
    select_device();
    if (scene_bytes(*cloud, Order::space) > DeviceMemory::now().free / 2) return {};
    const auto uploaded = std::make_shared<DeviceCloud>();
    try {
      const Stream stream(device_, false);
      cuda::upload(*cloud, Order::space, pool, {}, stream, *uploaded);
      cuda::expect_updates(stream, *uploaded);
    } catch (const Error&) {  // the memory became short
      return {};
    }
    const auto old = std::make_shared<std::array<std::optional<DeviceCloud>, 2>>();
    return [this, cloud = std::move(cloud), uploaded, old] {
      select_device();
      *old = std::exchange(clouds_, {});
      this->cloud(Order::space) = std::move(*uploaded);
      show(cloud);
    };
  }

  void set_drawn(GaussianSet drawn) override {
    assert(drawn.size() == 0 || drawn.size() == scene_->size());
    drawn_count_ = drawn.size() == 0 ? scene_->size() : drawn.count();
    drawn_ = std::move(drawn);
    change([&](DeviceCloud& cloud) {
      cuda::set_drawn(drawn_, lane().stream, cloud);
      return true;
    });
  }

  void update(std::span<const std::uint32_t> changed) override {
    change([&](DeviceCloud& cloud) {
      return cuda::update(*scene_, changed, pool_, lane().stream, cloud);
    });
  }

  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override {
    check_frame(camera, settings);
    select_device();
    const auto* texture = outputs.color ? std::get_if<GlTexture>(&target) : nullptr;
    const TileGrid grid = TileGrid::of_image(camera.width, camera.height);
    Frame& result = lane().result;
    prepare_result(grid, result);
    if (texture != nullptr) gl_target_.map(*texture);
    try {
      const auto draw_by_fast = [&] {
        const FrameContext frame =
            frame_in(lane(), Order::space, camera, settings, outputs, target, stop);
        lane().fast->enqueue(frame, outputs, lane().pixels, lane().clock);
        if (!lane().fast->finish(frame, outputs, lane().pixels, lane().clock)) return false;
        collect(lane(), *lane().fast, frame, outputs, target);
        return true;
      };
      const auto draw_by_classic = [&] {
        const FrameContext frame =
            frame_in(lane(), Order::file, camera, settings, outputs, target, stop);
        classic_->draw(frame, outputs, lane().pixels, lane().clock);
        collect(lane(), *classic_, frame, outputs, target);
      };
      const bool tries_fast = fast_draws(settings, grid);
      bool is_drawn = false;
      if (tries_fast) {
        is_drawn = making_room([&] { return free_all_but(Order::space); }, draw_by_fast);
        result.stats.pipeline = Pipeline::fast;
      }
      if (!is_drawn) {
        making_room([&] { return free_all_but(Order::file); }, draw_by_classic);
        if (tries_fast && !cloud(Order::space)) rest_of_fast_ = kRestOfFast;
        result.stats.pipeline = Pipeline::classic;
      }
      if (texture != nullptr) result.stats.present_ms = gl_target_.present_ms();
    } catch (...) {
      cudaStreamSynchronize(lane().stream);
      if (texture != nullptr) gl_target_.unmap();
      throw;
    }
    if (texture != nullptr) gl_target_.unmap();
    return result;
  }

  void render_each(std::span<const Camera> cameras, const RenderSettings& settings,
                   const Outputs& outputs, const Target& target, std::stop_token stop,
                   const UseFrame& use) override {
    const std::size_t drawn = draw_in_lanes(cameras, settings, outputs, target, stop, use);
    for (std::size_t i = drawn; i < cameras.size(); ++i)
      use(render(cameras[i], settings, outputs, target, stop), i);
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
  /// Of the frames that are drawn alone, and of uploads.
  Lane& lane() { return lanes_.front(); }

  static void check_frame([[maybe_unused]] const Camera& camera, const RenderSettings& settings) {
    assert(settings.mode >= 0 && settings.mode <= mode_count());
    assert(camera.width > 0 && camera.height > 0);
    if (settings.mode == kReferenceMode)
      throw Error(ErrorKind::device, "cuda: mode reference runs on the backend cpu only");
    if (settings.tile_px != kTileSize)
      throw Error(ErrorKind::device, "cuda: tiles of " + std::to_string(settings.tile_px) +
                                         " pixels run on the backend cpu only");
  }

  FrameContext frame_in(Lane& lane, Order order, const Camera& camera,
                        const RenderSettings& settings, const Outputs& outputs,
                        const Target& target, const std::stop_token& stop, std::size_t number = 0) {
    const DeviceCloud& cloud = cloud_in(order, stop);
    const auto enqueue_behind = [&] {
      if (outputs.color && std::holds_alternative<GlTexture>(target))
        gl_target_.present(lane.pixels.color.data(), camera.width, camera.height, lane.stream);
      if (outputs.mode_pairs)
        lane.mode_counter.enqueue(cloud, outputs.counted.value_or(CountedView{camera, settings}),
                                  lane.stream);
    };
    return {cloud,       camera, settings,       TileGrid::of_image(camera.width, camera.height),
            lane.stream, stop,   enqueue_behind, number};
  }

  /// Draws frames in turns in several lanes by `fast`, while the results of earlier ones are used,
  /// and returns their number: all, unless memory is short or a frame is not of this kind.
  std::size_t draw_in_lanes(std::span<const Camera> cameras, const RenderSettings& settings,
                            const Outputs& outputs, const Target& target,
                            const std::stop_token& stop, const UseFrame& use) {
    const auto is_of_fast = [&](const Camera& camera) {
      check_frame(camera, settings);
      return fast::FastPipeline::can_draw(TileGrid::of_image(camera.width, camera.height));
    };
    if (cameras.size() < 2 || settings.pipeline != Pipeline::fast || rest_of_fast_ > 0 ||
        outputs.stage_times || !std::holds_alternative<DeviceImage>(target) ||
        !std::ranges::all_of(cameras, is_of_fast))
      return 0;
    select_device();
    std::size_t used = 0, pixels = 1;
    bool in_use = false;
    for (const Camera& camera : cameras) pixels = std::max(pixels, Pixels::count_of(camera));
    const auto failed = [&] {
      for (Lane& each : lanes_) cudaStreamSynchronize(each.stream);
      free_buffers();
      return used;
    };
    std::deque<FrameContext> frames;  // enqueued, of the cameras after `used`
    try {
      cloud_in(Order::space, stop);
      const std::size_t lanes =
          std::min(lanes_for(pixels, scene_->size(), lanes_.size()), cameras.size());
      while (lanes_.size() < lanes) lanes_.emplace_back(device_);
      lane().uploaded.record(lane().stream);
      for (Lane& each : lanes_) lane().uploaded.make_wait(each.stream);
      for (std::size_t next = 0; used < cameras.size();) {
        for (; next < std::min(used + lanes, cameras.size()); ++next) {
          Lane& own = lanes_[next % lanes];
          prepare_result(TileGrid::of_image(cameras[next].width, cameras[next].height), own.result);
          frames.push_back(
              frame_in(own, Order::space, cameras[next], settings, outputs, target, stop, next));
          own.fast->enqueue(frames.back(), outputs, own.pixels, own.clock);
        }
        Lane& own = lanes_[used % lanes];
        if (!own.fast->finish(frames.front(), outputs, own.pixels, own.clock)) return failed();
        collect(own, *own.fast, frames.front(), outputs, target);
        own.result.stats.pipeline = Pipeline::fast;
        frames.pop_front();
        in_use = true;
        use(own.result, used++);
        in_use = false;
      }
    } catch (const Error& error) {
      if (in_use || error.kind() != ErrorKind::device) throw;
      return failed();
    }
    return used;
  }

  void select_device() const { check(cudaSetDevice(device_), "cudaSetDevice"); }

  void prepare_result(TileGrid grid, Frame& result) const {
    Image color = std::move(result.color);  // reuses its memory
    result = {};
    result.color = std::move(color);
    result.color.channels = 3;
    result.grid = grid;
    result.stats.gaussians = static_cast<std::uint32_t>(drawn_count_);
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
    while (lanes_.size() > 1) lanes_.pop_back();
    cudaStreamSynchronize(lane().stream);
    lane().fast.emplace(device_);
    classic_.emplace();
    lane().pixels = {};
    return true;
  }

  /// All Gaussians of the scene that is on the GPU now.
  void show(std::shared_ptr<const GaussianCloud> scene) {
    scene_ = std::move(scene);
    drawn_ = GaussianSet();
    drawn_count_ = scene_->size();
    rest_of_fast_ = 0;
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
    cuda::upload(scene, order, pool_, progress, lane().stream, uploaded);
    cuda::set_drawn(drawn, lane().stream, uploaded);
    cloud(order) = std::move(uploaded);
  }

  /// Fills the result from a drawn frame.
  template <class AnyPipeline>
  void collect(Lane& lane, AnyPipeline& pipeline, const FrameContext& frame, const Outputs& outputs,
               const Target& target) {
    pipeline.collect(frame, outputs, lane.pixels, lane.result);
    if (outputs.used) lane.result.stats.used_pairs = sum_of(lane.result.used);
    lane.clock.read(lane.result.stats);
    if (outputs.depth) pipeline.draw_depth(frame, lane.pixels);
    collect_maps(lane, frame.camera, frame.settings.mode, outputs, target);
    if (outputs.seen || outputs.share)
      selection_.fill(frame, pipeline.lists(frame), outputs, lane.result);
  }

  /// Waits for the frame and copies the requested maps to the host.
  static void collect_maps(Lane& lane, const Camera& camera, CullMode mode, const Outputs& outputs,
                           const Target& target) {
    const cudaStream_t stream = lane.stream;
    Pixels& drawn = lane.pixels;
    Frame& result = lane.result;
    check(cudaStreamSynchronize(stream), "frame");
    if (outputs.mode_pairs) result.mode_pairs = lane.mode_counter.result();
    if (outputs.mode_pairs && !outputs.counted && result.stats.is_occluded) {
      const ModePairs& own = result.mode_pairs[static_cast<std::size_t>(mode - 1)];
      result.stats.visible = own.visible;
      result.stats.tile_pairs = own.tile_pairs;
    }
    const std::size_t pixels = Pixels::count_of(camera);
    const bool stays = std::holds_alternative<DeviceImage>(target);
    const bool wanted = outputs.color && std::holds_alternative<HostImage>(target);
    if (stays) result.on_device.stream = stream;
    if (stays && outputs.color) result.on_device.color = drawn.color.data();
    result.color.width = wanted ? camera.width : 0;
    result.color.height = wanted ? camera.height : 0;
    result.color.values.resize(wanted ? 3 * pixels : 0);
    copy_to_host(drawn.color.data(), result.color.values.data(), result.color.values.size(),
                 stream);
    if (outputs.evaluated) result.evaluated = copied(drawn.evaluated.data(), pixels, stream);
    if (!outputs.depth) return;
    const float* const maps = drawn.depth.data();
    const auto map = [&](std::size_t number) { return maps + number * pixels; };
    if (stays) {
      DeviceMaps& depth = result.on_device;
      depth.alpha = map(0);
      depth.expected = map(1);
      depth.median = map(2);
    } else {
      result.depth = {copied(map(0), pixels, stream), copied(map(1), pixels, stream),
                      copied(map(2), pixels, stream)};
    }
  }

  ThreadPool& pool_;
  int device_;
  std::deque<Lane> lanes_;  // never empty
  std::shared_ptr<const GaussianCloud> scene_ = std::make_shared<const GaussianCloud>();
  GaussianSet drawn_;  // of size 0: all
  std::size_t drawn_count_ = 0;
  std::array<std::optional<DeviceCloud>, 2> clouds_;  // by order, on the GPU
  GlTarget gl_target_;
  Selection selection_;
  std::optional<classic::ClassicPipeline>
      classic_;           // so that its buffers can be freed; never empty
  int rest_of_fast_ = 0;  // frames, see fast_draws()
};

}  // namespace
}  // namespace cuda

std::unique_ptr<Renderer> make_cuda_renderer(ThreadPool& pool, int device) {
  cuda::require_gpu(device);
  return std::make_unique<cuda::CudaRenderer>(pool, device);
}

}  // namespace qs
