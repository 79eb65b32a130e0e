// SPDX-License-Identifier: MIT
//
// The scene to which a file of edits or of measures belongs.
#pragma once

#include <cstdint>
#include <string>

namespace qs {

/// A scene as its file was read.
struct EditedScene {
  std::string name, hash;  ///< of the file; hash: see file_hash()
  std::uint64_t bytes = 0, gaussians = 0;
  std::string axes;
};

}  // namespace qs
