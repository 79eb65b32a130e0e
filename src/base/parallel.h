// SPDX-License-Identifier: MIT
//
// A fixed pool of threads that runs loops over chunks of an index range. The program makes pools
// and passes them to libraries, which never make their own. The calling thread works too, so a pool
// of one thread starts no other. Results do not depend on the number of threads if every chunk
// writes only its own elements.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace qs {

class ThreadPool {
 public:
  /// `threads` counts the calling thread; 0 means one per hardware thread.
  explicit ThreadPool(int threads);
  ~ThreadPool();

  int size() const;

  /// Processor time of the calling thread and of the pool's threads so far, seconds. Unlike time on
  /// the wall it does not grow while other programs use the processors.
  double processor_seconds() const;

  /// Calls body(begin, end, worker) for consecutive chunks of at most `grain` indices that cover
  /// [0, count). Chunks start in ascending order; 0 <= worker < size(). Returns when all chunks are
  /// done. After an exception no new chunk starts, and the first exception is rethrown here. Not
  /// reentrant: neither a body nor another thread may call it while it runs.
  void for_chunks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end, int worker)>& body);

  /// Calls each(i) for all i in [0, count), in such chunks.
  template <class Each>
  void for_each(std::size_t count, std::size_t grain, const Each& each) {
    for_chunks(count, grain, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) each(i);
    });
  }

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace qs
