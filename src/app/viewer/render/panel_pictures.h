// SPDX-License-Identifier: MIT
//
// Pictures that panels show: photographs, which a thread reads; the photograph beside the model's
// picture in the panel Training, drawn and compared on the render thread behind the frames of the
// window; and the candidates for the first view of a scene.
//
// The window never waits for the thread that reads: if another photograph is wanted before the
// thread has begun to read one, that one is not read at all.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "app/viewer/render/action_queue.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/training_actions.h"

namespace qs {

/// Reads photographs on a separate thread, one at a time.
class PhotographReader {
 public:
  /// Reads and reports; runs on the reader's thread.
  using Work = std::function<void(ActionQueue& reports)>;

  /// `wake` is called on the reader's thread after every report.
  explicit PhotographReader(std::function<void()> wake);

  void read(Work work);

  void take_reports(Actions& actions) { reports_.take(actions); }

  /// True while something is being read or a report waits to be taken.
  bool busy() { return reading_ || !reports_.empty(); }

 private:
  void serve(const std::stop_token& stop);

  ActionQueue reports_;
  std::atomic<bool> reading_ = false;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  Work wanted_;  // empty: nothing waits
  std::jthread thread_;
};

/// Reads the photograph of a camera as it is. An error is shown to the user.
PhotographReader::Work read_camera_photograph(const std::filesystem::path& path);

/// The picture with its longest side reduced to kTestPictureSide pixels.
std::shared_ptr<const Image> shown_in_panel(const Image& picture, ThreadPool& pool);

/// Reads the photograph of a view and reports test_photograph_read() or test_view_failed().
PhotographReader::Work read_test_photograph(const std::shared_ptr<const TestViews>& views,
                                            std::size_t view);

/// Draws the model in the window from the camera of the view that the panel shows, and reports
/// test_view_compared(). Reports test_view_given_up() if it was cancelled, or if the render thread
/// has another scene than the whole model. `training` has the view's photograph.
Job compare_test_view(const Training& training);

/// True if the panel will show another photograph or another comparison, without the user.
bool test_view_is_pending(const Viewer& viewer);

/// True if the view in the window will be compared with the photograph over it.
bool photograph_is_pending(const Viewer& viewer);

namespace action {

/// Compares the view at rest with the photograph over it, once, behind the frames of the window.
void follow_photograph(Viewer& viewer, Host& host);

/// Asks for what the panel lacks while it is open: the photograph of its view, then a comparison,
/// at once for another view, and every kTestViewSeconds while the model is trained. Nothing is
/// compared while the camera moves.
void follow_test_view(Viewer& viewer, Host& host);

/// Starts to draw the pictures that Viewer::view_choice waits for, once the window shows the scene.
void follow_view_choice(Viewer& viewer, Host& host);

}  // namespace action
}  // namespace qs
