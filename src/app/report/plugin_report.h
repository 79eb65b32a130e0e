// SPDX-License-Identifier: MIT
//
// The plugins of a benchmark in the environment of its report:
//   "plugins": ["`own`: a description (libown.so, crc32:89abcdef). Its times are ..."],
//   "plugin_problems": ["plush, camera 3: plugin own: crashed with signal 11 while rendering"]
// Reports without plugins have neither. A merged report has every line of its parts once.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace qs {

/// The sentence below the tables that defines the timed part of a plugin's frame.
inline constexpr const char* kTimingScope =
    "Times of plugins, as those of the modes, are from the camera's arrival to the finished image "
    "in "
    "the renderer's memory (on its device). Reading and uploading the scene and copying the image "
    "to the host are not included";

struct PluginFacts {
  std::string name, description;
  std::string file;  ///< name and hash of the library
  bool measures_itself = false;
  bool on_device = false;  ///< its scene and image are in CUDA's memory
  std::string scene;       ///< scene on which call_factor was measured
  double call_factor = 1;  ///< time of its calls by the host's clock / its own times
};

/// One line of "plugins".
std::string plugin_line(const PluginFacts& facts);

/// Appends a line to the list `key` of an environment unless it has it.
void add_line(nlohmann::ordered_json& environment, const char* key, const std::string& line);

/// The lines below the tables: the scope, the plugins, and a list of the problems. Markdown; empty
/// without plugins.
std::string plugin_markdown(const nlohmann::ordered_json& environment);

/// Sets both lists of a merged report from the environments of its parts.
void merge_plugins(const std::vector<nlohmann::ordered_json>& parts,
                   nlohmann::ordered_json& environment);

}  // namespace qs
