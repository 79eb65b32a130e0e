// SPDX-License-Identifier: MIT
#include "base/warn.h"

#include <cstdio>

#include <fmt/format.h>

namespace qs {

void warn(const std::string& sentence) {
  if (!sentence.empty()) fmt::print(stderr, "quadsplat: {}\n", sentence);
}

}  // namespace qs
