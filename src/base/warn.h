// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace qs {

/// Prints "quadsplat: SENTENCE" to stderr unless it is empty.
void warn(const std::string& sentence);

}  // namespace qs
