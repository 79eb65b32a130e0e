// SPDX-License-Identifier: MIT
//
// JSON from files that anybody may have written: size and nesting are limited, and what is wrong is
// said in one sentence.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace qs {

/// Most values that a file is allowed to have unless its reader says otherwise; each takes 16 bytes
/// and more.
inline constexpr std::size_t kMaxJsonValues = std::size_t{1} << 25;

/// Throws Error(input) "source: not valid JSON: ..." for damaged text, more than 64 nested levels
/// or more than `max_values` values.
nlohmann::json parse_json(std::string_view text, std::string_view source,
                          std::size_t max_values = kMaxJsonValues);

/// The whole text of a small file. Throws Error(input) when it is missing or larger than
/// `max_bytes`.
std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes);

}  // namespace qs
