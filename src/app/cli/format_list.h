// SPDX-License-Identifier: MIT
//
// The scene formats as Markdown tables, made of the tables of readers and writers. docs/formats.md
// has the same text, which a test checks.
#pragma once

#include <string>

namespace qs {

std::string format_list();

}  // namespace qs
