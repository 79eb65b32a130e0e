// SPDX-License-Identifier: MIT
//
// Writes a film of the path, or of a turntable, to film/SCENE_NNNN.mp4 at the size of the picture;
// without ffmpeg to a folder of PNG files, which cannot be sent.
#include "app/film/film.h"

#include <fmt/format.h>

#include "app/measure/scene_facts.h"
#include "app/viewer/commands/jobs.h"
#include "app/viewer/commands/output_file.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/panel_text.h"
#include "base/fail.h"

namespace qs {
namespace {

constexpr double kMostSentSeconds = 600;

CameraTrack track_of(const RenderContext& context, const Viewer& viewer, glm::ivec2 size) {
  if (viewer.keyframes.size() < 2) {
    const ViewedScene& scene = *viewer.scene;
    const Session& session = context.session;
    return turntable_of(*drawn_cloud(session), scene.cameras, scene.framing,
                        {std::nullopt, Ease::none, size}, *session.pool);
  }
  return along(viewer.keyframes, Ease::none, viewer.loops_path);
}

FilmedBy way_of(Renderer& renderer, RenderSettings settings, const Variant& variant,
                const std::string& name) {
  settings.mode = variant.mode;
  settings.pipeline = variant.pipeline;
  return {&renderer, settings, name};
}

// The variants that the window shows: one, or the two sides of a split.
std::vector<FilmedBy> ways_of(RenderContext& context, const Viewer& viewer) {
  const FrameRequest request = full_frame(viewer);
  const Variant shown = viewer.variant();
  Renderer& renderer = *context.session.renderer;
  // A frame of the reference takes seconds.
  if (!request.other || request.other->mode == kReferenceMode)
    return {way_of(renderer, request.settings, shown, mode_name(shown.mode))};
  if (request.beside && context.beside) {
    const std::string other = scene_name(context.beside->facts.path);
    return {way_of(renderer, request.settings, shown, viewer.scene->name),
            way_of(renderer_beside(context), request.settings, shown, other)};
  }
  const Variant& other = *request.other;
  return {way_of(renderer, request.settings, shown, name_beside(shown, other)),
          way_of(renderer_on(context, other.backend), request.settings, other,
                 name_beside(other, shown))};
}

void film_view(RenderContext& context, const Viewer& viewer) {
  const bool encodes = ffmpeg_is_installed();
  if (viewer.is_remote && !encodes)
    fail(ErrorKind::device, "a film needs ffmpeg, which is not installed on the server");
  // The place is tried before anything is drawn.
  const OutputFile output(viewer, "film", scene_name(context.session.scene->path),
                          encodes ? ".mp4" : "");
  const std::filesystem::path& path = output.path();
  FilmPlan plan;
  // Videos need an even width and height.
  plan.size = {std::max(viewer.camera.width / 2 * 2, 2), std::max(viewer.camera.height / 2 * 2, 2)};
  plan.track = track_of(context, viewer, plan.size);
  plan.seconds = plan.track.seconds;
  if (viewer.is_remote && plan.seconds > kMostSentSeconds)
    fail(ErrorKind::usage, "a film of {:.0f} s is too long to send: at most {:.0f} s", plan.seconds,
         kMostSentSeconds);
  plan.ways = ways_of(context, viewer);
  plan.altered = alterations_of(viewer).text;
  plan.altered_brief = alterations_of(viewer).brief;
  plan.numbers = plan.ways.size() > 1 || viewer.shows_badge;
  if (viewer.heatmap)
    plan.heatmap =
        FilmHeatmap{*viewer.heatmap, {}, viewer.heat_view.style, context.session.pool.get()};

  std::string part;
  if (!viewer.is_remote)
    plan.keeps_part = [&](const std::string& problem) {
      part = problem.empty() ? "; it ends where it was stopped"
                             : ", only as far as it got: " + problem;
      return !problem.empty() || context.keeps_part;
    };
  const auto end = hide_progress_at_end(context);
  context.report(action::show_progress, Loading{path, kFilming, 0});
  try {
    const Progress progress =
        giving_way(shown_progress(path, kFilming, context.stop, context.reports), context);
    if (plan.heatmap)
      plan.heatmap->scale = viewer.heat_view.maximum > 0
                                ? exact_scale(viewer.heat_view.maximum)
                                : film_heat_scale(plan, viewer.baseline, progress);
    write_film(path, plan, progress);
  } catch (const Cancelled&) {
    context.report(action::notify, "the film was stopped, nothing was saved");
    throw;
  }
  output.done(context, part + (encodes ? "" : ": PNG files, because ffmpeg is not installed"));
}

}  // namespace

void action::film(Viewer& viewer, Host& host) {
  if (!viewer.scene) return;
  viewer.playback.running = false;
  start_long_job(viewer, host, film_view);
}

}  // namespace qs
