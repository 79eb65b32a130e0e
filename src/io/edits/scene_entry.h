// SPDX-License-Identifier: MIT
//
// Reads objects of files that belong to a scene, edits_file.h and measures_file.h.
#pragma once

#include <cstddef>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/json_value.h"
#include "io/edits/scene_file.h"

namespace qs {

/// It remembers the members that were read. Every error is one sentence, see JsonEntry.
struct SceneEntry : JsonEntry {
  const glm::dvec3& origin;  ///< of the cloud: places in the file count from 0
  std::set<std::string> known = {};

  bool reads(const char* key) {
    known.insert(key);
    return has(key);
  }
  double number_within(const char* key, double low, double high) {
    known.insert(key);
    const double value = number(key);
    if (!(value >= low && value <= high))
      fail("{}: {} is {}, but must be within {} and {}", where, key, value, low, high);
    return value;
  }
  glm::dvec3 place(const char* key) {
    known.insert(key);
    return vector<3>(key) - origin;
  }

  template <class Enum>
  Enum word(const char* key, std::span<const char* const> names, Enum otherwise) {
    return reads(key) ? word<Enum>(key, names) : otherwise;
  }
  template <class Enum>
  Enum word(const char* key, std::span<const char* const> names) {
    known.insert(key);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (text(key) == names[i]) return static_cast<Enum>(i);
    fail("{}: {} is '{}', which is none of {}", where, key, printable(text(key)),
         joined(std::vector<std::string>(names.begin(), names.end()), ", "));
  }

  /// The member "scene", which may be missing.
  EditedScene scene(std::vector<std::string>& warnings);
  /// Adds a sentence for each member that was not read.
  void warn_unknown(std::vector<std::string>& warnings) const;
};

/// The member "scene".
nlohmann::ordered_json json_of(const EditedScene& scene);

}  // namespace qs
