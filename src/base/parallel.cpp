// SPDX-License-Identifier: MIT
#include "base/parallel.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <pthread.h>
#include <time.h>

namespace qs {

struct ThreadPool::State {
  struct Loop {
    std::size_t count = 0, grain = 1;
    const std::function<void(std::size_t, std::size_t, int)>* body = nullptr;
    std::atomic<std::size_t> next{0};
  };

  std::mutex mutex;
  std::condition_variable_any wake;
  std::condition_variable finished;
  Loop loop;
  unsigned generation = 0;  // number of the loop; a worker joins each loop once
  int running = 0;
  std::exception_ptr error;
  std::vector<std::jthread> workers;

  void work(int worker) {
    try {
      for (;;) {
        const std::size_t begin = loop.next.fetch_add(loop.grain);
        if (begin >= loop.count) return;
        (*loop.body)(begin, std::min(begin + loop.grain, loop.count), worker);
      }
    } catch (...) {
      loop.next = loop.count;  // no new chunks
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
    }
  }

  void serve(const std::stop_token& stop, int worker) {
    unsigned seen = 0;
    std::unique_lock lock(mutex);
    while (wake.wait(lock, stop, [&] { return generation != seen; })) {
      seen = generation;
      lock.unlock();
      work(worker);
      lock.lock();
      if (--running == 0) finished.notify_one();
    }
  }
};

ThreadPool::ThreadPool(int threads) : state_(std::make_unique<State>()) {
  if (threads <= 0) threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  for (int worker = 1; worker < threads; ++worker)
    state_->workers.emplace_back([state = state_.get(), worker](const std::stop_token& stop) {
      state->serve(stop, worker);
    });
}

ThreadPool::~ThreadPool() = default;

static double seconds_of(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double ThreadPool::processor_seconds() const {
  double sum = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  for (std::jthread& worker : state_->workers) {
    clockid_t clock{};
    if (pthread_getcpuclockid(worker.native_handle(), &clock) == 0) sum += seconds_of(clock);
  }
  return sum;
}

int ThreadPool::size() const { return static_cast<int>(state_->workers.size()) + 1; }

void ThreadPool::for_chunks(std::size_t count, std::size_t grain,
                            const std::function<void(std::size_t, std::size_t, int)>& body) {
  if (count == 0) return;
  State& s = *state_;
  grain = std::max<std::size_t>(grain, 1);
  // Waking a thread takes longer than most single chunks.
  if (count <= grain || s.workers.empty()) {
    for (std::size_t begin = 0; begin < count; begin += grain)
      body(begin, begin + std::min(grain, count - begin), 0);
    return;
  }
  {
    const std::lock_guard lock(s.mutex);
    s.loop.count = count;
    s.loop.grain = grain;
    s.loop.body = &body;
    s.loop.next = 0;
    s.error = nullptr;
    s.running = static_cast<int>(s.workers.size());
    ++s.generation;
  }
  s.wake.notify_all();
  s.work(0);
  std::unique_lock lock(s.mutex);
  s.finished.wait(lock, [&] { return s.running == 0; });
  if (s.error) std::rethrow_exception(std::exchange(s.error, nullptr));
}

}  // namespace qs
