// SPDX-License-Identifier: MIT
//
// Training in the window, as plain data: the trainer's last report, and the budget of time for
// drawing. The trainer itself works on a separate thread (render/training_thread.h).
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/viewer/state/test_view.h"
#include "base/training_command.h"

namespace qs {

enum class TrainingPhase { running, paused, ended };

/// A run that the user starts in the window.
struct TrainingRequest {
  std::filesystem::path data;        ///< folder of the photographs with their cameras
  std::filesystem::path model;       ///< folder of the trained model
  std::vector<std::string> options;  ///< further options of the command `train`, a word each

  bool operator==(const TrainingRequest&) const = default;
};

struct TrainingProgress {
  int iteration = 0, iterations = 0;  ///< done, planned
  double loss = 0;                    ///< of the last iterations
  std::uint64_t gaussians = 0;
  double iterations_per_second = 0;            ///< 0: not known yet
  std::optional<double> test_psnr, test_ssim;  ///< of the last evaluation
  int evaluated = 0;                           ///< iteration of the last evaluation
  std::string overfitting{};                   ///< a sentence if the test views got worse, or ""
};

/// Keeps drawing within a share of the time. Every piece of work, a frame or an upload, is followed
/// by a pause, so that all work since the start takes at most the share, apart from the last piece.
class DrawingBudget {
 public:
  /// The largest share of the time: while the camera moves, and while it rests.
  static constexpr double kMoving = 0.5, kResting = 0.2;
  static constexpr double kWindow = 4;  ///< seconds over which share() is measured

  /// Records that work of `seconds` ended at `now`, with `most` as the largest share.
  void spent(double now, double seconds, double most);
  bool allows(double now) const { return now >= free_at_; }

  /// The share of the last kWindow seconds, 0 to 1.
  double share(double now) const;

 private:
  struct Piece {
    double end, seconds;
  };
  double free_at_ = -1e9;
  std::deque<Piece> pieces_;
};

/// The loss that a report gave.
struct LossPoint {
  int iteration = 0;
  float loss = 0;
};

struct Training {
  /// When there are more losses, every second one is dropped, so the rest are of the whole run.
  static constexpr std::size_t kMostLosses = 600;

  std::filesystem::path folder;  ///< of the model; the path of its scene
  TrainingPhase phase = TrainingPhase::running;
  TrainingProgress progress;
  std::vector<LossPoint> losses;           ///< by iteration
  int shown = 0;                           ///< iteration of the model in the window
  std::string outcome;                     ///< one sentence after the end
  std::shared_ptr<const TestViews> views;  ///< null until the photographs are read
  TestView test_view;
  DrawingBudget budget;
};

}  // namespace qs
