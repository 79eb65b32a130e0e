// SPDX-License-Identifier: MIT
//
// Writes pickles, operation by operation, in protocol 3. Nothing is remembered, so objects are not
// shared. pickle.h reads them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace qs {

class PickleWriter {
 public:
  // Values.
  PickleWriter& text(std::string_view value);
  PickleWriter& bytes(std::string_view value);
  PickleWriter& integer(std::int64_t value);
  PickleWriter& real(double value);
  PickleWriter& boolean(bool value) { return put(value ? "\x88" : "\x89"); }
  PickleWriter& none() { return put("N"); }

  // Containers: begin() and a number of values, then what they become. list() and dictionary()
  // come before begin().
  PickleWriter& begin() { return put("("); }
  PickleWriter& tuple() { return put("t"); }
  PickleWriter& list() { return put("]"); }
  PickleWriter& append() { return put("e"); }
  PickleWriter& dictionary() { return put("}"); }
  PickleWriter& set_items() { return put("u"); }

  /// A class or function.
  PickleWriter& name(std::string_view module, std::string_view name);
  /// The result of a call: after its name and a tuple of arguments.
  PickleWriter& call() { return put("R"); }
  /// An object of a class without arguments: after its name.
  PickleWriter& make() { return put(")\x81"); }
  /// Gives a state to the object before.
  PickleWriter& state() { return put("b"); }
  /// An object outside of the pickle: after its description.
  PickleWriter& persistent() { return put("Q"); }

  /// The pickle, whose object is the last value.
  std::string take();

 private:
  PickleWriter& put(std::string_view operation) {
    out_ += operation;
    return *this;
  }

  std::string out_ = "\x80\x03";
};

}  // namespace qs
