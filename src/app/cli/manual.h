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

}  // namespace qs
