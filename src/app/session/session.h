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
  RendererOptions renderer;
  Pipeline pipeline = kDefaultPipeline;
  int sh_degree = kMaxShDegree;
  float splat_scale = 1;
  std::optional<glm::vec3> background;  ///< unset: white when the model says so, else black
  std::optional<bool> antialiased;
  int tile_px = kTileSize;
};

/// Modes 1 to 6: the meaning of `--cull all`.
std::vector<CullMode> all_modes();

/// A scene uploaded to a renderer.
struct Session {
  Scene scene;
  Backend backend = Backend::cpu;
  int device = 0;           ///< RendererOptions::device
  RenderSettings settings;  ///< mode: the first of the chosen ones
  std::unique_ptr<Renderer> renderer;
};

/// Name of the pipeline that draws: the CPU backend's only one is called "cpu".
const char* pipeline_name(const Session& session);

/// Reads and uploads, with progress bars; warnings about the file go to stderr. Throws Error.
/// `change` may alter the scene before it is uploaded.
Session open_session(const FrameOptions& frame, const std::function<void(Scene&)>& change = {});

/// A renderer with this cloud uploaded.
std::unique_ptr<Renderer> upload_scene(const GaussianCloud& cloud, Backend backend,
                                       const RendererOptions& options);

/// Reads a scene with a progress bar; warnings go to stderr.
Scene load_scene(const std::filesystem::path& path, ThreadPool& pool, int iteration = -1,
                 const std::string& axes = {});

}  // namespace qs
