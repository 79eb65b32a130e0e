// SPDX-License-Identifier: MIT
//
// The table of commands, and the function that runs a command line.
// To add a command: cmd_NAME.cpp with NAME_command(), a row in command.cpp and a test. The sweep
// test tries the pairs of its options.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "app/cli/options.h"
#include "base/quit_signals.h"

namespace qs {

/// The exit code of the process. Error(kind) ends the process with the kind's number, and a signal
/// with kExitInterrupted (base/quit_signals.h).
enum ExitCode { kExitOk = 0, kExitUsage = 1, kExitInput = 2, kExitDevice = 3, kExitComparison = 4 };

/// Words of a command line.
using Arguments = std::span<const std::string>;

/// Runs a command after its options were parsed and returns the exit code. Throws Error, Cancelled.
/// `arguments` are the words after the command's name.
using CommandAction = std::function<int(Arguments arguments)>;

struct Command {
  const char* name;
  const char* summary;
  CommandAction (*declare)(
      Options& options);  ///< the action owns the variables that `options` fills
};

std::span<const Command> commands();

/// Runs the command named by the first argument, else `view`. Throws Error.
int run_program(Arguments arguments);

// The manual page and the completion of the shell, made from the tables of commands and options.

/// A page for man(1), section 1.
std::string man_page();

/// A script for bash-completion: commands, options, their values, and files.
std::string bash_completion();

/// The scene formats as Markdown tables, made of the tables of readers and writers. docs/formats.md
/// has the same text, which a test checks.
std::string format_list();

}  // namespace qs
