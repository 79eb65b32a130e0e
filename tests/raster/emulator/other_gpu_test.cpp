// SPDX-License-Identifier: MIT
//
// The GPU that has an array's memory, on a machine with another GPU.
#include <gtest/gtest.h>

#include "cuda_runtime.h"
#include "learn/diff/cuda/device.h"

namespace qs::cuda::diff {
namespace {

TEST(OtherGpu, is_known_by_the_memory) {
  float here = 0, there = 0;
  emulator::memory_of_gpu_1 = &there;
  EXPECT_EQ(other_gpu_of(&there, 0), 1);
  EXPECT_EQ(other_gpu_of(&here, 0), std::nullopt);
  EXPECT_EQ(other_gpu_of(&there, 7), std::nullopt);  // the machine has no such GPU
  emulator::memory_of_gpu_1 = nullptr;
}

}  // namespace
}  // namespace qs::cuda::diff
