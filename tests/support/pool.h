// SPDX-License-Identifier: MIT
#pragma once

#include <map>

#include "base/parallel.h"

namespace qs::test {

/// A pool of `threads` threads (0 = one per hardware thread) that lives until the program ends.
inline ThreadPool& pool(int threads = 0) {
  static std::map<int, ThreadPool> pools;
  return pools.try_emplace(threads, threads).first->second;
}

}  // namespace qs::test
