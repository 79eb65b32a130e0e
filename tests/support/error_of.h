// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "base/error.h"

namespace qs::test {

/// The message of the Error that `work` throws, "" if it throws none. Expects that the Error is of
/// `kind`.
inline std::string error_of(const std::function<void()>& work, std::optional<ErrorKind> kind = {}) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind.value_or(error.kind()));
    return error.what();
  }
  return "";
}

/// The text with every "FOLDER/" left out.
inline std::string without_folder(std::string text, const std::filesystem::path& folder) {
  const std::string prefix = folder.string() + "/";
  for (std::size_t at; (at = text.find(prefix)) != text.npos;) text.erase(at, prefix.size());
  return text;
}

/// The message without the folder's path.
inline std::string error_of(const std::function<void()>& work,
                            const std::filesystem::path& folder) {
  return without_folder(error_of(work), folder);
}

}  // namespace qs::test
