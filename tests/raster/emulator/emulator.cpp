// SPDX-License-Identifier: MIT
//
// The threads of a block are fibers that switch with the compiler's __builtin_setjmp and
// __builtin_longjmp: unlike swapcontext() they make no system call, which would dominate the run
// time. ucontext only starts a fiber on its own stack.
#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include <ucontext.h>

#include "cuda_runtime.h"

namespace emulator {
namespace {

constexpr std::size_t kStackBytes = 64 << 10;

/// A point where threads wait for each other and exchange values.
struct Meeting {
  unsigned arrived = 0, generation = 0;
  std::uint64_t arriving[kWarpSize];  // by lane, from the threads of a warp
  int arriving_sum = 0, sum = 0;      // over the threads of a block
  std::array<std::uint64_t, kWarpSize> values;
};

using JumpBuffer = void* [5];  // the size that __builtin_setjmp requires

struct Fiber {
  JumpBuffer resume;
  std::unique_ptr<char[]> stack{new char[kStackBytes]};
  bool started = false, ended = false;
  const Meeting* waits_for = nullptr;
  unsigned generation = 0;  // of that meeting, when the wait began

  bool can_run() const {
    return !ended && (waits_for == nullptr || waits_for->generation != generation);
  }
};

struct Block {
  JumpBuffer scheduler;
  std::vector<Fiber> fibers;
  std::vector<Meeting> warps;
  Meeting all;
  unsigned alive = 0;
  const std::function<void()>* thread = nullptr;
};

Block block;

// A function must not contain both __builtin_setjmp and the __builtin_longjmp that returns to it.
[[gnu::noinline, gnu::noipa, gnu::no_sanitize_address]] void jump(JumpBuffer& to) {
  __builtin_longjmp(to, 1);
}

[[gnu::noinline, gnu::noipa]] void switch_to_scheduler() {
  if (__builtin_setjmp(block.fibers[threadIdx.x].resume) == 0) jump(block.scheduler);
}

void release_block() {
  block.all.sum = block.all.arriving_sum;
  block.all.arriving_sum = 0;
  block.all.arrived = 0;
  ++block.all.generation;
}

/// The body of every fiber: runs one thread per block.
void run_threads() {
  for (;;) {
    (*block.thread)();
    block.fibers[threadIdx.x].ended = true;
    --block.alive;
    if (block.alive > 0 && block.all.arrived == block.alive) release_block();
    switch_to_scheduler();
  }
}

/// Runs a fiber until it waits or its thread ends.
[[gnu::noinline, gnu::noipa]] void resume(Fiber& fiber) {
  if (__builtin_setjmp(block.scheduler) != 0) return;
  if (fiber.started) jump(fiber.resume);
  fiber.started = true;
  ucontext_t context;
  getcontext(&context);
  context.uc_stack.ss_sp = fiber.stack.get();
  context.uc_stack.ss_size = kStackBytes;
  context.uc_link = nullptr;
  makecontext(&context, run_threads, 0);
  setcontext(&context);
}

/// True for the thread that completes the meeting; the others wait until it advances the
/// generation.
bool arrive(Meeting& meeting, unsigned expected) {
  if (++meeting.arrived == expected) return true;
  Fiber& self = block.fibers[threadIdx.x];
  self.waits_for = &meeting;
  self.generation = meeting.generation;
  switch_to_scheduler();
  return false;
}

}  // namespace

std::vector<unsigned> ordered_blocks(unsigned blocks) {
  std::vector<unsigned> order(blocks);
  std::iota(order.begin(), order.end(), 0u);
  if (run_order != 0) std::shuffle(order.begin(), order.end(), std::mt19937(run_order));
  return order;
}

void run_block(unsigned threads, const std::function<void()>& thread) {
  if (block.fibers.size() < threads) block.fibers.resize(threads);
  block.warps.assign((threads + kWarpSize - 1) / kWarpSize, {});
  block.all = {};
  block.alive = threads;
  block.thread = &thread;
  for (unsigned i = 0; i < threads; ++i) {
    block.fibers[i].ended = false;
    block.fibers[i].waits_for = nullptr;
  }
  while (block.alive > 0) {
    for (unsigned k = 0; k < threads; ++k) {
      const unsigned i = run_order % 2 == 0 ? k : threads - 1 - k;
      if (!block.fibers[i].can_run()) continue;
      threadIdx.x = i;
      resume(block.fibers[i]);
    }
  }
}

int barrier(int value) {
  block.all.arriving_sum += value;
  if (arrive(block.all, block.alive)) release_block();
  return block.all.sum;
}

const std::array<std::uint64_t, kWarpSize>& warp_exchange(std::uint64_t value) {
  Meeting& meeting = block.warps[threadIdx.x / kWarpSize];
  meeting.arriving[threadIdx.x % kWarpSize] = value;
  if (arrive(meeting, kWarpSize)) {
    std::copy_n(meeting.arriving, kWarpSize, meeting.values.begin());
    meeting.arrived = 0;
    ++meeting.generation;
  }
  return meeting.values;
}

}  // namespace emulator
