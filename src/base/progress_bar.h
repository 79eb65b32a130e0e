// SPDX-License-Identifier: MIT
//
// A progress bar on stderr. It appears only if stderr is a terminal and the work takes longer than
// 0.3 s, and is erased by the destructor, so logs never contain one.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "base/not_copied.h"
#include "base/progress.h"

namespace qs {

/// The text of a bar: "LABEL [####    ]  50 %, 0:07 left". `seconds` have passed since the start.
/// The time left assumes constant speed, and is shown from the first step on.
std::string progress_line(const std::string& label, float fraction, double seconds);

/// Reports 0..1 as begin..end of another progress.
Progress part_of(const Progress& progress, float begin, float end);

/// Reports 0..1 as step `step` of `steps` of another progress.
Progress step_of(const Progress& progress, std::size_t step, std::size_t steps);

class ProgressBar : NotCopied {
 public:
  using Clock = std::chrono::steady_clock;

  explicit ProgressBar(std::string label, std::function<Clock::time_point()> now = usual_clock());
  ~ProgressBar();

  /// The clock of bars that get none. Tests replace it, so that short work shows its bar.
  static std::function<Clock::time_point()>& usual_clock();

  /// Reports to this bar; must not outlive it.
  Progress progress();

  /// Replaces the label. It is shown with the next report, at most twice a second.
  void relabel(std::string label);

  /// False: it never appears.
  void appear(bool appears) { terminal_ = terminal_ && appears; }

  /// Erases the bar until the next report, so that lines can be printed.
  void hide();

 private:
  void show(float fraction);

  std::string label_;
  std::function<Clock::time_point()> now_;
  Clock::time_point start_;
  bool terminal_;
  int shown_percent_ = -1;
  bool shows_time_left_ = false;
  Clock::time_point shown_at_{};
};

}  // namespace qs
