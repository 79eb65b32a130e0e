// SPDX-License-Identifier: MIT
//
// Reads values of JSON that this program wrote and that a user may have edited.
#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include "base/fail.h"
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

// Reads fields of one untrusted JSON object. `where` names file and record; every error is one
// sentence "where: key ..." as Error(input). Numbers are finite.

struct JsonEntry {
  using json = nlohmann::json;

  const json& object;
  std::string where;

  bool has(const char* key) const { return object.contains(key) && !object[key].is_null(); }

  const json& get(const char* key) const {
    if (!has(key)) fail("{}: {} is missing", where, key);
    return object[key];
  }

  double number(const json& value, const char* key) const {
    if (value.is_string() && is_not_finite(value.get_ref<const std::string&>()))
      fail_not_finite("{}: {} is {}", where, key, value.get_ref<const std::string&>());
    if (!value.is_number()) fail("{}: {} is not a number", where, key);
    const auto number = value.get<double>();
    if (!std::isfinite(number)) fail_not_finite("{}: {} is not finite", where, key);
    return number;
  }

  double number(const char* key) const { return number(get(key), key); }

  /// A whole number from 0 to 1e12: sums of many stay below 2^64.
  std::uint64_t whole(const json& value, const char* key) const {
    const double result = number(value, key);
    if (!(result >= 0 && result <= 1e12 && result == std::floor(result)))
      fail("{}: {} is {}, but must be a whole number from 0 up", where, key, result);
    return static_cast<std::uint64_t>(result);
  }
  std::uint64_t whole(const char* key) const { return whole(get(key), key); }

  double positive(const char* key) const {
    const double value = number(key);
    if (!(value > 0)) fail("{}: {} is {}, but must be above 0", where, key, value);
    return value;
  }

  /// Width or height of a picture, pixels.
  int side(const char* key) const {
    constexpr int kMaxSide = 65535;
    const double value = number(key);
    if (value < 1 || value > kMaxSide || value != std::floor(value))
      fail("{}: {} is {}, but must be a whole number from 1 to {}", where, key, value, kMaxSide);
    return static_cast<int>(value);
  }

  const std::string& text(const char* key) const {
    const json& value = get(key);
    if (!value.is_string()) fail("{}: {} is not a string", where, key);
    return value.get_ref<const std::string&>();
  }

  template <int kSize>
  glm::vec<kSize, double> vector(const json& value, const char* key) const {
    if (!value.is_array() || value.size() != kSize)
      fail("{}: {} is not a list of {} numbers", where, key, kSize);
    glm::vec<kSize, double> result;
    for (int i = 0; i < kSize; ++i) result[i] = number(value[static_cast<std::size_t>(i)], key);
    return result;
  }
  template <int kSize>
  glm::vec<kSize, double> vector(const char* key) const {
    return vector<kSize>(get(key), key);
  }

  /// The fields of the object `key`.
  JsonEntry child(const char* key) const {
    const json& value = get(key);
    if (!value.is_object()) fail("{}: {} is not an object", where, key);
    return {value, fmt::format("{}: {}", where, key)};
  }
};

}  // namespace qs
