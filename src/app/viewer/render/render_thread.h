// SPDX-License-Identifier: MIT
//
// The thread that owns the renderer and the scene, so that a slow frame never blocks the window.
// Jobs come first, in the order of their requests; then the newest requested frame; then the job
// behind the frames; then the numbers of all modes. A new request cancels a measurement, the job
// behind the frames, and a frame that became outdated unless the camera moves.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "app/viewer/render/all_modes.h"
#include "app/viewer/render/gl_frames.h"
#include "app/viewer/render/render_context.h"

namespace qs {

/// The last two finished pictures that differ in their mode only, so that the window shows the
/// other mode at once when the user switches back and forth. Pictures in GL textures are not kept:
/// the GPU draws them in less time than the window needs.
class KeptFrames {
 public:
  /// Takes a copy of a finished full-size frame. Frames of another picture are dropped.
  void keep(const FrameRequest& request, const RenderedFrame& frame);

  /// The kept frame of this request if its mode is not the mode of the last frame; the same mode is
  /// requested twice only to draw it again. Empty if the request asks for counts that the frame
  /// lacks.
  std::optional<RenderedFrame> find(const FrameRequest& request) const;

 private:
  struct Kept {
    int picture = -1;
    RenderedFrame frame;
  };
  std::deque<Kept> frames_;  // the last drawn frame is the last
};

class RenderThread {
 public:
  /// Uses the threads and the device of `options`. `wake` is called on the render thread when there
  /// is something to take. Without `frames` all frames go through host memory.
  RenderThread(const FrameOptions& options, std::function<void()> wake, GlFrames* frames);
  ~RenderThread();

  void request(FrameRequest request);
  void request(NumbersRequest request);
  void cancel_numbers();
  void run(Job job);
  void stop_job(bool keeps_part = false);  ///< the running job
  /// Runs a job when no frame is wanted. A new frame or job cancels it while it runs. A job that
  /// still waits is replaced.
  void run_behind(Job job);

  void take_reports(Actions& actions) { reports_.take(actions); }
  std::optional<RenderedFrame> take_frame();

  /// False if nothing is requested, running or waiting to be taken.
  bool busy();
  bool measuring() const { return context_.measuring; }

  /// Report the drawing of the window to jobs, see undisturbed().
  void note_drawing() {
    context_.window_rests = false;
    ++context_.drawings;
  }
  void note_rest(bool rests) { context_.window_rests = rests; }

 private:
  void loop(const std::stop_token& stop);
  bool gives_way() const {  // to a frame or a job
    return task_ == Task::numbers || task_ == Task::behind || task_ == Task::refinement;
  }
  void answer(const FrameRequest& request);
  void draw_between();
  RenderedFrame drawn(FrameRequest request);
  void show(RenderedFrame frame);
  void publish(RenderedFrame frame);
  std::function<void()> next_work();
  void guarded(const std::function<void()>& work);
  std::optional<RenderedFrame> draw_into_gl(const Camera& camera, const FrameRequest& request);

  std::function<void()> wake_;
  GlFrames* frames_;
  InteropRetry interop_;
  PreparedTexture<GlFrames> next_texture_;
  KeptFrames kept_;
  PairedFrames paired_;
  ActionQueue reports_;
  RenderContext context_;

  std::mutex mutex_;  // guards everything below but the thread
  std::condition_variable_any changed_;
  std::deque<Job> jobs_;
  Job behind_;  // empty: none
  std::optional<FrameRequest> frame_;
  std::optional<NumbersRequest> numbers_;
  std::optional<RenderedFrame> rendered_;
  std::stop_source running_;  // stops the current task
  enum class Task { none, job, frame, refinement, behind, numbers } task_ = Task::none;
  std::atomic<bool> awaits_cuts_ = false;  // of levels of detail: in jobs

  std::jthread thread_;
};

}  // namespace qs
