// SPDX-License-Identifier: MIT
//
// The state of background jobs on the render thread, and guards that restore it when a job ends.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "app/session/session.h"
#include "app/viewer/render/action_queue.h"
#include "app/viewer/state/actions.h"
#include "base/progress.h"

namespace qs {

struct FrameRequest {
  Camera camera;    ///< the full-size view's
  int divisor = 1;  ///< rendered at 1 / divisor of its size
  RenderSettings settings;
  bool moving = false;  ///< a newer request does not cancel it
  std::optional<HeatQuantity> heatmap;
  CullMode baseline = find_culler("3dgs");  ///< gives heat maps their scale
  std::uint32_t heat_maximum = 0;           ///< if not 0, the upper end of that scale
  Quantity quantity = Quantity::color;      ///< other quantities only without `heatmap` and `other`
  std::optional<Variant> other = {};        ///< also drawn, for a split window
  bool beside = false;                      ///< `other` draws RenderContext::beside
  bool grid = false;                        ///< all modes side by side; `other` is unset
  HeatStyle heat_style;                     ///< the grid's maps; the window colours other maps
  /// These Gaussians are tinted over the finished picture; null: none.
  std::shared_ptr<const GaussianSet> tint = {};
  /// If set, the frame also counts every mode's pairs for this view at full size.
  std::optional<CountedView> counted = {};
  int version = 0, view_version = 0;  ///< as in Viewer
  int picture = -1;    ///< equal for requests that differ in the mode only; -1: not known
  bool pairs = false;  ///< some frames are followed by a frame of another mode, for its time
};

/// A frame for the window: pixels on the host, or in a GL texture.
struct RenderedFrame {
  ShownFrame shown;
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;        ///< rows from the top; empty if `texture` holds them
  std::vector<std::uint8_t> other = {};  ///< the pixels of shown.other; empty without it
  GlTexture texture = {};                ///< name 0: unused
  std::vector<float> share = {};         ///< Frame::share of FrameRequest::tint, not yet tinted
};

/// The scale of the heat maps of a view.
struct HeldScale {
  HeatQuantity quantity = HeatQuantity::pairs;
  CullMode baseline = 0;
  int view_version = -1;  ///< Viewer::view_version; -1: of a reduced frame
  Scale scale;
};

/// The reference's image of a view or of a part of it.
struct ReferenceImage {
  int view_version = -1;  ///< Viewer::view_version
  PixelBox region;
  Image image;
};

/// The second scene, beside the scene in the window.
struct RenderedBeside {
  std::shared_ptr<const Scene> scene;
  SceneBeside facts;
  Backend backend = Backend::cpu;
  std::unique_ptr<Renderer> renderer;  ///< runs on `backend`
};

struct RenderContext {
  ActionQueue& reports;
  std::function<void(const FrameRequest&)> show;    ///< draws into the window from within a job
  std::function<void(RenderedFrame)> present = {};  ///< shows a frame that a job has drawn
  /// Called between the parts of a long job: others use the renderer, so the last frame is lost.
  std::function<void()> give_way = {};

  /// Makes a renderer without a scene for the session. Tests make another kind.
  std::function<std::unique_ptr<Renderer>(Backend, const Session&)> make_renderer =
      [](Backend backend, const Session& owner) {
        return qs::make_renderer(backend, *owner.pool, owner.device);
      };

  Session session = {};  ///< scene and renderer are initially null
  std::optional<RenderedBeside> beside = {};
  int trained_iteration = 0;                     ///< the last model that training gave
  std::optional<ReferenceImage> reference = {};  ///< the last computed image
  std::optional<HeldScale> heat_scale = {};      ///< the last heat map at rest has it
  std::stop_token stop = {};                     ///< stops the running job
  std::atomic<bool> keeps_part = true;           ///< a stopped job is kept as far as it got
  /// Each writes measured results, which could not be written, below this folder.
  std::vector<std::function<void(const std::filesystem::path& folder)>> unsaved = {};
  std::atomic<bool> measuring = false;
  std::atomic<int> drawings = 0;          ///< drawings of the window that have begun
  std::atomic<bool> window_rests = true;  ///< the window is not drawn now, nor soon

  /// Reports an action to the main thread.
  template <class... Words>
  void report(Words... words) {
    reports.report(std::move(words)...);
  }

  /// Writes the unsaved results below a folder. Throws Error.
  void save_unsaved(const std::filesystem::path& folder) {
    for (; !unsaved.empty(); unsaved.pop_back()) unsaved.back()(folder);
    report(action::results_saved);
  }
};

/// The renderer of a backend with the scene, which is uploaded on the first call.
Renderer& renderer_on(RenderContext& context, Backend backend);

/// Calls a function when it goes out of scope.
template <class Function>
struct AtEnd {
  Function function;
  ~AtEnd() { function(); }
};
template <class Function>
AtEnd(Function) -> AtEnd<Function>;

/// Hides the progress bar at the end of the scope.
inline auto hide_progress_at_end(RenderContext& context) {
  return AtEnd{[&context] { context.report(action::end_progress); }};
}

/// Sets Viewer::measuring in this scope, so that the window draws as little as possible.
inline auto mark_measuring(RenderContext& context) {
  context.measuring = true;
  return AtEnd{[&context] { context.measuring = false; }};
}

/// The progress, and between its steps others use the renderer.
inline Progress giving_way(Progress progress, RenderContext& context) {
  progress.report = [report = std::move(progress.report), &context](float fraction) {
    report(fraction);
    if (context.give_way) context.give_way();
  };
  return progress;
}

/// Gives the session other settings in this scope.
inline auto with_settings(Session& session, const RenderSettings& settings) {
  return AtEnd{
      [&session, kept = std::exchange(session.settings, settings)] { session.settings = kept; }};
}

/// Calls `report` only after another 1 %.
inline Progress stepped_progress(std::function<void(float)> report, std::stop_token stop) {
  constexpr float kStep = 0.01f;
  Progress progress;
  progress.stop = std::move(stop);
  progress.report = [report = std::move(report), reported = 0.0f](float fraction) mutable {
    if (fraction < reported + kStep) return;
    reported = fraction;
    report(fraction);
  };
  return progress;
}

/// Progress that the window shows, in steps of 1 %. `what`: "reading" or "uploading".
inline Progress shown_progress(std::filesystem::path path, std::string what, std::stop_token stop,
                               ActionQueue& reports) {
  return stepped_progress(
      [path = std::move(path), what = std::move(what), &reports](float fraction) {
        reports.report(action::show_progress, Loading{path, what, fraction});
      },
      std::move(stop));
}

// ---- timed frames apart from the drawing of the window -----------------------------------------
// Drawing takes time from the same CPU or GPU. The window is drawn whenever it has to be; the
// frames that a drawing met are void, and the job measures again once the window rests.

/// Waits until the window rests and returns RenderContext::drawings of that moment. Throws
/// Cancelled if the job is stopped.
inline int wait_for_rest(const RenderContext& context) {
  constexpr std::chrono::milliseconds kPause{2};
  for (;;) {
    if (context.stop.stop_requested()) throw Cancelled{};
    if (context.give_way) context.give_way();
    const int drawings = context.drawings;  // before the other: note_drawing() sets it last
    if (context.window_rests) return drawings;
    std::this_thread::sleep_for(kPause);
  }
}

/// Calls measure(progress) while the window rests, and again if the window was drawn meanwhile.
/// Returns the result without a drawing. Throws Cancelled if the job is stopped.
template <class Measure>
auto undisturbed(RenderContext& context, const Measure& measure) {
  for (;;) {
    const int drawings = wait_for_rest(context);
    std::stop_source stop;
    const std::stop_callback stopped(context.stop, [&] { stop.request_stop(); });
    const Progress progress{[&](float) {
                              if (context.drawings != drawings) stop.request_stop();
                            },
                            stop.get_token()};
    try {
      auto result = measure(progress);
      if (context.drawings == drawings) return result;
    } catch (const Cancelled&) {
      if (context.stop.stop_requested()) throw;
    }
  }
}

}  // namespace qs
