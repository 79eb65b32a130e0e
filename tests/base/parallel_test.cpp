// SPDX-License-Identifier: MIT
#include "base/parallel.h"

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace qs {
namespace {

const std::thread::id kMain = std::this_thread::get_id();

TEST(ThreadPool, visits_every_index_once_for_every_grain) {
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.size(), threads);
    for (const std::size_t grain :
         {std::size_t{1}, std::size_t{7}, std::size_t{1000}, std::size_t{0}}) {
      std::vector<int> visits(777);
      pool.for_chunks(visits.size(), grain, [&](std::size_t begin, std::size_t end, int worker) {
        EXPECT_LT(worker, threads);
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
      EXPECT_EQ(visits, std::vector<int>(777, 1));
    }
  }
}

TEST(ThreadPool, rethrows_the_first_exception_and_stays_usable) {
  ThreadPool pool(3);
  EXPECT_THROW(pool.for_chunks(1000, 1,
                               [](std::size_t begin, std::size_t, int) {
                                 if (begin == 500) throw std::runtime_error("body");
                               }),
               std::runtime_error);
  std::atomic<int> sum = 0;
  for (int repeat = 0; repeat < 200; ++repeat) {
    pool.for_chunks(10, 3, [&](std::size_t begin, std::size_t end, int) {
      sum += static_cast<int>(end - begin);
    });
  }
  EXPECT_EQ(sum, 2000);
}

TEST(ThreadPool, a_single_chunk_runs_on_the_calling_thread) {
  ThreadPool pool(3);
  for (int repeat = 0; repeat < 100; ++repeat) {
    pool.for_chunks(10, 10, [](std::size_t begin, std::size_t end, int worker) {
      EXPECT_EQ(std::this_thread::get_id(), kMain);
      EXPECT_EQ(worker, 0);
      EXPECT_EQ(end - begin, 10u);
    });
  }
  EXPECT_THROW(pool.for_chunks(1, 1, [](auto...) { throw std::runtime_error("body"); }),
               std::runtime_error);
  std::atomic<int> sum = 0;
  pool.for_chunks(10, 1, [&](std::size_t, std::size_t, int) { ++sum; });
  EXPECT_EQ(sum, 10);
}

TEST(ThreadPool, an_empty_range_calls_nothing) {
  ThreadPool pool(2);
  pool.for_chunks(0, 4, [](std::size_t, std::size_t, int) { FAIL(); });
}

}  // namespace
}  // namespace qs
