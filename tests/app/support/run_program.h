// SPDX-License-Identifier: MIT
//
// Runs the real program as a user does and keeps its output.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace qs::test {

struct ProgramRun {
  int exit_code = -1;  ///< 128 + signal when it was killed
  std::string out, err;
};

/// The bytes of a file; empty if it cannot be read.
std::string content_of(const std::filesystem::path& path);

/// `program` is found in PATH if it has no slash; exit code 127 if it is not found. `meanwhile` is
/// called with the program's process while it runs.
ProgramRun run_program(const std::string& program, const std::vector<std::string>& arguments,
                       const std::function<void(pid_t)>& meanwhile = {});

/// Runs the program of this build.
ProgramRun run_quadsplat(const std::vector<std::string>& arguments,
                         const std::function<void(pid_t)>& meanwhile = {});

}  // namespace qs::test
