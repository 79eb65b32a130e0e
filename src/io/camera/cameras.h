// SPDX-License-Identifier: MIT
//
// Reads dataset cameras: cameras.json, COLMAP (text, binary), transforms.json; see
// camera_formats.h. cameras.json is INRIA's layout: a list of objects with position (camera
// centre), rotation (world_from_view, rows), fx, fy, width, height, img_name. The principal point
// is the picture's centre unless cx, cy are given, which count from pixel corners as in COLMAP: our
// centre is cx - 0.5. A model that was trained from georeferenced photographs has the key "offset"
// in its cameras.json, three numbers: the place in the world from which its positions count.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>
#include <nlohmann/json_fwd.hpp>

#include "io/camera/lens.h"
#include "raster/scene/camera.h"

namespace qs {

/// All cameras of a file or folder (a data set, COLMAP's `sparse` or `sparse/0`), in file order;
/// COLMAP cameras are sorted by name. Throws Error(input) naming file, camera and field.
std::vector<Camera> read_cameras(const std::filesystem::path& path);

/// The cameras of a file. cameras.json has lenses as objects "lens", see lens_json.cpp.
struct CameraSet {
  std::filesystem::path file;  ///< that was read
  std::vector<LensCamera> cameras = {};
  std::vector<std::string> left_out = {};  ///< a sentence for each camera that is not finite
  std::vector<std::string> warnings = {};  ///< sentences about data that is not used
  std::string points = {};                 ///< the file of points as it is named; empty: none

  /// The folder from which paths in the file count.
  std::filesystem::path folder() const { return file.parent_path(); }

  /// `warnings`, and up to three of `left_out` with the number of the others.
  std::vector<std::string> sentences() const;
};

/// As read_cameras(), with lenses and photographs. Of several COLMAP models in `sparse` the one
/// with the most photographs is read. Throws Error(input) if no camera is left.
CameraSet read_camera_set(const std::filesystem::path& path);

/// The cameras file of a scene: cameras.json beside the scene file or in up to three parent
/// folders; else, in the same folders, COLMAP's largest model in sparse, then transforms.json.
std::optional<std::filesystem::path> find_cameras_file(const std::filesystem::path& scene_file);

/// One camera from JSON text: an object in the layout of cameras.json. `source` names it in
/// messages.
Camera parse_camera(std::string_view json, std::string_view source);

/// The camera as one line of JSON that parse_camera() reads back exactly.
std::string format_camera(const Camera& camera);

/// A whole cameras.json.
std::string format_cameras(const std::vector<LensCamera>& cameras);

/// Parts of a larger JSON file: the camera as an object, and the camera from an
/// object.
nlohmann::ordered_json camera_json(const Camera& camera);
Camera camera_of(const nlohmann::ordered_json& object, std::string_view source);

/// True if the model's cfg_args (searched like cameras.json) requests a white background.
bool model_wants_white_background(const std::filesystem::path& scene_file);

// The points from structure from motion that a data set stores beside its cameras: COLMAP's
// points3D.

struct ScenePoint {
  glm::dvec3 position{0};  ///< world, finite
  glm::vec3 color{0};      ///< RGB, 0..1
};

/// The points3D.bin, .txt or .ply of the folder of a COLMAP model or of up to two folders above, up
/// to `data`: points of another model have other coordinates.
std::optional<std::filesystem::path> find_points_file(const std::filesystem::path& model,
                                                      const std::filesystem::path& data);

/// The finite points of a points3D file or of a .ply, in file order. A sentence in `warnings`
/// counts the others. Throws Error(input) naming file and record.
std::vector<ScenePoint> read_points(const std::filesystem::path& file,
                                    std::vector<std::string>& warnings);

/// The points without repetitions: points that are equal in single precision become one point at
/// the place of the first point, with the mean of their colours.
std::vector<ScenePoint> without_repetitions(const std::vector<ScenePoint>& points);

/// The formats, with points that are not finite. They are for read_points().
std::vector<ScenePoint> read_colmap_points_binary(const std::filesystem::path& file);
std::vector<ScenePoint> read_colmap_points_text(const std::filesystem::path& file);
std::vector<ScenePoint> read_ply_points(const std::filesystem::path& file);

}  // namespace qs
