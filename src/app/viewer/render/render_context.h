// SPDX-License-Identifier: MIT
//
// What background jobs work with on the render thread, and guards that restore it however a job
// ends.
#pragma once

#include <atomic>
#include <functional>
#include <stop_token>
#include <utility>

#include "app/session/session.h"
#include "app/viewer/render/action_queue.h"
#include "app/viewer/state/actions.h"

namespace qs {

struct FrameRequest {
  Camera camera;    ///< of the full-size view
  int divisor = 1;  ///< rendered at 1 / divisor of its size
  RenderSettings settings;
  std::optional<HeatQuantity> heatmap;  ///< unset if `other` is set
  std::optional<Variant> other;         ///< also drawn, for a split window
  int version = 0, view_version = 0;    ///< of Viewer
};

/// A frame for the window: pixels on the host, or in a GL texture.
struct RenderedFrame {
  ShownFrame shown;
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;   ///< rows from the top; empty if `texture` holds them
  std::vector<std::uint8_t> other;  ///< the same for shown.other; empty without it
  GlTexture texture;                ///< name 0: unused
};

/// The reference's image of a view or of a part of it.
struct ReferenceImage {
  int view_version = -1;  ///< Viewer::view_version
  PixelBox region;
  Image image;
};

struct RenderContext {
  ActionQueue& reports;
  RendererOptions options;
  std::function<void(const FrameRequest&)> show;  ///< draws into the window from within a job

  Session session = {};                   ///< renderer null until the first scene is open
  std::unique_ptr<Renderer> second = {};  ///< renderer_on() of the other backend, null at first
  std::optional<ReferenceImage> reference = {};  ///< the last one that was computed
  std::stop_token stop = {};                     ///< of the running job
  std::atomic<bool> measuring = false;

  /// Reports an action to the main thread.
  template <class... Words>
  void report(Words... words) {
    reports.report(std::move(words)...);
  }
};

/// The renderer of a backend with the scene, which is uploaded on the first call.
Renderer& renderer_on(RenderContext& context, Backend backend);

/// Hides the progress bar when a job ends.
class ProgressEnd {
 public:
  explicit ProgressEnd(RenderContext& context) : context_(context) {}
  ~ProgressEnd() { context_.report(action::end_progress); }
  ProgressEnd(const ProgressEnd&) = delete;
  ProgressEnd& operator=(const ProgressEnd&) = delete;

 private:
  RenderContext& context_;
};

/// Sets Viewer::measuring while it exists, so that the window draws as little as possible.
class MeasuringMark {
 public:
  explicit MeasuringMark(RenderContext& context) : context_(context) { context.measuring = true; }
  ~MeasuringMark() { context_.measuring = false; }
  MeasuringMark(const MeasuringMark&) = delete;
  MeasuringMark& operator=(const MeasuringMark&) = delete;

 private:
  RenderContext& context_;
};

/// Gives the session other settings while it exists.
class WithSettings {
 public:
  WithSettings(Session& session, const RenderSettings& settings)
      : session_(session), kept_(std::exchange(session.settings, settings)) {}
  ~WithSettings() { session_.settings = kept_; }
  WithSettings(const WithSettings&) = delete;
  WithSettings& operator=(const WithSettings&) = delete;

 private:
  Session& session_;
  RenderSettings kept_;
};

/// Progress that the window shows, in steps of 1 %. `what`: "reading" or "uploading".
inline Progress shown_progress(std::filesystem::path path, std::string what, std::stop_token stop,
                               ActionQueue& reports) {
  constexpr float kStep = 0.01f;
  Progress progress;
  progress.stop = std::move(stop);
  progress.report = [path = std::move(path), what = std::move(what), &reports,
                     reported = 0.0f](float fraction) mutable {
    if (fraction < reported + kStep) return;
    reported = fraction;
    reports.report(action::show_progress, Loading{path, what, fraction});
  };
  return progress;
}

}  // namespace qs
