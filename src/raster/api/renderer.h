// SPDX-License-Identifier: MIT
//
// The public interface of the rasterizer: upload a cloud, then render frames of it.
//   file -> cloud -> upload -> preprocess -> bin -> sort -> blend -> frame
// A frame takes one virtual call; a Gaussian takes none. Only one
// thread at a time may use a renderer and the thread pool it was made with.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

#include "base/error.h"
#include "base/parallel.h"
#include "base/progress.h"
#include "raster/kernel/blend.h"
#include "raster/kernel/cull/mode.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/gaussian_set.h"
#include "raster/scene/image.h"

namespace qs {

enum class Backend { cpu, cuda };

/// Index = Backend.
inline constexpr const char* kBackendNames[] = {"cpu", "cuda"};

/// `fast` is the default implementation of a backend; `classic` follows the published 3DGS code on
/// CUDA and is plain C++ on the CPU. Both produce the same tile lists and, within rounding, the
/// same images.
enum class Pipeline { classic, fast };

/// Index = Pipeline.
inline constexpr const char* kPipelineNames[] = {"classic", "fast"};
inline constexpr Pipeline kDefaultPipeline = Pipeline::fast;

/// The pipelines that benchmarks compare. On the CPU `classic` exists for tests only.
inline std::span<const Pipeline> pipelines_of(Backend backend) {
  static constexpr Pipeline kAll[] = {Pipeline::fast, Pipeline::classic};
  return std::span(kAll).first(backend == Backend::cpu ? 1 : 2);
}

/// Files, functions, timers, HUD rows and benchmark columns use these names.
enum class Stage { preprocess, bin, sort, blend };
inline constexpr int kStageCount = 4;

/// Index = Stage.
inline constexpr const char* kStageNames[kStageCount] = {"preprocess", "bin", "sort", "blend"};

/// False for a stage whose work and time are part of other stages, so that its own time is 0:
/// CUDA's `fast` bins while it preprocesses and sorts.
constexpr bool is_timed(Backend backend, Pipeline pipeline, Stage stage) {
  return stage != Stage::bin || backend != Backend::cuda || pipeline != Pipeline::fast;
}

/// The shape that stands for a Gaussian.
enum class DrawStyle {
  splats,     ///< the Gaussian itself
  points,     ///< a dot of kPointRadius at its mean
  ellipsoids  ///< its ellipse of one standard deviation, if its opacity is above kLeastOpacity
};

/// Index = DrawStyle.
inline constexpr const char* kDrawStyleNames[] = {"splats", "points", "ellipsoids"};

/// True if the shape is opaque up to its edge. The Gaussian's opacity does not matter.
constexpr bool is_solid(DrawStyle style) { return style != DrawStyle::splats; }

/// px at the usual dilation and splat scale. A frame of reduced size has less dilation, so its
/// points cover the same part of the window.
inline constexpr double kPointRadius = 1;
/// Of ellipsoids: fog and floaters, which are faint and large, would hide the scene.
inline constexpr double kLeastOpacity = 0.2;

struct LensView;  // raster/lens/lens_view.h

/// Pixels [x0, x1) x [y0, y1).
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// Pixels of a picture, and the least weight with which they show a Gaussian: alpha times the
/// transmittance in front.
struct SeenPixels {
  PixelBox box;                      ///< inside the image
  std::vector<std::uint8_t> chosen;  ///< of the box, row by row: 1 or 0
  float weight = 0;                  ///< 0: all Gaussians that a chosen pixel blends
};

struct RenderSettings {
  CullMode mode = default_mode();  ///< 0 = reference (CPU only), else a row of table.h
  Pipeline pipeline = kDefaultPipeline;
  int sh_degree = kMaxShDegree;     ///< highest evaluated degree; the cloud may have fewer
  float splat_scale = 1;            ///< factor on every standard deviation, > 0
  glm::vec3 background{0.0f};       ///< RGB, weighted by the remaining transmittance
  std::optional<bool> antialiased;  ///< opacity compensation; unset = as the cloud was trained
  double dilation = kDilation;      ///< px^2 added to both variances as a low-pass filter, >= 0
  int tile_px = kTileSize;          ///< side of a tile, one of kTileSizes; only the CPU has others
  DrawStyle style = DrawStyle::splats;
  /// A frame of the image alone may leave out Gaussians of which no pixel shows anything. CUDA's
  /// `fast` does, in views of millions of Gaussians; the image stays the same within rounding. Off
  /// in measurements of modes, which differ most in hidden Gaussians.
  bool occlusion = false;
  /// Null: the camera's own projection. Else the lens through which a frame shows the scene from
  /// the camera's place. The renderers of make_renderer() draw it.
  std::shared_ptr<const LensView> lens = {};
};

/// The numbers by which styles differ in the projection.
struct DrawnShape {
  double splat_scale, dilation;
  double least_opacity;  ///< shapes are drawn above it; of solid shapes
};

inline DrawnShape drawn_shape(const RenderSettings& settings) {
  const auto scale = static_cast<double>(settings.splat_scale);
  const double dilation = settings.dilation, radius = kPointRadius * scale;
  if (settings.style == DrawStyle::points)
    return {0, kSolidVariance * radius * radius * dilation / kDilation, fp64::kAlphaMin};
  if (settings.style == DrawStyle::ellipsoids)
    return {std::sqrt(kSolidVariance) * scale, kSolidVariance * dilation, kLeastOpacity};
  return {scale, dilation, 0};
}

/// The rules that decide which footprint a Gaussian has. RenderSettings::antialiased may be unset,
/// so it is passed.
inline FootprintRules footprint_rules(const RenderSettings& settings, bool antialiased) {
  const DrawnShape shape = drawn_shape(settings);
  const bool solid = is_solid(settings.style);
  return {row_of(settings.mode).keeps_faint,
          antialiased && !solid,
          static_cast<float>(shape.splat_scale),
          static_cast<float>(shape.dilation),
          solid,
          static_cast<float>(std::log2(255 * shape.least_opacity))};
}

/// A view whose pairs Outputs::mode_pairs counts. The mode and the pipeline of the settings do not
/// matter.
struct CountedView {
  Camera camera;
  RenderSettings settings;
};

/// The parts of a frame to compute besides its statistics. Without color, evaluated and used the
/// blend stage is skipped, which makes counting pairs fast. Depth is a pass of its own after that
/// stage; the times of a frame do not include it.
struct Outputs {
  bool color = true;
  bool pairs = false;      ///< Frame::pairs
  bool evaluated = false;  ///< Frame::evaluated
  bool used = false;       ///< Frame::used and RenderStats::used_pairs
  bool depth = false;      ///< Frame::depth
  bool trace = false;      ///< Frame::trace
  /// Frame::mode_pairs: a pass behind the frame that neither lists nor blends. The times of a frame
  /// do not include it.
  bool mode_pairs = false;
  /// The view of mode_pairs; unset: the frame's view. So a frame of reduced size can count the
  /// pairs of the full size.
  std::optional<CountedView> counted = {};
  /// inside the image; mode reference draws only these pixels, the rest is 0
  std::optional<PixelBox> region = {};
  bool stage_times = false;  ///< RenderStats::stage_ms; measuring them may slow the frame
  /// Frame::seen and Frame::share: passes behind the frame over its lists, not in mode reference.
  /// Times of a frame exclude them. If only `seen` is asked for, statistics lack far Gaussians.
  std::shared_ptr<const SeenPixels> seen = {};
  std::shared_ptr<const GaussianSet> share = {};  ///< of the uploaded cloud

  /// True if the frame needs the blend stage.
  bool blends() const { return color || evaluated || used; }
};

struct HostImage {};    ///< in Frame::color
struct DeviceImage {};  ///< in the backend's memory, with the depths: Frame::on_device
struct GlTexture {      ///< in a texture of the current GL context, rows from the top
  unsigned name = 0;    ///< name of a GL_TEXTURE_2D, RGBA8, of the frame's size
  /// Changes whenever the texture's storage is reallocated, even if GL reuses the name.
  unsigned version = 0;

  bool operator==(const GlTexture&) const = default;
};

/// The place to which a frame's colours and depths are written. The CPU backend supports only
/// HostImage.
using Target = std::variant<HostImage, DeviceImage, GlTexture>;

/// The rasterizer's decisions, for tests and the inspector. In mode reference the trace has a
/// single list of all Gaussians that may touch the region, and is rounded to single precision.
struct Trace {
  // Parallel arrays with one entry per visible Gaussian.
  std::vector<std::uint32_t> gaussians;  ///< index in the cloud, ascending
  std::vector<Footprint> footprints;
  std::vector<float> depths;  ///< view z, or the distance from the eye: see Projection
  std::vector<Splat> splats;  ///< the input of the blend stage

  std::vector<std::uint64_t> tile_begin;  ///< tiles + 1 offsets into `listed`
  std::vector<std::uint32_t> listed;      ///< per tile, front to back: index in the cloud
};

struct RenderStats {
  /// GPU or CPU time from the start of the first stage until the image is complete, excluding the
  /// copy to the host.
  float frame_ms = 0;
  float present_ms = 0;  ///< the copy into a GlTexture after the frame; 0 for other targets
  float stage_ms[kStageCount] = {};  ///< index = Stage; CUDA: 0 without Outputs::stage_times
  /// The pipeline that drew the frame: `classic` also draws views that CUDA's `fast` cannot draw.
  Pipeline pipeline = kDefaultPipeline;
  std::uint32_t gaussians = 0;  ///< in the cloud, of the set of Renderer::set_drawn()
  // These three are 0 if the frame left out hidden Gaussians. Then Outputs::mode_pairs sets the
  // first two, if it counts the frame's view.
  std::uint32_t visible = 0;     ///< Gaussians with at least one tile
  std::uint64_t tile_pairs = 0;  ///< (Gaussian, tile) pairs that the mode lists
  std::uint32_t max_pairs_in_a_tile = 0;
  /// Pairs that the frame listed; less than the mode lists if it left out hidden Gaussians.
  std::uint64_t listed = 0;
  bool is_occluded = false;  ///< it left out hidden Gaussians, see RenderSettings::occlusion
  /// Bytes of the keys and values that the frame sorted, each counted once.
  std::uint64_t sort_bytes = 0;
  /// Pairs that at least one pixel of their tile blended: alpha >= 1/255, before the pixel stopped.
  /// All other pairs are false positives. Unset without Outputs::used and in mode reference.
  std::optional<std::uint64_t> used_pairs;
  int threads = 0;     ///< threads of the CPU backend's pool; 0 for other backends
  float cpu_ms = 0;    ///< processor time of these threads in frame_ms; 0 for other backends
  float count_ms = 0;  ///< time of Outputs::mode_pairs on the CPU; 0 for other backends
};

/// The size of a frame in a culling mode; see RenderStats.
struct ModePairs {
  std::uint64_t tile_pairs = 0;
  std::uint32_t visible = 0;

  bool operator==(const ModePairs&) const = default;
};

/// Alpha and depth per pixel, row by row. z is the depth of a Gaussian's centre in view space, in
/// units of the scene, or its distance from the eye (see Projection); its weight is its alpha times
/// the transmittance in front of it.
struct DepthMaps {
  std::vector<float> alpha;     ///< 1 - transmittance behind the last Gaussian, 0..1
  std::vector<float> expected;  ///< mean of z by weight; 0 where alpha is 0
  std::vector<float> median;    ///< z of the first Gaussian with a transmittance <= 1/2 behind it;
                                ///< 0 where there is none
};

/// Maps in the renderer's memory on a GPU, values row by row; null where they were not requested.
struct DeviceMaps {
  const float* color = nullptr;                                          ///< height x width x 3
  const float *alpha = nullptr, *expected = nullptr, *median = nullptr;  ///< see DepthMaps
  /// CUDA's stream in which the renderer will overwrite the maps: work that is enqueued there
  /// before reads them in time.
  void* stream = nullptr;
};

struct Frame {
  Image color;  ///< height x width x 3, not clamped; empty if the target is not a HostImage
  TileGrid grid;
  std::vector<std::uint32_t> pairs;      ///< per tile, row by row: pairs listed
  std::vector<std::uint32_t> evaluated;  ///< per pixel: list entries up to where it stopped
  std::vector<std::uint32_t> used;       ///< per tile: pairs that a pixel blended; <= pairs
  DepthMaps depth;                       ///< empty without Outputs::depth
  DeviceMaps on_device;  ///< color and depth if the target is a DeviceImage of backend cuda
  /// Per mode 1..culler_count(), index = mode - 1: the statistics of that mode's own frame of the
  /// view. The mode of this frame does not matter. Empty without Outputs::mode_pairs.
  std::vector<ModePairs> mode_pairs;
  GaussianSet seen;          ///< the Gaussians of the uploaded cloud that Outputs::seen finds
  std::vector<float> share;  ///< per pixel: the weight of the Gaussians of Outputs::share, 0..1
  Trace trace;
  RenderStats stats;
};

/// Sum over a map such as Frame::used.
inline std::uint64_t sum_of(std::span<const std::uint32_t> map) {
  return std::accumulate(map.begin(), map.end(), std::uint64_t{0});
}

class Renderer {
 public:
  virtual ~Renderer() = default;

  /// Replaces the scene. `cloud` is not null and changes afterwards only as update() says;
  /// `progress` may be empty. The renderer may keep `cloud` until the next upload. The old scene
  /// leaves the GPU before the new scene comes. Throws Error (no memory) and Cancelled; then the
  /// old scene is drawn again.
  virtual void upload(std::shared_ptr<const GaussianCloud> cloud, const Progress& progress) = 0;

  /// The same for a cloud that the caller does not share.
  void upload(GaussianCloud cloud, const Progress& progress) {
    upload(std::make_shared<const GaussianCloud>(std::move(cloud)), progress);
  }

  /// The slow part of an upload, with another pool: another thread may call it while frames are
  /// drawn. The returned function does the rest, for the thread of the frames. It keeps the old
  /// scene, because freeing that takes long too: another thread may destroy the function. It is
  /// empty if the renderer has no memory for both scenes, or cannot do it; then upload() can.
  virtual std::function<void()> prepare_upload(std::shared_ptr<const GaussianCloud>, ThreadPool&) {
    return {};
  }

  /// Later frames draw only the Gaussians of the set, by their indices in the uploaded cloud; a set
  /// of size 0 stands for all, as after upload(). Frames equal frames of a cloud of these Gaussians
  /// in the same order, but a Trace keeps the indices of the uploaded cloud. Throws Error(device)
  /// if the renderer cannot leave out Gaussians.
  virtual void set_drawn(GaussianSet) {
    throw Error(ErrorKind::device, "the renderer cannot leave out Gaussians");
  }

  /// Reads the Gaussians of these indices again, which the caller has changed in the uploaded
  /// cloud. Frames then equal frames of the cloud as it is now. Throws Error(device) if the
  /// renderer cannot do it.
  virtual void update(std::span<const std::uint32_t>) {
    throw Error(ErrorKind::device, "the renderer cannot change single Gaussians");
  }

  /// Renders a frame of the uploaded scene and returns when it is finished. A scene must have been
  /// uploaded; `camera` has a size and focal lengths above 0; `outputs` may request nothing. Other
  /// threads may cancel the frame through `stop`. The result is valid until the next render().
  /// Throws Error when the backend lacks the mode, the target or memory, and Cancelled; the
  /// renderer stays usable after both.
  virtual const Frame& render(const Camera& camera, const RenderSettings& settings = {},
                              const Outputs& outputs = {}, const Target& target = HostImage{},
                              std::stop_token stop = {}) = 0;

  using UseFrame = std::function<void(const Frame& frame, std::size_t number)>;

  /// Calls `use` with the frame of each camera, in their order. A frame is valid until `use`
  /// returns. CUDA draws several frames of a DeviceImage at the same time, so the sum of their
  /// milliseconds exceeds the time that passes. Throws as render(), and what `use` throws.
  virtual void render_each(std::span<const Camera> cameras, const RenderSettings& settings,
                           const Outputs& outputs, const Target& target, std::stop_token stop,
                           const UseFrame& use) {
    for (std::size_t i = 0; i < cameras.size(); ++i)
      use(render(cameras[i], settings, outputs, target, stop), i);
  }

  /// Optional hint: the next frame will be drawn into `target`, so the backend may map it now,
  /// while the GPU is busy with other work. The renderer owns a hinted GlTexture until it is drawn
  /// into or another hint is given; later frames may still use other targets. Throws Error(device).
  virtual void prepare_target(const Target&) {}

  /// Optional hint for pictures that take seconds: from now on render() reports the finished
  /// fraction of a frame, 0..1, from its own thread. Empty: no reports. Only the CPU backend does.
  virtual void report_frames_to(std::function<void(float fraction)>) {}
};

/// Backends of this build that can run on this machine, best first. Always includes the CPU.
std::span<const Backend> available_backends();

inline constexpr int kFirstGpu = -1;  ///< stands for first_gpu()

/// `pool` does the renderer's work on the CPU and must outlive it. `device` is an index into
/// GpuReport::gpus, or kFirstGpu; the CPU backend ignores it. Throws Error(device) with the reason
/// when the backend cannot run on this machine.
std::unique_ptr<Renderer> make_renderer(Backend backend, ThreadPool& pool, int device = kFirstGpu);

struct Gpu {
  std::string name;
  std::uint64_t total_bytes = 0, free_bytes = 0;
  int major = 0, minor = 0;  ///< compute capability
  std::string problem;  ///< a clause, the reason why this build cannot use the GPU; empty = usable
};

/// The GPUs and CUDA versions of this machine.
struct GpuReport {
  std::vector<Gpu> gpus;  ///< in the order of CUDA's device numbers
  std::string driver;     ///< newest CUDA version that the driver supports, "13.0"; empty = none
  std::string runtime;    ///< CUDA version of this build; empty = built without CUDA
  /// a sentence, the reason why no GPU can be used; empty = a GPU can be used
  std::string problem;
};

/// Queries the driver at every call, and every GPU, which opens a context on each: slow, and it
/// takes memory there. Does not throw.
GpuReport gpu_report();

/// gpu_report() without GpuReport::gpus and their problems: opens no context. Does not throw.
GpuReport cuda_versions();

/// Queries one GPU at every call, and no other. If there is no such GPU, its problem says so. Does
/// not throw.
Gpu inspect_gpu(int device);

/// The first GPU that this build can use, an index into GpuReport::gpus; 0 if there is none. It is
/// searched once.
int first_gpu();

}  // namespace qs
