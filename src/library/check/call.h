// SPDX-License-Identifier: MIT
//
// Wraps every qs_ function: exceptions become a result code and a message.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "base/fail.h"

namespace qs::library {

using namespace qs;  // so that the files of the C functions need one directive

/// The name of the option that allows overwriting, for messages.
inline constexpr const char* kOverwriteOption = "the option overwrite";

/// The argument that a sentence is about: "qs_render: pictures[2].color".
struct Where {
  const char* call;              ///< the function
  const char* argument;          ///< its argument
  std::int64_t index = -1;       ///< into an array of structs, or -1
  const char* member = nullptr;  ///< a member of the struct, or null

  std::string text() const;
};

/// The place of a member of `where`.
constexpr Where operator/(Where where, const char* member) {
  where.member = member;
  return where;
}

/// Throws Error(usage) "WHERE: message".
template <class... Args>
[[noreturn]] void refuse(const Where& where, fmt::format_string<Args...> format, Args&&... args) {
  fail(ErrorKind::usage, "{}: {}", where.text(), fmt::format(format, std::forward<Args>(args)...));
}

/// Copies the text, or the part of it that fits, with an end of 0. Never cuts a character.
void copy_text(std::string_view text, char* target, std::size_t bytes) noexcept;

/// In a catch block: the result for the exception, whose sentence is copied to `message`, which may
/// be null.
std::int32_t result_of_exception(char* message) noexcept;

/// Throws Error(usage) if a pointer is null.
inline void require(const void* pointer, const Where& where) {
  if (pointer == nullptr) refuse(where, "is null");
}

/// Runs work(function), with the name of a qs_ function, and returns its result for C.
template <class Work>
std::int32_t call(const char* function, char* message, const Work& work) noexcept {
  try {
    if (message != nullptr) *message = 0;
    work(function);
    return 0;
  } catch (...) {
    return result_of_exception(message);
  }
}

/// The same for a function with a context or a scene, `given`, that is not null.
template <class Work>
std::int32_t call(const char* function, char* message, const char* argument, const void* given,
                  const Work& work) noexcept {
  return call(function, message, [&](const char* name) {
    require(given, {name, argument});
    work(name);
  });
}

/// Throws Error(usage) if one of these arguments of a function is null.
inline void require_all(const char* function,
                        std::initializer_list<std::pair<const char*, const void*>> arguments) {
  for (const auto& [name, pointer] : arguments) require(pointer, {function, name});
}
/// Throws Error(usage) if a text is null or empty.
inline void require_text(const char* text, const Where& where) {
  require(text, where);
  if (*text == 0) refuse(where, "is empty");
}

}  // namespace qs::library
