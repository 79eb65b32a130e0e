// SPDX-License-Identifier: MIT
//
// What reading a file may cost at most, whatever is in it: 5 s, and 1 GiB of heap beyond the scene
// that it decodes to. The heap is everything that comes from malloc, in this program and in the
// libraries it calls (operator new, zlib, zstd, libzip, libwebp); mapped files do not count.
#pragma once

#include <cstddef>
#include <functional>

#include "raster/scene/gaussian_cloud.h"

namespace qs::test {

/// Fails the test when `read` costs more. It returns the decoded scene's bytes, 0 when the file was
/// refused. Not reentrant.
void expect_within_limits(const std::function<std::size_t()>& read);

std::size_t bytes_of(const GaussianCloud& cloud);

/// The most heap bytes that were alive at once since it was made, beyond those alive then. Threads
/// are counted together; at most one exists at a time.
class HeapPeak {
 public:
  HeapPeak();
  std::size_t bytes() const;

 private:
  long before_;
};

}  // namespace qs::test
