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
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <thread>
#include <vector>

#include "base/parallel.h"
#include "learn/run/data_set.h"
#include "raster/scene/resample.h"

namespace qs::train {

// The photographs of a data set, reduced by a factor while training begins at a low resolution.

enum class ReductionFilter {
  triangle,  ///< as an antialiased bilinear resize
  lanczos2,  ///< sharper; its overshoots are cut off at 0 and 255
};

/// The weights of old values in new value `i` when `from` values become `to`; 1 <= to <= from.
/// Their sum is 1.
Taps reduction_taps(int from, int to, int i, ReductionFilter filter);

/// The view at floor(1 / factor) of its size, at least one pixel, with the same field of view. A
/// pixel is masked out if a masked pixel lies in it, unless no pixel were left.
PhotographView reduced(const PhotographView& view, int factor, ReductionFilter filter,
                       ThreadPool& pool);

/// Keeps the views of one factor, in as much memory as they need.
class ReducedPhotographs {
 public:
  ReducedPhotographs(std::size_t views, ReductionFilter filter, ThreadPool& pool)
      : filter_(filter), views_(views), pool_(pool) {}

  /// Forgets the views of another factor. Returns true if the factor changes.
  bool set_factor(int factor);

  /// View `number`, which has its pixels in `full`, reduced by the factor; `full` itself for factor
  /// 1. Valid until the factor changes; if not `keeps`, until the next call.
  const PhotographView& view(std::size_t number, const PhotographView& full, bool keeps);

 private:
  const ReductionFilter filter_;
  int factor_ = 1;
  std::vector<std::optional<PhotographView>> views_;
  std::optional<PhotographView> passing_;
  ThreadPool& pool_;
};

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
