// SPDX-License-Identifier: MIT
//
// A cloud assembled from consecutive parts (sections, files, meshes).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace qs {

class CloudParts {
 public:
  /// Appends a part of `count` Gaussians. The caller keeps the sum far below 2^64.
  void add(std::uint64_t count) { ends_.push_back(this->count() + count); }

  std::uint64_t count() const { return ends_.empty() ? 0 : ends_.back(); }

  /// Calls visit(part, row, i) for the Gaussians [begin, end) of the cloud: Gaussian `i` of it is
  /// Gaussian `row` of the part.
  template <class Visit>
  void for_range(std::size_t begin, std::size_t end, const Visit& visit) const {
    auto part = static_cast<std::size_t>(std::upper_bound(ends_.begin(), ends_.end(), begin) -
                                         ends_.begin());
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
