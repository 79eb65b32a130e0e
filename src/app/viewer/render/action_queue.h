// SPDX-License-Identifier: MIT
//
// Actions that a thread reports to the main thread.
#pragma once

#include <functional>
#include <mutex>

#include "app/viewer/state/action.h"

namespace qs {

class ActionQueue {
 public:
  /// `wake` is called on the reporting thread after every report.
  explicit ActionQueue(std::function<void()> wake) : wake_(std::move(wake)) {}

  /// Reports call(function, arguments...).
  template <class Function, class... Arguments>
  void report(Function function, Arguments... arguments) {
    {
      const std::lock_guard lock(mutex_);
      actions_.push_back(call(function, std::move(arguments)...));
    }
    wake_();
  }

  /// Appends the actions reported since the last call.
  void take(Actions& actions) {
    const std::lock_guard lock(mutex_);
    for (Action& action : actions_) actions.push_back(std::move(action));
    actions_.clear();
  }

  bool empty() {
    const std::lock_guard lock(mutex_);
    return actions_.empty();
  }

 private:
  std::function<void()> wake_;
  std::mutex mutex_;
  Actions actions_;
};

}  // namespace qs
