// SPDX-License-Identifier: MIT
//
// Parses untrusted JSON: size and nesting are limited, and errors are one sentence. Parses and
// writes our own JSON. These are functions because the library's parser takes seconds to compile.
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
/// or more than `max_values` values. A byte order mark is skipped.
nlohmann::json parse_json(std::string_view text, std::string_view source,
                          std::size_t max_values = kMaxJsonValues);

/// As parse_json(), but NaN and Infinity, which Python writes, become texts: JsonEntry::number()
/// names them.
nlohmann::json parse_python_json(std::string_view text, std::string_view source);

/// Parses JSON that this program wrote. Throws nlohmann::json::parse_error for damaged text.
nlohmann::ordered_json parse_own_json(std::string_view text);

/// The text of a JSON file: indented by two spaces, with a line break at the end. Damaged UTF-8 is
/// replaced.
std::string json_file_text(const nlohmann::ordered_json& json);

/// The value in one line, without a line break.
std::string json_line(const nlohmann::ordered_json& json);

/// The whole text of a small file. Throws Error(input) when it is missing or larger than
/// `max_bytes`.
std::string read_text_file(const std::filesystem::path& path, std::size_t max_bytes);

/// True for NaN and Infinity, in any spelling that programs write: "-inf", "nan".
bool is_not_finite(std::string_view word);

// Distinguishes the JSON formats by their structure: the keys of the outermost object, or of the
// first object in the outermost list. All readers that are chosen by content ask this function.

enum class JsonKind {
  none,          ///< the text does not begin like a JSON object or list
  other,         ///< another object
  cameras,       ///< a list: cameras.json
  camera_path,   ///< a list whose first entry has a "time"
  transforms,    ///< an object with "frames": transforms.json
  sog,           ///< an object with "means" and "quats"
  streamed_sog,  ///< an object with "filenames" and "tree"
  gltf,          ///< an object with "asset" and "meshes"
  instances      ///< an object with "scene" and "instances"
};

/// The text may be the beginning of a file. Values, nested keys and keys in strings do not count.
JsonKind json_kind(std::string_view text);

}  // namespace qs
