// SPDX-License-Identifier: MIT
#pragma once

#include <cstdio>
#include <string>

#include <fmt/format.h>

namespace qs {

/// Prints "quadsplat: SENTENCE" to stderr unless it is empty.
inline void warn(const std::string& sentence) {
  if (!sentence.empty()) fmt::print(stderr, "quadsplat: {}\n", sentence);
}

}  // namespace qs
