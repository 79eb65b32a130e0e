// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

namespace qs {

/// `of(each)` of every element of a range; `of` is a function or a member.
template <class T, class Range, class Of>
std::vector<T> list_of(const Range& range, const Of& of) {
  std::vector<T> list;
  for (const auto& each : range) list.emplace_back(std::invoke(of, each));
  return list;
}

}  // namespace qs
