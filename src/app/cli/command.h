// SPDX-License-Identifier: MIT
//
// The table of commands, and what happens to a command line before one of them runs.
// To add a command: cmd_NAME.cpp with its function declared here, its row in command.cpp, its test.
#pragma once

#include <span>
#include <string>

namespace qs {

/// The process's exit code; Error(kind) ends with the kind's number.
enum ExitCode { kExitOk = 0, kExitUsage = 1, kExitInput = 2, kExitDevice = 3, kExitComparison = 4 };

using Arguments = std::span<const std::string>;

struct Command {
  const char* name;
  const char* summary;
  int (*run)(Arguments arguments);  ///< the words after the command's name; throws Error
};

std::span<const Command> commands();

/// Runs the command that the words after the program's name ask for. Throws Error and Cancelled.
int run_program(Arguments arguments);

int run_view(Arguments arguments);
int run_render(Arguments arguments);
int run_eval(Arguments arguments);
int run_bench(Arguments arguments);
int run_inspect(Arguments arguments);
int run_compare(Arguments arguments);
int run_report(Arguments arguments);
int run_zoom(Arguments arguments);
int run_merge(Arguments arguments);
int run_info(Arguments arguments);
int run_convert(Arguments arguments);

}  // namespace qs
