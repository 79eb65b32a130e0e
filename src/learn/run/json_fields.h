// SPDX-License-Identifier: MIT
//
// One function that names the members of a struct both writes them to a JSON object and reads them
// from it.
#pragma once

#include <string>

#include "io/bytes/json_value.h"

namespace qs::train {

class JsonFields {
 public:
  /// Adds members to `json`.
  static JsonFields writing(nlohmann::ordered_json& json) { return {&json, nullptr}; }
  /// Reads members of `json`. Throws nlohmann::json::exception.
  static JsonFields reading(const nlohmann::ordered_json& json) { return {nullptr, &json}; }

  template <class T>
  void operator()(const char* name, T& value) {
    if (to_ != nullptr) (*to_)[name] = value;
    if (from_ != nullptr) json_value(from_->at(name), value);
  }

  /// A member that is one of two words; the second one stands for true.
  void choice(const char* name, const char* no, const char* yes, bool& value) {
    std::string word = value ? yes : no;
    (*this)(name, word);
    value = word == yes;
  }

 private:
  JsonFields(nlohmann::ordered_json* to, const nlohmann::ordered_json* from)
      : to_(to), from_(from) {}

  nlohmann::ordered_json* to_;
  const nlohmann::ordered_json* from_;
};

}  // namespace qs::train
