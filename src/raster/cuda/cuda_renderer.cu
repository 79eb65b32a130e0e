// SPDX-License-Identifier: MIT
#include <cassert>

#include "raster/cuda/classic/classic.cuh"
#include "raster/cuda/cuda_renderer.h"
#include "raster/cuda/fast/pipeline.cuh"
#include "raster/cuda/gl_target.cuh"
#include "raster/cuda/gpu_info.h"
#include "raster/cuda/stream.cuh"

namespace qs {
namespace cuda {
namespace {

class CudaRenderer final : public Renderer {
 public:
  CudaRenderer(ThreadPool& pool, int device)
      : pool_(pool), device_(device), stream_(device, true), gl_target_(device), fast_(device) {}

  ~CudaRenderer() override {
    cudaSetDevice(device_);
    cudaStreamSynchronize(stream_);  // a cancelled frame may still run
  }

  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override {
    select_device();
    cuda::upload(*cloud, pool_, progress, stream_, cloud_);
  }

  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override {
    assert(settings.mode >= 0 && settings.mode <= kModeCount);
    assert(camera.width > 0 && camera.height > 0);
    if (settings.mode == kReferenceMode) {
      throw Error(ErrorKind::device, "cuda: mode reference runs on the backend cpu only");
    }
    if (settings.tile_px != kTileSize) {
      throw Error(ErrorKind::device, "cuda: tiles of " + std::to_string(settings.tile_px) +
                                         " pixels run on the backend cpu only");
    }
    select_device();
    const auto* texture = outputs.color ? std::get_if<GlTexture>(&target) : nullptr;
    const TileGrid grid = TileGrid::of_image(camera.width, camera.height);
    const FrameContext frame{cloud_, camera, settings, grid, stream_, std::move(stop), [&] {
                               if (texture != nullptr) present(camera);
                             }};
    prepare_result(grid);
    if (texture != nullptr) gl_target_.map(*texture);
    try {
      const bool may_be_fast =
          settings.pipeline == Pipeline::fast && settings.dilation >= fast::kLeastDilation;
      if (may_be_fast && fast_.draw(frame, outputs, pixels_, clock_)) {
        collect(fast_, frame, outputs, target);
      } else {
        classic_.draw(frame, outputs, pixels_, clock_);
        collect(classic_, frame, outputs, target);
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
    if (texture == nullptr) {
      gl_target_.unmap();
    } else {
      gl_target_.map(*texture);
    }
  }

 private:
  void select_device() const { check(cudaSetDevice(device_), "cudaSetDevice"); }

  void prepare_result(TileGrid grid) {
    Image color = std::move(result_.color);  // its memory is used again
    result_ = {};
    result_.color = std::move(color);
    result_.color.channels = 3;
    result_.grid = grid;
    result_.stats.gaussians = cloud_.count;
  }

  void present(const Camera& camera) {
    gl_target_.present(pixels_.color.data(), camera.width, camera.height, stream_);
  }

  /// Fills the result from a drawn frame.
  template <class AnyPipeline>
  void collect(AnyPipeline& pipeline, const FrameContext& frame, const Outputs& outputs,
               const Target& target) {
    pipeline.collect(frame, outputs, pixels_, result_);
    if (outputs.used) result_.stats.used_pairs = sum_of(result_.used);
    clock_.read(result_.stats);
    collect_maps(frame.camera, outputs, target);
  }

  /// Waits for the frame and copies the requested maps to the host.
  void collect_maps(const Camera& camera, const Outputs& outputs, const Target& target) {
    check(cudaStreamSynchronize(stream_), "frame");
    const auto pixels =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    const bool wanted = outputs.color && std::holds_alternative<HostImage>(target);
    result_.color.width = wanted ? camera.width : 0;
    result_.color.height = wanted ? camera.height : 0;
    result_.color.values.resize(wanted ? 3 * pixels : 0);
    copy_to_host(pixels_.color.data(), result_.color.values.data(), result_.color.values.size(),
                 stream_);
    if (outputs.evaluated) result_.evaluated = copied(pixels_.evaluated.data(), pixels, stream_);
  }

  ThreadPool& pool_;
  int device_;
  Stream stream_;
  StageClock clock_;
  DeviceCloud cloud_;
  Pixels pixels_;
  GlTarget gl_target_;
  classic::ClassicPipeline classic_;
  fast::FastPipeline fast_;
  Frame result_;
};

}  // namespace
}  // namespace cuda

std::unique_ptr<Renderer> make_cuda_renderer(ThreadPool& pool, int device) {
  const GpuReport report = cuda::gpu_report();
  const auto refuse = [](const std::string& why) {
    throw Error(ErrorKind::device, "backend cuda: " + why);
  };
  if (!report.problem.empty()) refuse(report.problem);
  if (device < 0 || device >= static_cast<int>(report.gpus.size())) {
    refuse("there is no GPU " + std::to_string(device) + ", they count from 0 to " +
           std::to_string(report.gpus.size() - 1));
  }
  const Gpu& gpu = report.gpus[static_cast<std::size_t>(device)];
  if (!gpu.problem.empty()) refuse(gpu.name + ": " + gpu.problem);
  return std::make_unique<cuda::CudaRenderer>(pool, device);
}

}  // namespace qs
