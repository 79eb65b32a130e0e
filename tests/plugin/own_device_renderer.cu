// SPDX-License-Identifier: MIT
//
// The CUDA backend's pipelines as a plugin that gets its scene and leaves its image in device
// memory.
#include <optional>
#include <utility>
#include <vector>

#include "plugin/own.h"
#include "raster/cuda/classic/classic.cuh"
#include "raster/cuda/fast/pipeline.cuh"

namespace qs::cuda {
namespace {

/// The trained parameters of a scene, copied to the host: the backend orders and packs them there.
GaussianCloud cloud_of(QsScene scene) {
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(scene.sh_degree));
  const std::pair<const float * QsScene::*, std::size_t> arrays[] = {
      {&QsScene::positions, 3},
      {&QsScene::log_scales, 3},
      {&QsScene::rotations, 4},
      {&QsScene::opacity_logits, 1},
      {&QsScene::sh, 3 * coefficients}};
  std::vector<std::vector<float>> copies;
  for (const auto& [array, width] : arrays) {
    copies.push_back(copied(scene.*array, scene.count * width, nullptr));
    scene.*array = copies.back().data();
  }
  return own::cloud_of(scene);
}

class OwnOnDevice {
 public:
  explicit OwnOnDevice(const QsScene& scene)
      : pool_(scene.threads),
        stream_(scene.device, true),
        fast_(scene.device),
        scene_(cloud_of(scene)) {
    cloud_in(settings_.pipeline == Pipeline::fast ? Order::space : Order::file);
  }

  // As CudaRenderer::render().
  void render(const QsView& view, QsFrame& out) {
    own::apply(view, settings_);
    const Camera camera = own::camera_of(view);
    const Outputs outputs = own::outputs_of(out);
    const TileGrid grid = TileGrid::of_image(camera.width, camera.height);
    const auto frame_of = [&](Order order) {
      return FrameContext{cloud_in(order), camera, settings_, grid, stream_, {}, [] {}};
    };
    Frame result;
    bool is_drawn = false;
    if (settings_.pipeline == Pipeline::fast && fast::FastPipeline::can_draw(grid)) {
      const FrameContext frame = frame_of(Order::space);
      fast_.enqueue(frame, outputs, pixels_, clock_);
      is_drawn = fast_.finish(frame, outputs, pixels_, clock_);
      if (is_drawn) fast_.collect(frame, outputs, pixels_, result);
    }
    if (!is_drawn) {
      const FrameContext frame = frame_of(Order::file);
      classic_.draw(frame, outputs, pixels_, clock_);
      classic_.collect(frame, outputs, pixels_, result);
    }
    clock_.read(result.stats);
    const std::size_t values =
        std::size_t{3} * static_cast<unsigned>(view.width) * static_cast<unsigned>(view.height);
    check(cudaMemcpyAsync(out.image, pixels_.color.data(), values * sizeof(float),
                          cudaMemcpyDeviceToDevice, stream_),
          "render");
    check(cudaStreamSynchronize(stream_), "render");
    own::report(result.stats, out);
  }

 private:
  const DeviceCloud& cloud_in(Order order) {
    std::optional<DeviceCloud>& cloud = clouds_[order == Order::space ? 0 : 1];
    if (!cloud) upload(scene_, order, pool_, {}, stream_, cloud.emplace());
    return *cloud;
  }

  RenderSettings settings_ = own::settings();
  ThreadPool pool_;
  Stream stream_;
  StageClock clock_;
  Pixels pixels_;
  classic::ClassicPipeline classic_;
  fast::FastPipeline fast_;
  GaussianCloud scene_;
  std::optional<DeviceCloud> clouds_[2];
};

int32_t open_scene(const QsScene* scene, void** renderer, char* message) {
  return own::guarded(message, [&] { *renderer = new OwnOnDevice(*scene); });
}

int32_t render(void* renderer, const QsView* view, QsFrame* frame, char* message) {
  return own::guarded(message, [&] { static_cast<OwnOnDevice*>(renderer)->render(*view, *frame); });
}

void close_scene(void* renderer) { delete static_cast<OwnOnDevice*>(renderer); }

}  // namespace
}  // namespace qs::cuda

const QsPlugin* qs_plugin() {
  static const QsPlugin plugin = {
      QS_PLUGIN_VERSION,    QS_MEMORY_CUDA,
      QS_IMAGE_HWC,         0,
      "own-cuda-device",    "quadsplat's own CUDA renderer as a plugin, all on the device",
      qs::cuda::open_scene, qs::cuda::render,
      qs::cuda::close_scene};
  return &plugin;
}
