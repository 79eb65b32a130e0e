// SPDX-License-Identifier: MIT
#include "app/measure/shard.h"

#include "base/fail.h"
#include "base/text.h"

namespace qs {

Shard parse_shard(std::string_view what, std::string_view text) {
  constexpr int kMost = 100'000;
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos)
    fail(ErrorKind::usage, "{}: '{}' is not I/N, for example 1/4", what, text);
  Shard shard;
  shard.count = parse_integer(what, text.substr(slash + 1), 1, kMost);
  shard.index = parse_integer(what, text.substr(0, slash), 1, shard.count);
  return shard;
}

}  // namespace qs
