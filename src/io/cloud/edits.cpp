// SPDX-License-Identifier: MIT
#include "io/cloud/edits.h"

#include <fmt/format.h>
#include <zlib.h>

namespace qs {

void Edits::remove(std::size_t count, const std::function<bool(std::size_t i)>& goes) {
  if (removed.empty()) removed.resize(count);
  std::vector<Bytef> bits((removed.size() + 7) / 8);
  std::size_t left = 0;
  kept = 0;
  for (std::size_t i = 0; i < removed.size(); ++i) {
    if (!removed[i]) removed[i] = goes(left++);
    if (removed[i]) bits[i / 8] |= static_cast<Bytef>(1u << i % 8);
    kept += !removed[i];
  }
  of = removed.size();
  crc = fmt::format("crc32:{:08x}", crc32_z(0, bits.data(), bits.size()));
  ++steps;
}

}  // namespace qs
