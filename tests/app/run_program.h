// SPDX-License-Identifier: MIT
//
// Runs the real program as a user does and keeps what it said.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace qs::test {

struct ProgramRun {
  int exit_code = -1;  ///< 128 + signal when it was killed
  std::string out, err;
};

/// `meanwhile` is called with the program's process while it runs.
ProgramRun run_quadsplat(const std::vector<std::string>& arguments,
                         const std::function<void(pid_t)>& meanwhile = {});

}  // namespace qs::test
