// SPDX-License-Identifier: MIT
//
// Distinguishes the JSON formats by their structure: the keys of the outermost object, or of the
// first object in the outermost list. All readers that are chosen by content ask this function.
#pragma once

#include <string_view>

namespace qs {

enum class JsonKind {
  none,          ///< the text does not begin like a JSON object or list
  other,         ///< another object
  cameras,       ///< a list: cameras.json
  camera_path,   ///< a list whose first entry has a "time"
  transforms,    ///< an object with "frames": transforms.json
  sog,           ///< an object with "means" and "quats"
  streamed_sog,  ///< an object with "filenames" and "tree"
  gltf           ///< an object with "asset" and "meshes"
};

/// The text may be the beginning of a file. Values, nested keys and keys in strings do not count.
JsonKind json_kind(std::string_view text);

}  // namespace qs
