// SPDX-License-Identifier: MIT
#include <memory>
#include <utility>
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

struct Block {
  ucontext_t scheduler;
  std::vector<Fiber> fibers;
  const std::function<void()>* thread = nullptr;
  Fiber* running = nullptr;
  int arriving = 0, arrived = 0;  // sums of this and of the previous barrier
};

Block block;

void run_thread() {
  (*block.thread)();
  block.running->ended = true;
}

}  // namespace

void run_block(unsigned threads, const std::function<void()>& thread) {
  if (block.fibers.size() < threads) block.fibers.resize(threads);
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
  block.arriving = 0;
  for (bool any = true; any;) {  // a round ends when every thread waits or has ended
    any = false;
    block.arrived = std::exchange(block.arriving, 0);
    for (unsigned i = 0; i < threads; ++i) {
      if (block.fibers[i].ended) continue;
      any = true;
      threadIdx.x = i;
      block.running = &block.fibers[i];
      swapcontext(&block.scheduler, &block.running->context);
    }
  }
}

int barrier(int value) {
  block.arriving += value;
  Fiber* const self = block.running;
  swapcontext(&self->context, &block.scheduler);
  return block.arrived;
}

}  // namespace emulator
