// SPDX-License-Identifier: MIT
//
// Parses untrusted JSON: size and nesting are limited, and errors are one sentence.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace qs {

/// The default limit of values in a file; each takes at least 16 bytes of memory.
inline constexpr std::size_t kMaxJsonValues = std::size_t{1} << 25;

/// Throws Error(input) "source: not valid JSON: ..." for damaged text, more than 64 nested levels
/// or more than `max_values` values.
nlohmann::json parse_json(std::string_view text, std::string_view source,
                          std::size_t max_values = kMaxJsonValues);

/// The whole text of a small file. Throws Error(input) when it is missing or larger than
/// `max_bytes`.
std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes);

}  // namespace qs
