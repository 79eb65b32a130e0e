// SPDX-License-Identifier: MIT
//
// Training in the window, as plain data: the trainer's last report, the budget of time for drawing,
// and the dialog that starts a run. The trainer itself works on a separate thread
// (render/training_thread.h).
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/training_command.h"
#include "raster/api/renderer.h"

namespace qs {

// ---- a photograph beside the model's picture of the same view ---------------------------------
// The trainer gives the views; a thread reads the photographs, and the render thread draws the
// pictures (render/panel_pictures.h).

/// A photograph at the size of training.
struct TestPhotograph {
  Image image;
  std::vector<std::uint8_t> mask;  ///< per pixel, 0: does not count; empty: all count
};

/// The test views of a run; the training views if no view is held out.
struct TestViews {
  std::vector<Camera> cameras;  ///< of the size of training, with names; not empty
  bool held_out = true;         ///< the trainer does not train from them
  RenderSettings settings;      ///< as the trainer draws test views
  /// Reads a photograph on any thread. Throws Error(input).
  std::function<TestPhotograph(std::size_t view)> read;
};

/// The model's picture of a view, compared with the photograph as the trainer's evaluation does.
struct TestComparison {
  std::size_t view = 0;
  int iteration = 0;                     ///< of the model
  std::shared_ptr<const Image> picture;  ///< shown_in_panel()
  double psnr = 0, ssim = 0;             ///< of the size of training
};

/// The view that the panel shows. It stays from the photograph's reading to the next choice.
struct TestView {
  std::size_t view = 0;                              ///< index into TestViews::cameras
  bool asked = false;                                ///< the photograph is being read
  std::shared_ptr<const TestPhotograph> photograph;  ///< null until it is read
  std::shared_ptr<const Image> shown;                ///< shown_in_panel() the photograph
  std::string problem;                               ///< the reason why it cannot be read
  bool compares = false;                             ///< the render thread draws the picture
  double compared_at = -1e9;                         ///< Viewer::now of the last comparison
  TestComparison comparison;                         ///< without a picture: none of this view yet
};

/// The longest side of a picture in the panel, pixels.
inline constexpr int kTestPictureSide = 1024;

/// Seconds from a comparison to the next one of the same view while the model is trained.
inline constexpr double kTestViewSeconds = 2;

// ---- the run ----------------------------------------------------------------------------------

enum class TrainingPhase { running, paused, ended };

/// A run that the user starts in the window.
struct TrainingRequest {
  std::filesystem::path data;        ///< folder of the photographs with their cameras
  std::filesystem::path model;       ///< folder of the trained model
  std::vector<std::string> options;  ///< further options of the command `train`, a word each

  bool operator==(const TrainingRequest&) const = default;
};

/// Mean PSNR of several views after an iteration.
struct PsnrPoint {
  int iteration = 0;
  double psnr = 0;  ///< dB, finite
};

struct TrainingProgress {
  int iteration = 0, iterations = 0;  ///< done, planned
  double loss = 0;                    ///< of the last iterations
  std::uint64_t gaussians = 0;
  double iterations_per_second = 0;                      ///< 0: not known yet
  std::optional<double> test_psnr = {}, test_ssim = {};  ///< of the last evaluation
  int evaluated = 0;                                     ///< iteration of the last evaluation
  std::string overfitting{};  ///< a sentence if the test views got worse, or ""
  std::vector<PsnrPoint> test_psnrs{}, reserved_psnrs{};  ///< of all evaluations; of the guard
  std::string guard{};                                    ///< the guard's verdict so far, or ""
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

// ---- the dialog Train -------------------------------------------------------------------------
/// A choice of TrainForm: its words in the dialog, and the value of the option; null: none is
/// given.
struct TrainChoice {
  const char *words, *value;
};

/// --resolution-scale.
inline constexpr TrainChoice kTrainSizes[] = {{"at most 1600 pixels wide", nullptr},
                                              {"full size", "1"},
                                              {"1/2", "2"},
                                              {"1/4", "4"},
                                              {"1/8", "8"}};

struct TrainForm {
  std::string data, model;             ///< folders; an empty `model`: usual_model()
  int iterations = 0;                  ///< 0: the default of `train`
  std::size_t size = 0, strategy = 0;  ///< indices into kTrainSizes and train::strategies()
  std::string more;                    ///< further options, as on the command line
  bool operator==(const TrainForm&) const = default;
};

/// "garden/" -> "garden_model"
std::string usual_model(const std::string& data);

/// The words of a command line: blanks separate them, except in double quotes. In quotes \\ keeps
/// the next character.
std::vector<std::string> words_of(const std::string& line);

/// Options are given only where a field is not the default of `train`.
TrainingRequest request_of(const TrainForm& form);

}  // namespace qs
