// SPDX-License-Identifier: MIT
//
// Calls code that is compiled for each value of some flags.
#pragma once

#include <type_traits>

namespace qs::diff {

/// Calls f(std::bool_constant<flag>{}...).
template <class F, class... Flags>
void with_flags(const F& f, bool flag, Flags... rest) {
  const auto with = [&](auto known) {
    if constexpr (sizeof...(rest) == 0)
      f(known);
    else
      with_flags([&](auto... others) { f(known, others...); }, rest...);
  };
  if (flag)
    with(std::true_type{});
  else
    with(std::false_type{});
}

}  // namespace qs::diff
