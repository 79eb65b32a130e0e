// SPDX-License-Identifier: MIT
//
// A plugin (quadsplat/plugin.h) as a renderer that benchmarks measure beside the program's own. It
// runs in a separate process, so a plugin that crashes, hangs or returns wrong values is an Error
// like any other.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "app/plugin/protocol.h"
#include "app/plugin/scene_arrays.h"
#include "raster/api/renderer.h"

namespace qs {

struct PluginOptions {
  std::filesystem::path library;
  int device = 0;      ///< index into GpuReport::gpus
  int timeout_s = 60;  ///< limit of every call
};

class PluginProcess;

class PluginRenderer final : public Renderer {
 public:
  /// `pool` must outlive the renderer. The plugin may use as many threads as it has.
  PluginRenderer(PluginOptions options, ThreadPool& pool);
  ~PluginRenderer() override;

  /// Starts the process, loads the library and opens the scene. Throws Error(device): "plugin LIB:
  /// what happened", or Error(input) if the library is not a plugin.
  void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) override;
  using Renderer::upload;

  /// HostImage copies the image, checks that every value is finite and takes a little longer;
  /// DeviceImage leaves it in the plugin's memory. Plugins ignore `settings.mode`, `pipeline` and
  /// `tile_px`; `style` must be splats. Of the outputs only color and stage_times are supported.
  /// After an Error the next frame starts the process again, unless usable() is false.
  const Frame& render(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) override;

  /// Calls the plugin's close() and ends the process. Throws Error(device).
  void close();

  /// False after an Error of upload() and after a plugin did not answer in time.
  bool usable() const { return usable_; }

  const std::string& name() const { return name_; }  ///< the library's until upload()
  const std::string& description() const { return description_; }
  /// the plugin reported the time of the last frame
  bool measures_itself() const { return measures_itself_; }
  bool on_device() const { return memory_ == QS_MEMORY_CUDA; }

  std::size_t frames() const { return frames_; }  ///< rendered without an Error

  /// Time of all calls of render() by the host's clock, divided by the frame times. 1 if the plugin
  /// does not measure itself.
  double call_factor() const { return frames_ms_ > 0 ? calls_ms_ / frames_ms_ : 1; }

 private:
  PluginReply ask(const PluginRequest& request, const std::stop_token& stop);
  void open(const std::stop_token& stop);
  void take_image(const Camera& camera);
  void take_stats(const PluginReply& reply);
  [[noreturn]] void refuse(const std::string& what) const;

  PluginOptions options_;
  ThreadPool& pool_;
  SharedMemory scene_, image_;
  QsScene header_ = {};
  bool antialiased_ = false;                // how the cloud was trained
  std::unique_ptr<PluginProcess> process_;  // null: not started, or it ended
  std::string name_, description_;
  std::uint32_t memory_ = QS_MEMORY_HOST, image_layout_ = QS_IMAGE_HWC;
  bool usable_ = true, measures_itself_ = false;
  std::size_t frames_ = 0;
  double frames_ms_ = 0, calls_ms_ = 0;
  Frame result_;
};

}  // namespace qs
