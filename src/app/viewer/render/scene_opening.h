// SPDX-License-Identifier: MIT
//
// Opens a file that the user names: a scene, a scene beside it, cameras, or a camera path.
// SceneOpening owns the steps and works on the main thread. read_to_open() works on the reading
// thread, and draw_sample(), show_scene() and show_beside() on the render thread.
//
//     step       receives       sends             to              next step
//     any        open()         OpenRequest       read_to_open()  reading
//     reading    ReadSample     the sample        draw_sample()   reading
//     reading    LoadedScene    UploadOrder       show_scene()    uploading
//                               or the scene      show_beside()
//     reading    OpeningResult  OpeningResult     Viewer          idle
//     uploading  OpeningResult  OpeningResult     Viewer          idle
//     any        cancel()       OpeningCancelled  Viewer          idle
//
// Viewer::loading is the progress. Reports of an opening that was cancelled or replaced are
// dropped: its reader ends alone, because a reader may notice the stop seconds later. Only results
// of uploads always arrive, because the render thread already shows that scene.
#pragma once

#include <functional>
#include <future>
#include <stop_token>
#include <vector>

#include "app/viewer/render/action_queue.h"
#include "app/viewer/render/scene_reading.h"

namespace qs {

class SceneOpening {
 public:
  enum class Step { idle, reading, uploading };

  /// `wake` is called on the reading threads after every report. Scenes are read by `threads`
  /// threads; 0 = one per hardware thread.
  SceneOpening(std::function<void()> wake, int threads, Sampling sampling = {})
      : reports_(std::move(wake)), threads_(threads), sampling_(std::move(sampling)) {}

  /// Waits until all readers have ended.
  ~SceneOpening() { stop_reading_.request_stop(); }

  /// Starts reading, and cancels earlier reading. An upload that began goes on.
  void open(const OpenRequest& request);

  /// Cancels reading and the uploads that have not begun. RenderThread::stop_job() cancels an
  /// upload that runs.
  void cancel();

  /// Actions that carry out the next steps.
  void take_reports(Actions& actions) { reports_.take(actions); }

  Step step() const { return step_; }

  /// True while something is being read or a report waits to be taken.
  bool busy() { return step_ == Step::reading || !reports_.empty(); }

 private:
  using UploadReport = std::variant<Loading, OpeningResult>;
  using Upload = std::function<OpeningResult(RenderContext&, const Progress&)>;

  void end_reading();
  void take_reading(Viewer& viewer, Host& host, int number, const ReadingReport& report);
  void take_upload(Viewer& viewer, Host& host, int number, const UploadReport& report);
  void begin_upload(Viewer& viewer, Host& host, const Scene& scene, Upload upload);

  // The step after each report of reading.
  void next(Viewer& viewer, Host& host, const Loading& loading);
  void next(Viewer& viewer, Host& host, const ReadSample& read);
  void next(Viewer& viewer, Host& host, const LoadedScene& loaded);
  void next(Viewer& viewer, Host& host, const OpeningResult& result);

  ActionQueue reports_;
  int threads_;
  Sampling sampling_;
  Step step_ = Step::idle;
  int number_ = 0;  // numbers the openings
  OpenRequest request_;
  std::stop_source uploads_;                // stops all uploads since the last cancel()
  std::stop_source stop_reading_;           // stops the newest reader
  std::vector<std::future<void>> readers_;  // their destructors wait; the last one is the newest
};

}  // namespace qs
