// SPDX-License-Identifier: MIT
//
// What the render thread works with, and guards that leave it as it was however the work ends.
#pragma once

#include <functional>
#include <stop_token>
#include <utility>

#include "app/session/session.h"
#include "app/viewer/state/actions.h"

namespace qs {

struct FrameOrder {
  Camera camera;    ///< of the full-size view
  int divisor = 1;  ///< rendered at 1 / divisor of its size
  RenderSettings settings;
  std::optional<HeatQuantity> heatmap;
  std::optional<Variant> other;       ///< drawn too, to be set beside it; then without a heat map
  int version = 0, view_version = 0;  ///< of Viewer
};

/// A frame on its way to the window: pixels on the host, or in a GL texture.
struct FrameReply {
  ShownFrame shown;
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;   ///< rows from the top; empty when in a texture
  std::vector<std::uint8_t> other;  ///< the same of shown.other; empty without
  GlTexture texture;                ///< name 0: not used
};

/// The reference's image of a view or of a part of it.
struct ReferenceImage {
  int view_version = -1;  ///< Viewer::view_version
  PixelBox region;
  Image image;
};

struct RenderContext {
  Session session;                          ///< renderer null until the first scene
  std::optional<ReferenceImage> reference;  ///< the last that was computed
  RendererOptions options;
  std::stop_token stop;
  std::function<void(Action)> report;
  std::function<void(const FrameOrder&)> show;  ///< draws into the window from within a job
};
using Job = std::function<void(RenderContext&)>;

/// The renderer of a backend with the scene; uploads it when that is the first time.
Renderer& renderer_on(RenderContext& context, Backend backend);

/// Reports `end` when the work is over.
class ReportAtEnd {
 public:
  ReportAtEnd(RenderContext& context, Action end) : context_(context), end_(std::move(end)) {}
  ~ReportAtEnd() { context_.report(std::move(end_)); }
  ReportAtEnd(const ReportAtEnd&) = delete;
  ReportAtEnd& operator=(const ReportAtEnd&) = delete;

 private:
  RenderContext& context_;
  Action end_;
};

/// The session has a view's settings as long as this lives.
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

/// Progress that shows in the window, a hundred steps at most. `what` is "reading" or "uploading".
inline Progress loading_progress(std::filesystem::path path, std::string what, std::stop_token stop,
                                 std::function<void(Action)> report) {
  constexpr float kStep = 0.01f;
  Progress progress;
  progress.stop = std::move(stop);
  progress.report = [path = std::move(path), what = std::move(what), report = std::move(report),
                     reported = 0.0f](float fraction) mutable {
    if (fraction < reported + kStep) return;
    reported = fraction;
    report(action::SetLoading{Loading{path, what, fraction}});
  };
  return progress;
}

}  // namespace qs
