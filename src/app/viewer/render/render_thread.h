// SPDX-License-Identifier: MIT
//
// The thread that owns the renderer and the cloud, so that a slow frame never stops the window. It
// does, in this order: jobs (first come, first served), the newest frame that was ordered, and when
// nothing else is to do, the numbers of all modes. An order interrupts numbers, and a frame that is
// outdated.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include "app/measure/measure_view.h"
#include "app/viewer/render/gl_frames.h"
#include "app/viewer/render/render_context.h"

namespace qs {

struct NumbersOrder {
  Camera camera;
  RenderSettings settings;
  int version = 0;
};

class RenderThread {
 public:
  /// `options`: threads and device are used. `wake` is called from the render thread when there is
  /// something to take. `frames` may be null: then every frame passes the host.
  RenderThread(const FrameOptions& options, std::function<void()> wake, GlFrames* frames);
  ~RenderThread();

  void order(FrameOrder order);
  void order(NumbersOrder order);
  void drop_numbers();  ///< they are disturbed: measured anew when they are ordered again
  void run(Job job);
  void stop_job();  ///< the one that runs

  void take_reports(Actions& actions);
  std::optional<FrameReply> take_frame();

  /// False when nothing is ordered, running or waiting to be taken.
  bool busy();

 private:
  void loop(const std::stop_token& stop);
  void draw(const FrameOrder& order);
  void measure(const NumbersOrder& order);
  template <class Work>
  void guarded(Work&& work);
  void report(Action action);
  void expect(int width, int height);
  std::optional<FrameReply> draw_into_gl(const Camera& camera, const FrameOrder& order);

  std::function<void()> wake_;
  GlFrames* frames_;
  bool gl_works_;
  GlTexture next_texture_;  // for the next frame, ready if it has the same size
  int next_width_ = 0, next_height_ = 0;
  RenderContext context_;

  std::mutex mutex_;  // of everything below but the thread
  std::condition_variable_any changed_;
  std::deque<Job> jobs_;
  std::optional<FrameOrder> frame_;
  std::optional<NumbersOrder> numbers_;
  std::optional<FrameReply> reply_;
  Actions reports_;
  std::stop_source running_;  // what runs now
  enum class Task { none, job, frame, refinement, numbers } task_ = Task::none;

  std::jthread thread_;
};

}  // namespace qs
