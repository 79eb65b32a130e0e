// SPDX-License-Identifier: MIT
//
// Divides the views of a sweep among processes: of every `count` consecutive views, shard i takes
// the i-th. `--shard 1/4` to `--shard 4/4` together measure the same views as one run.
#pragma once

#include <cstddef>
#include <string_view>

namespace qs {

struct Shard {
  int index = 1, count = 1;  ///< 1 <= index <= count

  bool takes(std::size_t view) const {
    return view % static_cast<std::size_t>(count) == static_cast<std::size_t>(index - 1);
  }
};

/// "2/4". Throws Error(usage).
Shard parse_shard(std::string_view what, std::string_view text);

}  // namespace qs
