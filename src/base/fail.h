// SPDX-License-Identifier: MIT
//
// fail(...) throws an Error with a formatted message. Host code only: fmt does not compile in .cu.
#pragma once

#include <utility>

#include <fmt/format.h>

#include "base/error.h"

namespace qs {

/// Throws Error(kind, message). Example: fail(ErrorKind::input, "{}: vertex {}: x is NaN", path,
/// i).
template <class... Args>
[[noreturn]] void fail(ErrorKind kind, fmt::format_string<Args...> format, Args&&... args) {
  throw Error(kind, fmt::format(format, std::forward<Args>(args)...));
}

/// Throws Error(ErrorKind::input, message).
template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(ErrorKind::input, fmt::format(format, std::forward<Args>(args)...));
}

/// Throws NotFinite(message).
template <class... Args>
[[noreturn]] void fail_not_finite(fmt::format_string<Args...> format, Args&&... args) {
  throw NotFinite(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace qs
