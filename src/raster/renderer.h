// SPDX-License-Identifier: MIT
//
// The rasterizer's whole public surface: upload a cloud, submit a frame, wait for it.
//   file -> cloud -> upload -> preprocess -> bin -> sort -> blend -> frame
// Renderer is the only virtual class: one call to submit and one to wait per frame, none per
// Gaussian. A renderer is used by one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

#include "raster/base/progress.h"
#include "raster/kernel/blend.h"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/tile_grid.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/image.h"

namespace qs {

enum class Backend { cpu, cuda };

/// Index = Backend.
inline constexpr const char* kBackendNames[] = {"cpu", "cuda"};

/// How a backend goes about a frame: on CUDA as published with 3DGS, on the CPU in plain C++, or as
/// fast as it can. Same tile lists, same pictures.
enum class Pipeline { classic, fast };

/// Index = Pipeline.
inline constexpr const char* kPipelineNames[] = {"classic", "fast"};
inline constexpr Pipeline kDefaultPipeline = Pipeline::fast;

/// The pipelines that are measured side by side: on the CPU `classic` is there for tests only.
inline std::span<const Pipeline> pipelines_of(Backend backend) {
  static constexpr Pipeline kAll[] = {Pipeline::fast, Pipeline::classic};
  return std::span(kAll).first(backend == Backend::cpu ? 1 : 2);
}

/// The words that name files, functions, timers, HUD rows and benchmark columns.
enum class Stage { preprocess, bin, sort, blend };
inline constexpr int kStageCount = 4;

/// Index = Stage.
inline constexpr const char* kStageNames[kStageCount] = {"preprocess", "bin", "sort", "blend"};

struct RenderSettings {
  CullMode mode = kDefaultMode;  ///< 0 = reference (CPU only), else a row of kCullers
  Pipeline pipeline = kDefaultPipeline;
  int sh_degree = kMaxShDegree;     ///< evaluated degree, capped by the cloud's
  float splat_scale = 1;            ///< factor on every standard deviation, > 0
  glm::vec3 background{0.0f};       ///< what the remaining transmittance shows
  std::optional<bool> antialiased;  ///< opacity compensation; unset = as the cloud was trained
  int tile_px = kTileSize;          ///< side of a tile, one of kTileSizes; only the CPU has others
};

/// Pixels [x0, x1) x [y0, y1).
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// What a frame should hold besides its statistics. Without color, evaluated and used nothing is
/// blended: that is how to count pairs quickly.
struct Outputs {
  bool color = true;
  bool pairs = false;              ///< Frame::pairs
  bool evaluated = false;          ///< Frame::evaluated
  bool used = false;               ///< Frame::used and RenderStats::used_pairs
  bool trace = false;              ///< Frame::trace
  std::optional<PixelBox> region;  ///< mode reference: draws these pixels only, the rest stays 0
  bool stage_times = false;        ///< RenderStats::stage_ms; measuring them may slow the frame

  /// Whether lists are composited at all.
  bool blends() const { return color || evaluated || used; }
};

struct HostImage {};     ///< Frame::color holds it
struct DeviceImage {};   ///< it stays where it was drawn, as when only time is measured
struct GlTexture {       ///< rows from the top, in a texture of the current GL context
  unsigned name = 0;     ///< of a GL_TEXTURE_2D, RGBA8, of the frame's size
  unsigned version = 0;  ///< another one for every storage that any name ever had

  bool operator==(const GlTexture&) const = default;
};

/// Where the colours of a frame go. The CPU backend draws a HostImage only.
using Target = std::variant<HostImage, DeviceImage, GlTexture>;

/// What the rasterizer decided, for tests and the inspector. Mode reference has one list, of all
/// Gaussians that may touch the region, and rounds to single precision.
struct Trace {
  std::vector<std::uint32_t>
      gaussians;                      ///< per visible Gaussian: its index in the cloud, ascending
  std::vector<Footprint> footprints;  ///< parallel to `gaussians`
  std::vector<float> depths;          ///< parallel to `gaussians`
  std::vector<Splat> splats;          ///< parallel to `gaussians`: what blending reads of them
  std::vector<std::uint64_t> tile_begin;  ///< tiles + 1 offsets into `listed`
  std::vector<std::uint32_t> listed;      ///< per tile, front to back: index in the cloud
};

struct RenderStats {
  float frame_ms = 0;    ///< first stage to finished image, on the backend's own clock; without the
                         ///< way of the image to the host
  float present_ms = 0;  ///< after the frame: its way into a GlTexture, 0 for other targets
  float stage_ms[kStageCount] = {};  ///< index = Stage; zeros unless asked for (the CPU: always)
  std::uint32_t gaussians = 0;       ///< in the cloud
  std::uint32_t visible = 0;         ///< Gaussians with at least one tile
  std::uint64_t tile_pairs = 0;      ///< (Gaussian, tile) pairs listed
  std::uint32_t max_pairs_in_a_tile = 0;
  /// Pairs that at least one pixel of their tile blended: alpha >= 1/255 before it stopped. Those
  /// that none did are false positives. Unset unless asked for, and in mode reference.
  std::optional<std::uint64_t> used_pairs;
  int threads = 0;  ///< of the CPU backend, 0 elsewhere
};

struct Frame {
  Image color;  ///< height x width x 3, not clamped; empty unless asked for as a HostImage
  TileGrid grid;
  std::vector<std::uint32_t> pairs;  ///< per tile, row by row: pairs listed
  std::vector<std::uint32_t>
      evaluated;  ///< per pixel: entries of its tile's list up to where it stopped
  std::vector<std::uint32_t> used;  ///< per tile: pairs that a pixel blended; <= pairs
  Trace trace;
  RenderStats stats;
};

/// Total of a map, such as Frame::used.
inline std::uint64_t sum_of(std::span<const std::uint32_t> map) {
  return std::accumulate(map.begin(), map.end(), std::uint64_t{0});
}

class Renderer {
 public:
  virtual ~Renderer() = default;

  /// Replaces the scene. The cloud is not kept. Throws Error (no memory) and Cancelled.
  virtual void upload(const GaussianCloud& cloud, const Progress& progress) = 0;

  /// Begins a frame of the uploaded scene and does not wait for it. One frame at a time. Throws
  /// Error(device) when the backend knows no such mode or target.
  virtual void submit(const Camera& camera, const RenderSettings& settings, const Outputs& outputs,
                      const Target& target, std::stop_token stop) = 0;

  /// Finishes the submitted frame. The result is valid until the next submit. Throws Error, and
  /// Cancelled when the stop token was triggered; the renderer can be used again after both.
  virtual const Frame& wait() = 0;

  /// A hint: the next frame will go there. What that takes happens at once, beside what the GPU
  /// does otherwise; a GlTexture is the renderer's until it is drawn into or something else is
  /// expected. Frames may go elsewhere all the same. Throws Error(device).
  virtual void expect(const Target&) {}

  /// submit() and wait().
  const Frame& render(const Camera& camera, const RenderSettings& settings = {},
                      const Outputs& outputs = {}, const Target& target = HostImage{},
                      std::stop_token stop = {}) {
    submit(camera, settings, outputs, target, std::move(stop));
    return wait();
  }
};

struct RendererOptions {
  int threads = 0;  ///< of the CPU backend, 0 = all
  int device = 0;   ///< of the CUDA backend, index into GpuReport::gpus
};

/// Backends of this build that can run on this machine, best first; the CPU is always among them.
std::span<const Backend> available_backends();

/// Throws Error(device) with the reason when the backend cannot run here.
std::unique_ptr<Renderer> make_renderer(Backend backend, const RendererOptions& options = {});

struct Gpu {
  std::string name;
  std::uint64_t total_bytes = 0, free_bytes = 0;
  int major = 0, minor = 0;  ///< compute capability
  std::string problem;       ///< why this build cannot use it, a clause; empty when it can
};

/// What the CUDA backend finds on this machine.
struct GpuReport {
  std::vector<Gpu> gpus;  ///< in the order of RendererOptions::device
  std::string driver;     ///< newest CUDA version that the driver supports, "13.0"; empty = none
  std::string runtime;    ///< CUDA version of this build; empty = built without CUDA
  std::string problem;    ///< why no GPU can be used, one sentence; empty when one can
};

/// Asks the driver anew at every call. Does not throw.
GpuReport gpu_report();

}  // namespace qs
