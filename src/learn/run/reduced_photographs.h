// SPDX-License-Identifier: MIT
//
// The photographs of a data set, reduced by a factor while training begins at a low resolution.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "learn/run/photograph_view.h"
#include "raster/scene/resample.h"

namespace qs::train {

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

}  // namespace qs::train
