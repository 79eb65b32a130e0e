// SPDX-License-Identifier: MIT
//
// The formats of dataset cameras that read_cameras() accepts; camera_formats.cpp has one row per
// format. A data set is identified by the file `place`; for a folder, the first existing one of
// these files is read. To add a format: write NAME.cpp with a read function, declare it here, add
// the row and a test that reads the same cameras from it and from cameras.json.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/mat3x3.hpp>

#include "io/bytes/json_text.h"
#include "io/camera/lens.h"

namespace qs {

struct CameraFormat {
  const char* name;
  const char* place;  ///< the identifying file, relative to the data set's folder
  // It is recognised by the name of the file, or by the kind of JSON.
  std::array<std::string_view, 2> names;
  std::array<JsonKind, 2> kinds;
  std::vector<LensCamera> (*read)(const std::filesystem::path& file);  ///< throws Error(input)
};

/// In search order.
std::span<const CameraFormat> camera_formats();

/// Larger JSON files of cameras are refused.
inline constexpr std::size_t kMaxCameraFileBytes = std::size_t{256} << 20;

/// INRIA's cameras.json: a list.

std::vector<LensCamera> read_cameras_json(const std::filesystem::path& file);

/// COLMAP's images.bin or images.txt (or cameras.*) with its sibling, sorted by image name because
/// COLMAP writes images in arbitrary order.

std::vector<LensCamera> read_colmap_binary(const std::filesystem::path& file);
std::vector<LensCamera> read_colmap_text(const std::filesystem::path& file);

/// NeRF's transforms.json: an object with "frames".

std::vector<LensCamera> read_transforms_json(const std::filesystem::path& file);

/// The name without its extension if the extension is a picture format's, else the whole name.
std::string photograph_name(const std::string& file_name);

/// Deviation of the matrix from a rotation: the largest deviation of its product with its transpose
/// from the identity, and of its determinant from 1. Files are accepted up to kMaxRotationError.
double rotation_error(const glm::dmat3& matrix);
inline constexpr double kMaxRotationError = 1e-3;

/// Throws Error(input) "WHERE: ..." for a camera whose values are too large for single precision.
void check_camera(const Camera& camera, const std::string& where);

}  // namespace qs
