// SPDX-License-Identifier: MIT
#include "io/cloud/edits.h"

#include "io/bytes/file_hash.h"

namespace qs {

std::string set_hash(const GaussianSet& set) { return bytes_hash(set.bytes()); }

void Edits::remove(std::size_t count, const std::function<bool(std::size_t i)>& goes) {
  GaussianSet gone = removed.size() == 0 ? GaussianSet(count) : removed;
  std::size_t left = 0;
  for (std::size_t i = 0; i < gone.size(); ++i)
    if (!gone[i] && goes(left++)) gone.add(i);
  remove(1, gone);
}

void Edits::remove(int count_of_steps, const GaussianSet& gone) {
  removed = gone;
  of = removed.size();
  kept = of - removed.count();
  crc = set_hash(removed);
  steps += count_of_steps;
}

EditFacts Edits::with(const GaussianSet& gone, int count_of_steps) const {
  Edits all = *this;
  if (removed.empty()) {
    all.remove(count_of_steps, gone);
  } else {
    all.remove(gone.size(), [&](std::size_t i) { return gone[i]; });
    all.steps += count_of_steps - 1;
  }
  return all;
}

}  // namespace qs
