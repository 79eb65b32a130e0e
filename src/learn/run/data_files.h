// SPDX-License-Identifier: MIT
//
// Chooses the files of a data set before any picture is read: the photograph and the mask of every
// camera, and the points. docs/training.md has the rules.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/camera/cameras.h"

namespace qs::train {

struct DataFiles {
  std::filesystem::path folder;  ///< of the data set
  CameraSet set;                 ///< its cameras, by name
  /// of Blender's data sets: the index of the first test camera; training cameras are before it
  std::optional<std::size_t> first_test;
  std::filesystem::path photographs_folder;
  std::vector<std::filesystem::path> photographs, masks;  ///< of every camera; empty: it has none
  std::filesystem::path points;                           ///< empty: none
  std::string used_masks;                                 ///< a part of a sentence
  std::vector<std::string> left_out;                      ///< and why: parts of a sentence
  std::vector<std::string> warnings;                      ///< sentences
};

/// `data` is the folder of a data set, or a file of cameras in it. `images` and `masks` are folders
/// in it, or empty, see DataOptions. Throws Error(input) if no camera has a photograph, or if two
/// files or cameras cannot be told apart.
DataFiles find_data_files(const std::filesystem::path& data, const std::filesystem::path& images,
                          const std::filesystem::path& masks);

}  // namespace qs::train
