// SPDX-License-Identifier: MIT
//
// Reads pickles, the serialised objects of Python, as data. Python's own reader runs any code that
// a pickle names; this one builds a description of the objects and calls nothing. It knows the
// operations and the names that files of PyTorch, NumPy and dahuffman hold, and refuses all others
// with their name. Operations, nesting and sizes are limited.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/bytes/byte_text.h"

namespace qs {

/// An object is its number in a Pickle. Objects may be shared, and a list may hold itself.
using PickleRef = std::uint32_t;

enum class PickleKind : std::uint8_t {
  none,
  boolean,
  integer,       ///< has at most 64 bits
  long_integer,  ///< has more bits: `bytes`, little endian, two's complement
  real,
  text,  ///< UTF-8
  bytes,
  tuple,
  list,
  dictionary,  ///< keys and values in turns; also a collections.OrderedDict
  name,        ///< a class or function: "module.name"
  call,        ///< the result that a call would have: `text` is the name, `items` are the arguments
  persistent,  ///< an object outside of the pickle: its only item describes it
};

struct PickleObject {
  PickleKind kind = PickleKind::none;
  std::int64_t integer = 0;  ///< also the value of a boolean
  double real = 0;
  std::string_view text = {};         ///< a text, or the name of a name or call
  ByteSpan bytes = {};                ///< a bytes or long_integer
  std::vector<PickleRef> items = {};  ///< the items of containers, `call` and `persistent`
  PickleRef state = 0;  ///< the state that the object of a call would be given; 0 if none
};

class Pickle {
 public:
  /// Interprets the pickle at the front of `content`, which must outlive this. `source` begins
  /// messages. Throws Error(input).
  Pickle(ByteSpan content, std::string source);

  PickleRef root() const { return root_; }
  /// Bytes of the pickle; more may follow.
  std::size_t size() const { return size_; }
  const std::string& source() const { return source_; }
  ByteSpan content() const { return content_; }

  const PickleObject& operator[](PickleRef object) const { return objects_[object]; }
  /// Objects are numbered from 1 to object_count() - 1.
  PickleRef object_count() const { return static_cast<PickleRef>(objects_.size()); }

  // Each of these throws Error(input) "SOURCE: its pickle: WHAT is ..." if the object is not as
  // expected.
  std::int64_t integer(PickleRef object, const char* what) const {
    return expect(PickleKind::integer, object, what).integer;
  }
  std::string_view text(PickleRef object, const char* what) const {
    return expect(PickleKind::text, object, what).text;
  }
  /// The items of a tuple with `count` of them.
  std::span<const PickleRef> tuple(PickleRef object, std::size_t count, const char* what) const;
  std::span<const PickleRef> tuple(PickleRef object, const char* what) const {
    return expect(PickleKind::tuple, object, what).items;
  }
  /// The arguments of the call of `name`, at least `count` of them.
  std::span<const PickleRef> call(PickleRef object, std::string_view name, std::size_t count,
                                  const char* what) const;

  /// The value of a text key; 0 if there is none, or if the object is no dictionary.
  PickleRef find(PickleRef dictionary, std::string_view key) const;

 private:
  friend class PickleMachine;

  const PickleObject& expect(PickleKind kind, PickleRef object, const char* what) const;

  ByteSpan content_;
  std::string source_;
  std::vector<PickleObject> objects_;  // object 0 stands for "no object"
  PickleRef root_ = 0;
  std::size_t size_ = 0;
};

// Writes pickles, operation by operation, in protocol 3. Nothing is remembered, so objects are not
// shared. pickle.h reads them.

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
