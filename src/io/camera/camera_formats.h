// SPDX-License-Identifier: MIT
//
// The formats of dataset cameras that read_cameras() accepts; camera_formats.cpp has one row per
// format. A data set is identified by the file `place`; for a folder, the first existing one of
// these files is read. To add a format: write NAME.cpp with a read function, declare it here, add
// the row and a test that reads the same cameras from it and from cameras.json.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/mat3x3.hpp>

#include "base/error.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/cameras.h"
#include "io/camera/lens.h"

namespace qs {

struct CameraFormat {
  const char* name;
  const char* place;  ///< the identifying file, relative to the data set's folder
  // It is recognised by the name of the file, by the kind of JSON, or by the first tag of XML.
  std::array<std::string_view, 2> names;
  std::array<JsonKind, 2> kinds;
  std::string_view root;
  CameraSet (*read)(const std::filesystem::path& file);  ///< throws Error(input)
};

/// In search order.
std::span<const CameraFormat> camera_formats();

/// Larger JSON files of cameras are refused.
inline constexpr std::size_t kMaxCameraFileBytes = std::size_t{256} << 20;

/// INRIA's cameras.json: a list.

CameraSet read_cameras_json(const std::filesystem::path& file);

/// COLMAP's images.bin or images.txt (or cameras.*) with its sibling, sorted by image name because
/// COLMAP writes images in arbitrary order.

CameraSet read_colmap_binary(const std::filesystem::path& file);
CameraSet read_colmap_text(const std::filesystem::path& file);

/// The number of photographs of COLMAP's images.bin or images.txt; 0 if it cannot be read.
std::size_t count_colmap_images(const std::filesystem::path& file);

/// NeRF's transforms.json: an object with "frames".

CameraSet read_transforms_json(const std::filesystem::path& file);

/// Metashape's export of cameras as XML: a document with a chunk.

CameraSet read_metashape_xml(const std::filesystem::path& file);

/// Adds the camera that make() returns. One that is not finite is left out, and its sentence gets
/// the photograph's name.
template <class Make>
void add_camera(CameraSet& set, const std::string& photograph, const Make& make) {
  try {
    set.cameras.push_back(make());
  } catch (const NotFinite& error) {
    set.left_out.push_back(fmt::format("{} ({})", error.what(), photograph));
  }
}

// Lenses in JSON files; lens_json.cpp has the keys.

/// A frame's values, with the file's values as defaults.
struct FrameEntry {
  const JsonEntry frame, file;

  const JsonEntry& with(const char* key) const { return frame.has(key) ? frame : file; }
  bool has(const char* key) const { return with(key).has(key); }
  double number(const char* key) const { return with(key).number(key); }
};

/// The model and the coefficients of a frame of transforms.json. Throws Error(input) for lenses
/// that are not known, and for keys that contradict each other.
Lens lens_of_transforms(const FrameEntry& frame);

/// The lens of a camera of cameras.json, for a camera of this size in pixels; unset: it has none.
/// Throws Error(input).
std::optional<Lens> lens_of_cameras_json(const JsonEntry& camera, glm::dvec2 size);

/// The object that lens_of_cameras_json() reads; `camera` has a lens.
nlohmann::json lens_json(const LensCamera& camera);

/// The name without its extension if the extension is a picture format's, else the whole name.
std::string photograph_name(const std::string& file_name);

/// Deviation of the matrix from a rotation: the largest deviation of its product with its transpose
/// from the identity, and of its determinant from 1. Files are accepted up to kMaxRotationError.
double rotation_error(const glm::dmat3& matrix);
inline constexpr double kMaxRotationError = 1e-3;

/// Throws NotFinite "WHERE: ..." for a camera whose values are too large for single precision.
void check_camera(const Camera& camera, const std::string& where);

}  // namespace qs
