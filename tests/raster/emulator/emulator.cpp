// SPDX-License-Identifier: MIT
#include <memory>
#include <vector>

#include <ucontext.h>

#include "cuda_runtime.h"

namespace emulator {
namespace {

constexpr std::size_t kStackBytes = 64 << 10;

struct Fiber {
  ucontext_t context;
  std::unique_ptr<char[]> stack{new char[kStackBytes]};
  bool ended = false;
};

/// Where threads meet: each leaves a value and waits until all are there.
struct Meeting {
  unsigned arrived = 0, generation = 0;
  std::uint64_t arriving[kWarpSize];  // by lane; what a warp's threads brought
  int arriving_sum = 0, sum = 0;      // what a block's threads brought
  std::array<std::uint64_t, kWarpSize> values;
};

struct Block {
  ucontext_t scheduler;
  std::vector<Fiber> fibers;
  std::vector<Meeting> warps;
  Meeting all;
  unsigned alive = 0;
  const std::function<void()>* thread = nullptr;
};

Block block;

void take_turns() {
  const unsigned self = threadIdx.x;
  swapcontext(&block.fibers[self].context, &block.scheduler);
}

void wait_for(Meeting& meeting, unsigned expected) {
  if (++meeting.arrived == expected) return;
  const unsigned generation = meeting.generation;
  while (meeting.generation == generation) take_turns();
}

void release_block() {
  block.all.sum = block.all.arriving_sum;
  block.all.arriving_sum = 0;
  block.all.arrived = 0;
  ++block.all.generation;
}

void run_thread() {
  (*block.thread)();
  block.fibers[threadIdx.x].ended = true;
  --block.alive;
  if (block.alive > 0 && block.all.arrived == block.alive) release_block();
}

}  // namespace

void run_block(unsigned threads, const std::function<void()>& thread) {
  if (block.fibers.size() < threads) block.fibers.resize(threads);
  block.warps.assign((threads + kWarpSize - 1) / kWarpSize, {});
  block.all = {};
  block.alive = threads;
  block.thread = &thread;
  for (unsigned i = 0; i < threads; ++i) {
    Fiber& fiber = block.fibers[i];
    fiber.ended = false;
    getcontext(&fiber.context);
    fiber.context.uc_stack.ss_sp = fiber.stack.get();
    fiber.context.uc_stack.ss_size = kStackBytes;
    fiber.context.uc_link = &block.scheduler;
    makecontext(&fiber.context, run_thread, 0);
  }
  while (block.alive > 0) {
    for (unsigned i = 0; i < threads; ++i) {
      if (block.fibers[i].ended) continue;
      threadIdx.x = i;
      swapcontext(&block.scheduler, &block.fibers[i].context);
    }
  }
}

int barrier(int value) {
  Meeting& meeting = block.all;
  meeting.arriving_sum += value;
  wait_for(meeting, block.alive);
  if (meeting.arrived == block.alive) release_block();
  return meeting.sum;
}

const std::array<std::uint64_t, kWarpSize>& warp_exchange(std::uint64_t value) {
  Meeting& meeting = block.warps[threadIdx.x / kWarpSize];
  meeting.arriving[threadIdx.x % kWarpSize] = value;
  wait_for(meeting, kWarpSize);
  if (meeting.arrived == kWarpSize) {
    std::copy_n(meeting.arriving, kWarpSize, meeting.values.begin());
    meeting.arrived = 0;
    ++meeting.generation;
  }
  return meeting.values;
}

}  // namespace emulator
