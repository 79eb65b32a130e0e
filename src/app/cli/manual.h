// SPDX-License-Identifier: MIT
//
// The manual page and the completion of the shell, made from the tables of commands and options.
#pragma once

#include <string>

namespace qs {

/// A page for man(1), section 1.
std::string man_page();

/// A script for bash-completion: commands, options, their values, and files.
std::string bash_completion();

/// The scene formats as Markdown tables, made of the tables of readers and writers. docs/formats.md
/// has the same text, which a test checks.
std::string format_list();

}  // namespace qs
