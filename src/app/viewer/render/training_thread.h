// SPDX-License-Identifier: MIT
//
// Runs a trainer beside the window. The trainer of any backend calls after_iteration(), which
// returns the user's command and takes a copy of the model when the window can draw one. The
// trainer keeps its own model, so drawing never waits for an iteration.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "app/viewer/render/action_queue.h"
#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/training_actions.h"

namespace qs {

/// A copy of the model, for the window.
struct TrainedModel {
  std::shared_ptr<const Scene> scene;
  int iteration = 0;
  double seconds = 0;          ///< time of copying
  std::filesystem::path data;  ///< the folder of the training data
};

class TrainingThread {
 public:
  /// A whole training run: calls began() and after_iteration(). Returns one sentence about its end.
  /// Throws Error.
  using Work = std::function<std::string(TrainingThread&)>;

  /// Starts `work`. `wake` is called on its thread when there is something to take.
  TrainingThread(std::function<void()> wake, Work work);
  /// Stops the run and waits until it has saved its model.
  ~TrainingThread();

  // ---- for the trainer, on its thread -----------------------------------------------------------
  /// Shows that photographs of `data` are read. Its reports throw Cancelled when the run is
  /// stopped.
  Progress reading(const std::filesystem::path& data);
  /// Reports the start. `folder`: of the model; `data`: of the training data; `views`: for the
  /// panel, may be null.
  void began(const std::filesystem::path& folder, const std::filesystem::path& data,
             const std::shared_ptr<const TestViews>& views);
  /// Shows a sentence to the user.
  void tell(const std::string& sentence) { reports_.report(action::notify, sentence); }
  /// Called before the first iteration, and then waits until the window takes the model, and after
  /// each iteration. Waits while the run is paused. Returns `go_on`, `save` or `stop`.
  /// `model` copies the model; it is called within this function only.
  TrainingCommand after_iteration(TrainingProgress progress,
                                  const std::function<GaussianCloud()>& model);

  // ---- for the window ---------------------------------------------------------------------------
  void command(TrainingCommand command);
  void want_model();
  std::optional<TrainedModel> take_model();
  void take_reports(Actions& actions) { reports_.take(actions); }
  /// True until began() was called.
  bool reads();
  /// True while a report or a model waits to be taken, or a command was not carried out yet.
  bool busy();

 private:
  using Clock = std::chrono::steady_clock;

  void run(const Work& work);
  void hand_over(const TrainingProgress& progress, const std::function<GaussianCloud()>& model);
  void measure_speed(TrainingProgress& progress, bool was_paused);

  ActionQueue reports_;
  std::function<void()> wake_;

  // Of the trainer's thread.
  std::filesystem::path folder_, data_;
  int handed_over_ = -1;      // iteration
  bool shows_pause_ = false;  // the last report says that the run is paused
  Clock::time_point reported_{}, measured_{};
  int measured_iteration_ = 0;
  double speed_ = 0;

  std::mutex mutex_;  // guards everything below but the thread
  std::condition_variable changed_;
  bool began_ = false, paused_ = false, stopping_ = false, saving_ = false, wanted_ = false,
       ended_ = false,
       obeying_ = false;      // a command was not carried out yet
  bool shown_first_ = false;  // the first model was taken
  int steps_ = 0;             // requested while paused
  std::optional<TrainedModel> model_;

  std::thread thread_;
};

/// Opens the first model as a scene, with the cameras of its folder and the photographs of the
/// data.
Job open_trained(const TrainedModel& model, Backend backend, const RenderSettings& settings);

/// Replaces the scene in the window by the model, if the window still shows the scene of `folder`.
Job show_model(const TrainedModel& model);

}  // namespace qs
