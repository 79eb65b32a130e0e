// SPDX-License-Identifier: MIT
//
// A scene that was read and uploaded to a renderer, and the choices it was opened with.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "io/scene/reader.h"
#include "raster/renderer.h"

namespace qs {

/// The choices that every rendering command offers; cli/frame_options.h declares their options.
struct FrameOptions {
  std::filesystem::path scene;
  int iteration = -1;
  std::string axes;  ///< one of kAxes, overrules the file; empty: it is right
  std::optional<std::filesystem::path> cameras;
  std::optional<glm::ivec2> size;
  std::vector<CullMode> modes = {kDefaultMode};
  std::optional<Backend> backend;  ///< unset: the best one that can render these modes
  int threads = 0;                 ///< of the session's pool; 0 = one per hardware thread
  int device = 0;                  ///< index into GpuReport::gpus
  Pipeline pipeline = kDefaultPipeline;
  int sh_degree = kMaxShDegree;
  float splat_scale = 1;
  std::optional<glm::vec3> background;  ///< unset: white when the model says so, else black
  std::optional<bool> antialiased;
  int tile_px = kTileSize;
};

/// Modes 1 to 6: the meaning of `--cull all`.
std::vector<CullMode> all_modes();

/// A scene uploaded to a renderer. The session and its renderers share the scene and the pool.
struct Session {
  std::shared_ptr<const Scene> scene;
  std::unique_ptr<ThreadPool> pool;  ///< for all work of this session on the CPU
  Backend backend = Backend::cpu;
  int device = 0;           ///< index into GpuReport::gpus
  RenderSettings settings;  ///< mode: the first of the chosen ones
  std::unique_ptr<Renderer> renderer;
};

/// Name of the pipeline that draws: the CPU backend's only one is called "cpu".
const char* pipeline_name(const Session& session);

/// Reads and uploads, with progress bars; warnings about the file go to stderr. Throws Error.
/// `change` may alter the scene before it is uploaded.
Session open_session(const FrameOptions& frame, const std::function<void(Scene&)>& change = {});

/// Another renderer with the session's scene uploaded. It uses the session's pool.
std::unique_ptr<Renderer> upload_scene(const Session& session, Backend backend);

/// The scene's cloud; keeps the scene alive.
std::shared_ptr<const GaussianCloud> cloud_of(const std::shared_ptr<const Scene>& scene);

/// Reads a scene with a progress bar; warnings go to stderr.
Scene load_scene(const std::filesystem::path& path, int iteration = -1,
                 const std::string& axes = {});

}  // namespace qs
