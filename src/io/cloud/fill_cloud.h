// SPDX-License-Identifier: MIT
//
// The last step of every reader: fills a cloud in parallel, normalises rotations, removes Gaussians
// that no renderer can draw (NaN, infinite or absurdly large values) and adds warnings about
// removed Gaussians and suspicious values. Afterwards the invariants documented on GaussianCloud's
// members hold.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "base/parallel.h"
#include "io/cloud/scene.h"

namespace qs {

using Fill = std::function<void(std::size_t begin, std::size_t end)>;

/// Calls fill(begin, end) from several threads for disjoint ranges that cover scene.cloud, which
/// already has its size. Reports progress from `start` to 1. Throws Error(input) if no Gaussian is
/// left, Cancelled, and anything that `fill` throws.
void fill_cloud(Scene& scene, ThreadPool& pool, const Progress& progress, float start,
                const Fill& fill);

/// As fill_cloud(), for values that come from no file: adds no warnings, and may leave no Gaussian.
/// Returns the indices of the removed Gaussians, in increasing order. Throws Cancelled, and
/// anything that `fill` throws.
std::vector<std::size_t> fill_drawable(GaussianCloud& cloud, ThreadPool& pool,
                                       const Progress& progress, const Fill& fill);

/// Adds a warning that `count` Gaussians have no valid rotation and got the identity.
void warn_of_missing_rotations(Scene& scene, std::size_t count);

/// Adds a warning that the labels of `count` Gaussians are not in the file's palette of SH.
void warn_of_missing_sh(Scene& scene, std::size_t count);

// A cloud assembled from consecutive parts (sections, files, meshes).

class CloudParts {
 public:
  /// Appends a part of `count` Gaussians. The caller keeps the sum far below 2^64.
  void add(std::uint64_t count) { ends_.push_back(this->count() + count); }

  std::uint64_t count() const { return ends_.empty() ? 0 : ends_.back(); }

  /// Calls visit(part, row, i) for the Gaussians [begin, end) of the cloud: Gaussian `i` of it is
  /// Gaussian `row` of the part.
  template <class Visit>
  void for_range(std::size_t begin, std::size_t end, const Visit& visit) const {
    auto part = static_cast<std::size_t>(std::ranges::upper_bound(ends_, begin) - ends_.begin());
    for (; begin < end && part < ends_.size(); ++part) {
      const std::uint64_t start = part == 0 ? 0 : ends_[part - 1];
      for (; begin < std::min<std::uint64_t>(end, ends_[part]); ++begin)
        visit(part, begin - start, begin);
    }
  }

 private:
  std::vector<std::uint64_t> ends_;
};

}  // namespace qs
