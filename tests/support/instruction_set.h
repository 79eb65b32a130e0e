// SPDX-License-Identifier: MIT
// Tests that run on every instruction set for which code with vectors is compiled.
#pragma once

#include <cstdint>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace qs::test {

/// The scalar version is the fallback for other CPUs.
inline constexpr std::int64_t kInstructionSets[] = {HWY_SCALAR, HWY_SSE4, HWY_AVX2, HWY_AVX3};

/// Runs with one instruction set only, and skips if the machine does not have it.
class InstructionSetTest : public testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override {
    if (GetParam() != HWY_SCALAR && (hwy::SupportedTargets() & GetParam()) == 0)
      GTEST_SKIP() << "this CPU does not have it";
    choose(GetParam());
  }
  void TearDown() override { choose(0); }

  static void choose(std::int64_t instruction_set) {
    hwy::SetSupportedTargetsForTest(instruction_set);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
};

}  // namespace qs::test
