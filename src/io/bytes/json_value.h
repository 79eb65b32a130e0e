// SPDX-License-Identifier: MIT
//
// Reads values of JSON that this program wrote and that a user may have edited.
#pragma once

#include <concepts>
#include <cstdint>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "io/bytes/json_text.h"

namespace qs {

/// The value as a T. Throws nlohmann::json::exception if it has another type, or for integers
/// another range; json.get<int>() alone would convert 1e30, which is undefined.
template <class T>
T json_value(const nlohmann::ordered_json& json) {
  if constexpr (std::integral<T> && !std::same_as<T, bool>) {
    const bool fits = json.is_number_unsigned()  ? std::in_range<T>(json.get<std::uint64_t>())
                      : json.is_number_integer() ? std::in_range<T>(json.get<std::int64_t>())
                                                 : false;
    using Limits = std::numeric_limits<T>;
    if (!fits)
      throw nlohmann::json::out_of_range::create(
          406,
          fmt::format("{} is not a whole number from {} to {}", json_line(json), Limits::min(),
                      Limits::max()),
          &json);
  }
  return json.get<T>();
}

template <class T>
void json_value(const nlohmann::ordered_json& json, T& value) {
  value = json_value<T>(json);
}

}  // namespace qs
