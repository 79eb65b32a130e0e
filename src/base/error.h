// SPDX-License-Identifier: MIT
//
// The only error type. Libraries throw it; only `main` and the viewer's loop catch it.
// The message is one sentence "who: where: what" that can be shown to users unchanged.
// This header is plain C++ so that device code may include it; fail.h adds fmt formatting.
#pragma once

#include <new>
#include <stdexcept>
#include <string>

namespace qs {

/// The cause of an error; `main` returns it as the exit code.
enum class ErrorKind {
  usage = 1,   ///< the command line is wrong
  input = 2,   ///< a file is missing, damaged or of the wrong kind
  device = 3,  ///< no usable device, or not enough memory
};

class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// An error in the input about a number that is NaN or infinite. A reader of many records may leave
/// out the record.
class NotFinite : public Error {
 public:
  explicit NotFinite(const std::string& message) : Error(ErrorKind::input, message) {}
};

/// Thrown by work that was stopped through its stop_token. Not an Error, because nothing failed.
struct Cancelled {};

/// The sentence of any exception.
inline const char* sentence_of(const std::exception& error) {
  const bool no_memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
                         dynamic_cast<const std::length_error*>(&error) != nullptr;
  return no_memory ? "not enough memory" : error.what();
}

}  // namespace qs
