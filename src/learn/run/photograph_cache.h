// SPDX-License-Identifier: MIT
//
// The pixels of a data set's photographs in limited memory. Background threads read missing
// photographs, including the next ones in the order of use. The least recently used photographs are
// dropped to make room. If a photograph has changed when it is read again, that is an error.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <map>
#include <mutex>
#include <set>
#include <span>
#include <stop_token>
#include <thread>
#include <vector>

#include "learn/run/data_set.h"

namespace qs::train {

class PhotographCache {
 public:
  /// A thread decodes a photograph in the time of several iterations on a GPU.
  static constexpr unsigned kMostThreads = 8;

  /// Starts the threads if `data`, which must outlive the cache, is larger than its limit of
  /// memory. The photographs of two views always fit: the view in use and the next view.
  explicit PhotographCache(const DataSet& data);
  ~PhotographCache();

  /// The view of the data set with its pixels, valid until the next call. `next` are views of the
  /// data set that are used afterwards, soonest first. Throws Error(input) as read_view() does, and
  /// if the photograph was changed.
  const PhotographView& view(const PhotographView& wanted,
                             std::span<const PhotographView* const> next);

  /// The number of times that photographs were read.
  std::size_t reads() const;

 private:
  struct Entry {
    PhotographView view;
    std::uint64_t last_use = 0;
  };
  using Wanted = std::vector<const PhotographView*>;

  void read_ahead(const std::stop_token& stop);
  const PhotographView* next_to_read() const;
  bool make_room(const PhotographView& view);

  const std::uint64_t limit_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  // Guarded by mutex_. Views of the data set are keys.
  std::map<const PhotographView*, Entry> held_;
  std::set<const PhotographView*> being_read_;
  std::map<const PhotographView*, std::exception_ptr> errors_;
  Wanted wanted_;            // the view in use and the next views
  std::uint64_t bytes_ = 0;  // size of held_ and being_read_
  std::uint64_t uses_ = 0;
  std::size_t reads_ = 0;
  std::vector<std::jthread> threads_;
};

}  // namespace qs::train
