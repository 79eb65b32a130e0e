// SPDX-License-Identifier: MIT
//
// Runs the real program as a user does and keeps what it said.
#pragma once

#include <string>
#include <vector>

namespace qs::test {

struct ProgramRun {
  int exit_code = -1;  ///< 128 + signal when it was killed
  std::string out, err;
};

ProgramRun run_quadsplat(const std::vector<std::string>& arguments);

}  // namespace qs::test
