// SPDX-License-Identifier: MIT
//
// The one error type. Libraries throw it, `main` and the viewer's loop catch it, nobody else does.
// The message is one sentence "who: where: what", fit to be shown to a person as it is.
// This header is plain C++ so that device code may include it; fail.h adds fmt formatting.
#pragma once

#include <stdexcept>
#include <string>

namespace qs {

/// What a user can do about an error; `main` turns it into the exit code.
enum class ErrorKind {
  usage = 1,   ///< the command line is wrong
  input = 2,   ///< a file is missing, damaged or not what it should be
  device = 3,  ///< no usable device, or not enough memory
};

class Error : public std::runtime_error {
 public:
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// Thrown by work whose stop_token was asked to stop. Not an Error: nothing went wrong.
struct Cancelled {};

}  // namespace qs
