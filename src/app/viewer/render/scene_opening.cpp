// SPDX-License-Identifier: MIT
#include "app/viewer/render/scene_opening.h"

#include <chrono>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "app/viewer/render/render_context.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"

namespace qs {

void SceneOpening::open(const OpenRequest& request) {
  end_reading();
  if (uploads_.stop_requested()) uploads_ = {};
  step_ = Step::reading;
  request_ = request;
  const auto report = [this, number = ++number_](ReadingReport what) {
    reports_.report(std::bind_front(&SceneOpening::take_reading, this), number, std::move(what));
  };
  report(Loading{request.path, "reading", 0});
  stop_reading_ = {};
  std::erase_if(readers_, [](const std::future<void>& reader) {
    return reader.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  });
  const auto read = [this, request, report, stop = stop_reading_.get_token()] {
    try {
      read_to_open(request, threads_, sampling_, report, stop);
    } catch (const Cancelled&) {  // end_reading() says so
    } catch (const std::exception& error) {
      report(OpeningFailed{error.what()});
    }
  };
  readers_.push_back(std::async(std::launch::async, read));
}

void SceneOpening::cancel() {
  end_reading();
  uploads_.request_stop();
  step_ = Step::idle;
}

void SceneOpening::end_reading() {
  if (step_ != Step::reading) return;
  stop_reading_.request_stop();
  step_ = Step::idle;
  reports_.report(action::end_progress);
  reports_.report(action::opening_ended, OpeningResult(OpeningCancelled{fmt::format(
                                             "{}: cancelled", request_.path.filename().string())}));
}

void SceneOpening::take_reading(Viewer& viewer, Host& host, int number,
                                const ReadingReport& report) {
  if (number != number_ || step_ != Step::reading) return;
  std::visit([&](const auto& what) { next(viewer, host, what); }, report);
}

void SceneOpening::next(Viewer& viewer, Host&, const Loading& loading) {
  action::show_progress(viewer, loading);
}

void SceneOpening::next(Viewer& viewer, Host& host, const ReadSample& read) {
  if (viewer.scene) return;
  FrameRequest request;
  request.camera = opening_view(viewer, read.facts);
  request.settings = settings_for(read.facts, viewer.settings, request_.keep_background);
  request.settings.mode = viewer.mode();
  host.run([sample = read.sample, request](RenderContext& context) {
    draw_sample(context, *sample, request);
  });
}

void SceneOpening::next(Viewer& viewer, Host& host, const LoadedScene& loaded) {
  if (request_.beside)
    return begin_upload(viewer, host, *loaded.scene,
                        [scene = loaded.scene, backend = viewer.backend](RenderContext& context,
                                                                         const Progress& progress) {
                          return show_beside(context, scene, backend, progress);
                        });
  UploadOrder order{loaded.scene, loaded.facts,
                    settings_for(loaded.facts, viewer.settings, request_.keep_background),
                    viewer.backend};
  if (viewer.scene && viewer.scene->path != loaded.facts.path) order.settings.splat_scale = 1;
  begin_upload(viewer, host, *loaded.scene,
               [order](RenderContext& context, const Progress& progress) {
                 return show_scene(context, order, progress);
               });
}

void SceneOpening::next(Viewer& viewer, Host& host, const OpeningResult& result) {
  step_ = Step::idle;
  action::end_progress(viewer);
  action::opening_ended(viewer, host, result);
}

void SceneOpening::begin_upload(Viewer& viewer, Host& host, const Scene& scene, Upload upload) {
  for (const std::string& warning : scene.warnings) action::notify(viewer, warning);
  step_ = Step::uploading;
  action::show_progress(viewer, Loading{request_.path, "uploading", 0});
  host.run([this, path = scene.path, upload = std::move(upload), number = number_,
            cancelled = uploads_.get_token()](RenderContext& context) {
    const auto report = [&](UploadReport what) {
      context.report(std::bind_front(&SceneOpening::take_upload, this), number, std::move(what));
    };
    const auto show = [&](float fraction) { report(Loading{path, "uploading", fraction}); };
    try {
      if (cancelled.stop_requested()) throw Cancelled{};
      report(upload(context, stepped_progress(show, context.stop)));
    } catch (const Cancelled&) {
      report(OpeningCancelled{});
    } catch (const std::exception& error) {
      report(OpeningFailed{sentence_of(error)});
    }
  });
}

void SceneOpening::take_upload(Viewer& viewer, Host& host, int number, const UploadReport& report) {
  const bool current = number == number_ && step_ == Step::uploading;
  if (const auto* loading = std::get_if<Loading>(&report)) {
    if (current) action::show_progress(viewer, *loading);
    return;
  }
  if (current) {
    step_ = Step::idle;
    action::end_progress(viewer);
  }
  action::opening_ended(viewer, host, std::get<OpeningResult>(report));
}

}  // namespace qs
