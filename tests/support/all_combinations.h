// SPDX-License-Identifier: MIT
//
// Tests that loop over cases read here if they try every combination. With every push they try each
// case once; the builds with sanitizers in all code, which scripts/test --all runs, try all
// combinations.
#pragma once

namespace qs::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kAllCombinations = true;
#else
constexpr bool kAllCombinations = false;
#endif

}  // namespace qs::test
