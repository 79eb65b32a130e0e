// SPDX-License-Identifier: MIT
//
// The text of a run for its user: sentences without a line break.
#pragma once

#include <cstdio>
#include <functional>
#include <string>

#include <fmt/format.h>

#include "base/warn.h"

namespace qs::train {

struct RunText {
  using Say = std::function<void(const std::string& sentence)>;

  /// The backend, an evaluation, the saved model.
  Say result = [](const std::string& sentence) {
    fmt::print("{}\n", sentence);
    std::fflush(stdout);
  };
  /// About the model folder.
  Say note = [](const std::string& sentence) { fmt::print(stderr, "{}\n", sentence); };
  Say warning = [](const std::string& sentence) { warn(sentence); };
  bool has_bars = true;  ///< progress bars, if stderr is a terminal
};

}  // namespace qs::train
