// SPDX-License-Identifier: MIT
//
// A progress bar on stderr for work of one label. It appears only when stderr is a terminal and the
// work takes longer than 0.3 s, and is wiped when the object ends, so that no log ever holds one.
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

  /// What to hand to the work; must not outlive the bar.
  Progress progress();

 private:
  void show(float fraction);

  std::string label_;
  std::chrono::steady_clock::time_point start_;
  bool terminal_;
  int shown_percent_ = -1;
};

}  // namespace qs
