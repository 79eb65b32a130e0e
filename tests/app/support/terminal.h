// SPDX-License-Identifier: MIT
//
// A terminal for tests of progress bars.
#pragma once

#include <string>

namespace qs::test {

/// Standard error is a terminal while the object lives.
class Terminal {
 public:
  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  /// The text that appeared since the last call, at most 4096 bytes; empty if there was none.
  std::string shown() const;

 private:
  int kept_, keyboard_ = -1;
};

}  // namespace qs::test
