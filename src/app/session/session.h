// SPDX-License-Identifier: MIT
//
// A scene that was read and uploaded to a renderer, and the options it was opened with.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "app/session/scene_edits.h"
#include "base/warn.h"
#include "io/scene/reader.h"
#include "raster/api/renderer.h"

namespace qs {

/// The frames that show the colours of a scene's network (Compact-3DGS) instead of spherical
/// harmonics.
enum class NetworkUse {
  never,
  reference,  ///< the frames of reference_image()
  if_any,     ///< all frames of scenes that have a network
  always,     ///< all frames; a scene without a network is an error
};

/// The level of detail of pictures of a tree.
struct LevelOptions {
  std::optional<int> budget;        ///< nodes in a picture
  std::optional<double> error;      ///< LodLimit::gain
  std::optional<double> budget_ms;  ///< moves the budget so that frames of a window take this time
  /// Also without these, trees that would take more than half of the memory are streamed.
  bool streams_large = false;

  bool given() const { return budget || error || budget_ms; }
  StreamedTrees streams() const {
    return given()         ? StreamedTrees::all
           : streams_large ? StreamedTrees::large
                           : StreamedTrees::none;
  }
};

/// The choices that every rendering command offers; cli/shared_options.h declares their options.
struct FrameOptions {
  std::filesystem::path scene;
  int iteration = -1;  ///< iteration of a model folder; -1: the highest
  /// overrides the axes declared by the file, see is_axes(); empty: trust the file
  std::string axes;
  std::optional<std::filesystem::path> cameras;  ///< unset: the cameras file beside the scene
  std::optional<glm::dvec3> up;    ///< unit vector, up in the world; unset: declared or estimated
  std::optional<glm::ivec2> size;  ///< unset: the camera's
  std::vector<CullMode> modes = {default_mode()};
  std::optional<Backend> backend;  ///< unset: the best backend that can render these modes
  int threads = 0;                 ///< threads of the session's pool; 0 = one per hardware thread
  int device = kFirstGpu;          ///< index into GpuReport::gpus, or kFirstGpu
  RenderSettings settings;         ///< but for the mode and the background
  /// unset: white if the model was trained with white, else black
  std::optional<glm::vec3> background;
  EditOptions edits;
  bool skip_huge = false;  ///< leaves out the Gaussians of drop_huge()
  NetworkUse network = NetworkUse::never;
  LevelOptions levels;
};

/// Modes 1 to culler_count(): the meaning of `--cull all`.
std::vector<CullMode> all_modes();
/// The modes of other papers: the meaning of `--cull +peers`.
std::vector<CullMode> peer_modes();

/// A scene and the renderers it was uploaded to, which share the scene and the pool.
struct Session {
  std::shared_ptr<const Scene> scene;
  std::unique_ptr<ThreadPool> pool;  ///< for all work of this session on the CPU
  Backend backend = Backend::cpu;
  int device = 0;                      ///< index into GpuReport::gpus
  RenderSettings settings;             ///< mode: the first of FrameOptions::modes
  std::unique_ptr<Renderer> renderer;  ///< the renderer of `backend`
  std::unique_ptr<Renderer> second;    ///< a renderer of another backend, see renderer_on()
  NetworkUse network = NetworkUse::never;
  LevelOptions levels;
  std::unique_ptr<Renderer> exact;  ///< renders reference_image() with NetworkUse::reference
  std::shared_ptr<const GaussianSet> gone = {};  ///< of the scene, see leave_out(); null: none
  /// Edits of a tree that is not read whole; null: none.
  std::shared_ptr<const std::vector<EditStep>> pages = {};
  EditFacts edits = {};  ///< of the scene and `gone` or `pages`, if one is not null
};

/// All renderers of the session leave these Gaussians of the scene out of later frames; null: none.
/// `steps` of editing took them.
void leave_out(Session& session, const std::shared_ptr<const GaussianSet>& gone, int steps);
/// The same for a renderer to which the scene was just uploaded.
void leave_out(const Session& session, Renderer& renderer);

/// Edits the pages of the session's tree by these steps, in place of earlier ones; null: none.
/// Throws Error(usage) if a step needs the whole scene or the tree has instances.
void edit_pages(Session& session, const std::shared_ptr<const std::vector<EditStep>>& steps);

/// The edits of the Gaussians that frames show.
EditFacts edits_of(const Session& session);
/// The Gaussians that frames show, and their number.
std::size_t drawn_count(const Session& session);
std::shared_ptr<const GaussianCloud> drawn_cloud(const Session& session);

/// The name of a pipeline in reports: "cpu" for the default pipeline of the CPU backend. The
/// pipeline that drew a frame (RenderStats::pipeline) can differ from the requested pipeline.
const char* pipeline_name(Backend backend, Pipeline pipeline);

/// Reads and uploads a scene with progress bars; warnings about the file go to stderr.
/// change(scene) may alter the scene before it is uploaded. Throws Error.
Session open_session(const FrameOptions& frame, const std::function<void(Scene&)>& change = {});

/// The session's renderer of a backend. The first call for another backend than the session's
/// uploads the scene, with a progress bar if no `progress` is given. Throws Error and Cancelled.
Renderer& renderer_on(Session& session, Backend backend,
                      const std::optional<Progress>& progress = {});

/// The fp64 reference image of a view, which the CPU renders. Takes seconds.
Image reference_image(Session& session, const Camera& camera, const Progress& progress = {});

/// The scene's cloud; keeps the scene alive.
std::shared_ptr<const GaussianCloud> cloud_of(const std::shared_ptr<const Scene>& scene);

/// Reads a scene with a progress bar; warnings go to stderr. Parameters as in FrameOptions.
Scene load_scene(const std::filesystem::path& path, ThreadPool& pool, int iteration = -1,
                 const std::string& axes = {}, StreamedTrees streams = StreamedTrees::none);

}  // namespace qs
