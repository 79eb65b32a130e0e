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

/// Throws Error(input) "source: not valid JSON: ..." for damaged text or more than 64 nested
/// levels.
nlohmann::json parse_json(std::string_view text, std::string_view source);

/// The whole text of a small file. Throws Error(input) when it is missing or larger than
/// `max_bytes`.
std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes);

}  // namespace qs
