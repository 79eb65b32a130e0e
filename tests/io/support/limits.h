// SPDX-License-Identifier: MIT
//
// Limits on the cost of reading any file: 5 s, and 1 GiB of heap beyond the decoded scene. The heap
// is all memory from malloc, in this program and in the libraries it calls (operator new, zlib,
// zstd, libwebp); mapped files do not count.
#pragma once

#include <cstddef>
#include <functional>

#include "raster/scene/gaussian_cloud.h"

namespace qs::test {

/// Fails the test if `read` exceeds the limits. `read` returns the decoded scene's bytes, or 0 if
/// the file was refused. Not reentrant.
void expect_within_limits(const std::function<std::size_t()>& read);

std::size_t bytes_of(const GaussianCloud& cloud);

/// Peak of heap bytes since construction, minus the bytes in use at construction. Threads are
/// counted together; at most one object exists at a time.
class HeapPeak {
 public:
  HeapPeak();
  std::size_t bytes() const;

 private:
  long before_;
};

}  // namespace qs::test
