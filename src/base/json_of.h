// SPDX-License-Identifier: MIT
//
// Values as JSON that the library does not convert itself.
#pragma once

#include <cmath>
#include <optional>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

namespace qs {

inline nlohmann::ordered_json json_of(glm::vec2 v) { return {v.x, v.y}; }
inline nlohmann::ordered_json json_of(glm::vec3 v) { return {v.x, v.y, v.z}; }
inline nlohmann::ordered_json json_of(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

/// null for an unset value.
template <class T>
nlohmann::ordered_json json_of(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

/// null for infinities and NaN, which JSON does not have.
inline nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace qs
