// SPDX-License-Identifier: MIT
//
// Where and by which build a number was measured; goes into every report.
#pragma once

#include <string>

namespace qs {

struct Environment {
  std::string version, commit, build_type, sanitizers, cuda_toolkit;
  std::string cpu;  ///< model name, "unknown" when the system does not tell
  int hardware_threads = 0;
  std::string utc;  ///< 2026-11-21T12:34:56Z
};

Environment read_environment();

}  // namespace qs
