// SPDX-License-Identifier: MIT
//
// A training whose model all visitors see. It passes the trainer's reports and models to the
// visitors, and their commands to the trainer. Everything runs on the thread of the network but
// open(), which runs before it.
#pragma once

#include <atomic>
#include <memory>

#include "app/serve/served_scene.h"
#include "app/serve/visitor.h"
#include "app/viewer/render/training_thread.h"

namespace qs {

struct PageFacts {
  Backend backend = Backend::cpu;  ///< that draws
  int device = kFirstGpu, threads = 0;
  RenderSettings settings;  ///< of the first pictures
};

class ServedTraining {
 public:
  explicit ServedTraining(TrainingThread& thread) : thread_(thread) {}

  /// Waits for the first model and opens it. Null if the run ends before, or `stops` is true, which
  /// it asks ten times a second. Throws Error.
  std::unique_ptr<ServedScene> open(const PageFacts& page, const std::function<bool()>& stops);

  /// Takes the trainer's reports, and gives its newest model to the renderer if there are visitors
  /// and the budget of drawing allows it. Returns actions for all visitors. Called ten times a
  /// second; `now`: seconds.
  Actions follow(Pictures& pictures, bool has_visitors, double now);

  /// Reports of the renderer's jobs of visitor(): actions for all visitors, or none at the end of a
  /// job.
  void job_reported(const Actions& actions);
  /// The number under which models are shown; 0 before the first.
  int visitor() const { return visitor_; }

  /// Calls `page`, which shows the run until its end. If that fails, the run goes on without a
  /// page: `tell` gets a sentence, and `turn` is called ten times a second until the run has ended.
  void outlive(const std::function<void()>& page,
               const std::function<void(const std::string& sentence)>& tell,
               const std::function<void()>& turn);

  /// Shows the run to a new visitor.
  Action greeting() const;

  void command(TrainingCommand command) { thread_.command(command); }

  /// True when the run has ended and visitors had half a second to hear of it.
  bool has_ended() const;

 private:
  void apply(const Actions& actions);
  void apply_reports();
  bool has_run_ended() const;

  TrainingThread& thread_;
  ViewerStore store_{Viewer()};
  VisitorHost host_;
  std::atomic<int> visitor_ = 0;
  bool uploads_ = false;  // a model is being shown
  double ended_at_ = -1;  // Viewer::now; negative: not yet
  bool has_visitors_ = false;
};

}  // namespace qs
