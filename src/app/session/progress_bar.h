// SPDX-License-Identifier: MIT
//
// A progress bar on stderr. It appears only if stderr is a terminal and the work takes longer than
// 0.3 s, and is erased by the destructor, so logs never contain one.
#pragma once

#include <chrono>
#include <string>

#include "raster/base/progress.h"

namespace qs {

class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Reports to this bar; must not outlive it.
  Progress progress();

  /// Replaces the label. It is shown with the next report, at most twice a second.
  void relabel(std::string label);

  /// Erases the bar until the next report, so that lines can be printed.
  void hide();

 private:
  void show(float fraction);

  std::string label_;
  std::chrono::steady_clock::time_point start_;
  bool terminal_;
  int shown_percent_ = -1;
  bool new_label_ = false;
  std::chrono::steady_clock::time_point shown_at_{};
};

}  // namespace qs
