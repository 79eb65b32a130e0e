// SPDX-License-Identifier: MIT
//
// The machine and the build with which a report's numbers were measured.
#pragma once

#include <string>

namespace qs {

struct Environment {
  std::string version, commit, build_type, sanitizers, cuda_toolkit;
  std::string cpu;  ///< model name, "unknown" if /proc/cpuinfo lacks it
  int hardware_threads = 0;
  std::string utc;  ///< 2026-11-21T12:34:56Z
};

Environment read_environment();

}  // namespace qs
