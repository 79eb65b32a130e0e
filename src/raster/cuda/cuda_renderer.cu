// SPDX-License-Identifier: MIT
#include <cassert>

#include "raster/cuda/blend.cuh"
#include "raster/cuda/cuda_renderer.h"
#include "raster/cuda/gl_target.cuh"
#include "raster/cuda/gpu_info.h"
#include "raster/cuda/stage_clock.cuh"

namespace qs {
namespace cuda {
namespace {

/// Asks for the GPU before anything is allocated on it.
class Stream {
 public:
  explicit Stream(int device) {
    check(cudaSetDevice(device), "cudaSetDevice");
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() { cudaStreamDestroy(stream_); }

  operator cudaStream_t() const { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

class CudaRenderer final : public Renderer {
 public:
  explicit CudaRenderer(int device) : device_(device), stream_(device) {}

  ~CudaRenderer() override {
    cudaSetDevice(device_);
    cudaStreamSynchronize(stream_);  // a cancelled frame may still run
  }

  void upload(const GaussianCloud& cloud, const Progress& progress) override {
    select_device();
    cuda::upload(cloud, progress, stream_, cloud_);
  }

  void submit(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
              const Target& target, std::stop_token stop) override {
    assert(settings.mode >= 0 && settings.mode <= kCullerCount);
    assert(camera.width > 0 && camera.height > 0);
    if (settings.mode == kReferenceMode) {
      throw Error(ErrorKind::device, "cuda: mode reference runs on the backend cpu only");
    }
    if (settings.pipeline == Pipeline::fast) {
      throw Error(ErrorKind::device, "cuda: pipeline fast is not built yet");
    }
    camera_ = camera;
    settings_ = settings;
    outputs_ = outputs;
    target_ = target;
    stop_ = std::move(stop);
  }

  // All work happens here: the host waits for the number of pairs in the middle of a frame, and
  // whoever owns the renderer gives it a thread by waiting.
  const Frame& wait() override {
    select_device();
    const FrameContext frame{cloud_,    camera_,
                             settings_, TileGrid::of_image(camera_.width, camera_.height),
                             stream_,   stop_};
    prepare_result(frame.grid);
    clock_.begin(outputs_.stage_times, stream_);
    timed(frame, Stage::preprocess, [&] { preprocess(frame, visible_); });
    timed(frame, Stage::bin, [&] { bin(frame, visible_, pairs_); });
    timed(frame, Stage::sort, [&] { sort(frame, pairs_, lists_); });
    timed(frame, Stage::blend, [&] { blend(frame, visible_, pairs_, lists_, outputs_, pixels_); });
    const auto* buffer = std::get_if<GlBuffer>(&target_);
    if (buffer != nullptr && outputs_.color) {
      gl_target_.present(pixels_.color.data(), camera_.width, camera_.height, *buffer, stream_);
    }
    collect_stats();
    if (buffer != nullptr && outputs_.color) result_.stats.present_ms = gl_target_.present_ms();
    collect_maps();
    if (outputs_.trace) collect_trace();
    return result_;
  }

 private:
  void select_device() const { check(cudaSetDevice(device_), "cudaSetDevice"); }

  template <class Work>
  void timed(const FrameContext& frame, Stage stage, const Work& work) {
    frame.throw_if_cancelled();
    work();
    clock_.end(stage, stream_);
  }

  void prepare_result(TileGrid grid) {
    Image color = std::move(result_.color);  // its memory is used again
    result_ = {};
    result_.color = std::move(color);
    result_.color.channels = 3;
    result_.grid = grid;
  }

  /// The first `count` elements of a buffer, on the host.
  template <class T>
  std::vector<T> copied(const DeviceBuffer<T>& buffer, std::size_t count) const {
    std::vector<T> host(count);
    copy(buffer, host);
    return host;
  }

  template <class T>
  void copy(const DeviceBuffer<T>& from, std::vector<T>& to) const {
    if (to.empty()) return;
    check(cudaMemcpyAsync(to.data(), from.data(), to.size() * sizeof(T), cudaMemcpyDeviceToHost,
                          stream_),
          "copy to the host");
    check(cudaStreamSynchronize(stream_), "copy to the host");
  }

  void collect_stats() {
    check(cudaMemcpyAsync(&*counters_, visible_.counters.data(), sizeof(Counters),
                          cudaMemcpyDeviceToHost, stream_),
          "copy to the host");
    clock_.read(result_.stats);
    check(cudaStreamSynchronize(stream_), "frame");
    result_.stats.gaussians = cloud_.count;
    result_.stats.visible = counters_->visible;
    result_.stats.tile_pairs = pairs_.count;
    result_.stats.max_pairs_in_a_tile = counters_->max_pairs_in_a_tile;
  }

  void collect_maps() {
    const auto pixels =
        static_cast<std::size_t>(camera_.width) * static_cast<std::size_t>(camera_.height);
    const bool wanted = outputs_.color && std::holds_alternative<HostImage>(target_);
    result_.color.width = wanted ? camera_.width : 0;
    result_.color.height = wanted ? camera_.height : 0;
    result_.color.values.resize(wanted ? 3 * pixels : 0);
    copy(pixels_.color, result_.color.values);
    if (outputs_.evaluated) result_.evaluated = copied(pixels_.evaluated, pixels);
    if (outputs_.pairs) result_.pairs = list_lengths();
  }

  void collect_trace() {
    Trace& trace = result_.trace;
    const std::size_t size = cloud_.count;
    const auto tiles = copied(visible_.tile_counts, size);
    const auto depths = copied(visible_.depths, size);
    auto means = copied(visible_.means, size), conics = copied(visible_.conics, size);
    auto levels = copied(visible_.levels, size);
    const FootprintPlanes footprints{means.data(), conics.data(), levels.data()};
    for (std::size_t i = 0; i < size; ++i) {
      if (tiles[i] == 0) continue;
      trace.gaussians.push_back(static_cast<std::uint32_t>(i));
      trace.footprints.push_back(footprints.load(i));
      trace.depths.push_back(depths[i]);
    }
    trace.tile_begin.push_back(0);
    for (const std::uint32_t length : list_lengths()) {
      trace.tile_begin.push_back(trace.tile_begin.back() + length);
    }
    trace.listed = copied(pairs_.buffers.values, pairs_.count);
  }

  std::vector<std::uint32_t> list_lengths() const {
    std::vector<std::uint32_t> lengths;
    for (const uint2 range :
         copied(lists_.ranges, static_cast<std::size_t>(result_.grid.count()))) {
      lengths.push_back(range.y - range.x);
    }
    return lengths;
  }

  int device_;
  Stream stream_;
  StageClock clock_;
  PinnedValue<Counters> counters_;
  DeviceCloud cloud_;
  Camera camera_;
  RenderSettings settings_;
  Outputs outputs_;
  Target target_;
  std::stop_token stop_;
  Visible visible_;
  TilePairs pairs_;
  TileLists lists_;
  Pixels pixels_;
  GlTarget gl_target_;
  Frame result_;
};

}  // namespace
}  // namespace cuda

std::unique_ptr<Renderer> make_cuda_renderer(int device) {
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
  return std::make_unique<cuda::CudaRenderer>(device);
}

}  // namespace qs
