// SPDX-License-Identifier: MIT
//
// An X server without a screen (Xvfb) for tests that open windows; DISPLAY names it while it lives.
#pragma once

#include <string>

#include <sys/types.h>

namespace qs::test {

class VirtualDisplay {
 public:
  /// `size` as Xvfb takes it, "1280x720x24".
  explicit VirtualDisplay(const std::string& size);
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

  /// True if the server runs; false if Xvfb is not installed.
  bool runs() const { return runs_; }

 private:
  pid_t server_ = -1;
  bool runs_ = false;
};

}  // namespace qs::test
