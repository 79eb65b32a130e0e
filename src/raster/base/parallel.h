// SPDX-License-Identifier: MIT
//
// A fixed pool of threads and one way to use it: a loop over chunks of an index range.
// The calling thread works too, so a pool of one thread starts none. Results never depend on the
// number of threads as long as chunks write to places of their own.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace qs {

class ThreadPool {
 public:
  /// `threads` counts the calling thread; 0 means one per hardware thread.
  explicit ThreadPool(int threads = 0);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int size() const;

  /// Calls body(begin, end, worker) for consecutive chunks of at most `grain` indices covering
  /// [0, count). Chunks are handed out in ascending order; 0 <= worker < size(). Returns when all
  /// are done. The first exception thrown by a body is rethrown here, after the running chunks
  /// ended. Not reentrant: a body must not call into the same pool.
  void for_chunks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end, int worker)>& body);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace qs
