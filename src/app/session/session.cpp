// SPDX-License-Identifier: MIT
#include "app/session/session.h"

#include <algorithm>
#include <cstdio>
#include <numeric>

#include <fmt/format.h>

#include "app/framing/scene_box.h"
#include "app/session/exact_color.h"
#include "app/session/levels.h"
#include "app/session/page_edits.h"
#include "base/fail.h"
#include "base/progress_bar.h"
#include "io/bytes/file_hash.h"
#include "io/camera/cameras.h"
#include "io/scene/compact/compact.h"
#include "raster/pages/page_stream.h"
#include "raster/scene/cloud_order.h"

namespace qs {
namespace {

Backend choose_backend(const FrameOptions& frame) {
  const bool reference = std::ranges::count(frame.modes, kReferenceMode) > 0;
  const bool other_tiles = frame.settings.tile_px != kTileSize;
  if (!frame.backend) return reference || other_tiles ? Backend::cpu : available_backends().front();
  if (other_tiles && *frame.backend != Backend::cpu)
    fail(ErrorKind::usage, "--tile-size {} runs with --backend cpu only", frame.settings.tile_px);
  if (reference && *frame.backend != Backend::cpu)
    fail(ErrorKind::usage, "--cull reference runs with --backend cpu only");
  return *frame.backend;
}

std::unique_ptr<Renderer> upload(const Session& session, Backend backend, bool exact_color,
                                 const std::optional<Progress>& progress) {
  ProgressBar bar("uploading");
  auto renderer = make_renderer(backend, *session.pool, session.device);
  if (exact_color && session.scene->network)
    renderer = with_exact_color(std::move(renderer), *session.scene->network, session.scene->axes,
                                *session.pool);
  if (session.scene->stream)
    renderer = with_levels(std::move(renderer), session.levels, *session.pool);
  expect_stream(*renderer, session.scene->stream);
  renderer->upload(cloud_of(session.scene), progress.value_or(bar.progress()));
  leave_out(session, *renderer);
  return renderer;
}

// Removes the Gaussians that are larger than the scene if `skips`, else only counts them.
void look_for_huge(Scene& scene, bool skips) {
  if (skips) {
    const std::size_t dropped = drop_huge(scene);
    if (dropped > 0) warn(huge_text(dropped) + ": left out");
  } else if (const std::size_t count = count_huge(scene.cloud); count > 0) {
    warn(huge_text(count) + "; --skip-huge draws without");
  }
}

// True if all frames show the network's colours.
bool draws_network(const Session& session) {
  return session.network == NetworkUse::if_any || session.network == NetworkUse::always;
}

Scene read_with_progress(const std::filesystem::path& path, ThreadPool& pool, int iteration,
                         const std::string& axes, StreamedTrees streams) {
  ProgressBar bar("reading");
  ReadOptions options;
  options.iteration = iteration;
  options.axes = axes;
  options.streams = streams;
  options.progress = bar.progress();
  return open_scene(path, pool, options);
}

// The difference of the spherical harmonics does not matter if they are not drawn.
void print_warnings(const Scene& scene, bool exact) {
  for (const std::string& warning : scene.warnings) {
    if (exact && scene.network && warning == fit_sentence(*scene.network)) continue;
    warn("warning: " + warning);
  }
}

std::vector<CullMode> modes_from(CullMode first, CullMode last) {
  std::vector<CullMode> modes(static_cast<std::size_t>(last - first + 1));
  std::iota(modes.begin(), modes.end(), first);
  return modes;
}

}  // namespace

std::vector<CullMode> all_modes() { return modes_from(1, culler_count()); }
std::vector<CullMode> peer_modes() { return modes_from(culler_count() + 1, mode_count()); }

const char* pipeline_name(Backend backend, Pipeline pipeline) {
  if (backend == Backend::cpu && pipeline == kDefaultPipeline)
    return kBackendNames[static_cast<int>(Backend::cpu)];
  return kPipelineNames[static_cast<int>(pipeline)];
}

std::shared_ptr<const GaussianCloud> cloud_of(const std::shared_ptr<const Scene>& scene) {
  return {scene, &scene->cloud};
}

Scene load_scene(const std::filesystem::path& path, ThreadPool& pool, int iteration,
                 const std::string& axes, StreamedTrees streams) {
  Scene scene = read_with_progress(path, pool, iteration, axes, streams);
  print_warnings(scene, false);
  return scene;
}

Session open_session(const FrameOptions& frame, const std::function<void(Scene&)>& change) {
  Session session;
  session.backend = choose_backend(frame);
  session.pool = std::make_unique<ThreadPool>(frame.threads);
  session.device = frame.device;
  if (frame.device == kFirstGpu)  // the CPU backend does not look for a GPU
    session.device = session.backend == Backend::cpu ? 0 : first_gpu();
  session.network = frame.network;
  session.levels = frame.levels;
  Scene scene = read_with_progress(frame.scene, *session.pool, frame.iteration, frame.axes,
                                   frame.levels.streams());
  if (scene.stream && frame.skip_huge)
    fail(ErrorKind::usage, "--skip-huge: {} is a tree that is not read whole: leave it out",
         scene.path.string());
  print_warnings(scene, draws_network(session));
  apply_edits(scene, frame.edits, *session.pool);
  look_for_huge(scene, frame.skip_huge);
  const bool needs_network =
      frame.network == NetworkUse::reference || frame.network == NetworkUse::always;
  if (needs_network && !scene.network)
    fail(ErrorKind::usage,
         "--exact-color: {} has no network of colours; only models of Compact-3DGS have one",
         scene.path.string());
  if (change) change(scene);
  session.scene = std::make_shared<const Scene>(std::move(scene));
  session.renderer = upload(session, session.backend, draws_network(session), {});
  const bool white = !frame.background && model_wants_white_background(session.scene->path);
  session.settings = frame.settings;
  if (frame.settings.occlusion && session.backend == Backend::cpu)
    warn("--occlusion on: the CPU backend lists hidden Gaussians too");
  session.settings.mode = frame.modes.front();
  session.settings.background = frame.background.value_or(glm::vec3(white ? 1.0f : 0.0f));
  return session;
}

void leave_out(const Session& session, Renderer& renderer) {
  if (session.gone) renderer.set_drawn(session.gone->complement());
}

void leave_out(Session& session, const std::shared_ptr<const GaussianSet>& gone, int steps) {
  const GaussianSet drawn = gone ? gone->complement() : GaussianSet();
  for (const auto* renderer : {&session.renderer, &session.second, &session.exact})
    if (*renderer && gone != session.gone) (*renderer)->set_drawn(drawn);
  session.gone = gone;
  if (gone) session.edits = session.scene->edits.with(*gone, steps);
}

void edit_pages(Session& session, const std::shared_ptr<const std::vector<EditStep>>& steps) {
  if (steps == session.pages) return;
  const Scene& tree = *session.scene;
  tree.stream->edit_pages(steps ? page_editor(*steps, "edit", tree) : nullptr, *session.pool);
  session.pages = steps;
  session.edits = {};
  if (!steps) return;
  const auto count = std::ranges::count_if(*steps, takes_away, &EditStep::kind);
  const std::string text = format_edits({{}, *steps}, tree.cloud.origin);
  if (count > 0)
    session.edits = {.steps = static_cast<int>(count),
                     .crc = bytes_hash(std::as_bytes(std::span(text)))};
}

EditFacts edits_of(const Session& session) {
  return session.gone || session.pages ? session.edits : session.scene->edits;
}

std::size_t drawn_count(const Session& session) {
  return session.scene->cloud.size() - (session.gone ? session.gone->count() : 0);
}

std::shared_ptr<const GaussianCloud> drawn_cloud(const Session& session) {
  if (!session.gone) return cloud_of(session.scene);
  return std::make_shared<const GaussianCloud>(
      select(session.scene->cloud, session.gone->complement().numbers()));
}

Renderer& renderer_on(Session& session, Backend backend, const std::optional<Progress>& progress) {
  if (backend == session.backend) return *session.renderer;
  if (!session.second) session.second = upload(session, backend, draws_network(session), progress);
  return *session.second;
}

Image reference_image(Session& session, const Camera& camera, const Progress& progress) {
  RenderSettings settings = session.settings;
  settings.mode = kReferenceMode;
  if (session.network == NetworkUse::reference && !session.exact)
    session.exact = upload(session, Backend::cpu, true, {});
  Renderer& renderer = session.exact ? *session.exact : renderer_on(session, Backend::cpu);
  renderer.report_frames_to(progress.report);
  Image image = renderer.render(camera, settings, {}, HostImage{}, progress.stop).color;
  renderer.report_frames_to({});
  return image;
}

}  // namespace qs
