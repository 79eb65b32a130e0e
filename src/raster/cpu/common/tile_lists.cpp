// SPDX-License-Identifier: MIT
#include "raster/cpu/common/tile_lists.h"

#include <unistd.h>

#include "base/fail.h"

namespace qs::cpu {

void refuse_if_too_many(std::uint64_t pairs) {
  const std::uint64_t needed = pairs * sizeof(std::uint32_t);
  const std::uint64_t memory = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                               static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  if (needed > memory / 2) {
    fail(ErrorKind::device,
         "bin: this view lists {} tile pairs, which need {} MiB; the machine has {} MiB", pairs,
         needed >> 20, memory >> 20);
  }
}

}  // namespace qs::cpu
