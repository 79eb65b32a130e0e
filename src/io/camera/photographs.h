// SPDX-License-Identifier: MIT
//
// Finds the photographs of cameras, and masks, by their names in files of cameras, and reads them.
// docs/training.md has the rules as a table. Everything that looks for a picture of a camera calls
// find_pictures() or Photographs::match().
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/parallel.h"
#include "io/camera/cameras.h"
#include "io/camera/lens.h"
#include "raster/scene/camera.h"
#include "raster/scene/image.h"

namespace qs {

/// The pictures in a folder and its subfolders. Links to folders are followed, every folder is
/// listed once. Hidden files and folders are left out, and subfolders that are named as masks,
/// depth maps and normals are.
class Photographs {
 public:
  /// Lists the folder without reading pictures. Throws Error(input) if it is not a folder.
  /// `counted` receives the number of pictures so far.
  explicit Photographs(const std::filesystem::path& folder,
                       const std::function<void(std::size_t count)>& counted = {});

  /// The picture that a name stands for.
  struct Match {
    std::filesystem::path file;
    bool by_name_alone = false;  ///< the folders of the picture and of the name differ
  };

  /// Throws Error(input) if two pictures match the name equally well.
  std::optional<Match> match(const std::string& name) const;

  /// The file of match().
  std::optional<std::filesystem::path> find(const std::string& name) const;

  const std::filesystem::path& folder() const { return folder_; }

  /// Paths in the folder without endings, in alphabetical order.
  std::vector<std::string> names() const;

  /// All files.
  std::vector<std::filesystem::path> files() const;

 private:
  std::filesystem::path folder_;
  std::set<std::string> files_;                      // paths in the folder
  std::multimap<std::string, std::string> by_name_;  // key: file name in lower case, no ending
  std::set<std::string, std::less<>> folders_;       // names of the subfolders, in lower case
};

/// A name in a file of cameras as a path, with `/` for every `\`, the separator of Windows.
std::filesystem::path path_of(const std::string& name);

/// The folder whose pictures the names stand for: the first folder that all names share, below
/// `from`; nullopt if they share none or it does not exist.
std::optional<std::filesystem::path> shared_folder(const std::vector<std::string>& names,
                                                   const std::filesystem::path& from);

/// The file at the path, with `\` read as `/` if there is no file with `\` in its name.
std::optional<std::filesystem::path> file_at(const std::filesystem::path& from,
                                             const std::string& name);

/// The path from the folder on, by the names alone: links are not resolved.
std::filesystem::path path_in(const std::filesystem::path& file,
                              const std::filesystem::path& folder);

/// The file of a picture at a path from the folder `from`; other endings and spellings count.
std::optional<std::filesystem::path> picture_at(const std::filesystem::path& from,
                                                const std::string& name);

/// The picture of every name, empty if it has none. Paths count from the folder `from` first, then
/// `pictures` is searched; with `from` empty only `pictures`. Throws Error(input) if two names have
/// the same picture, unless they may share it.
std::vector<std::filesystem::path> find_pictures(const std::vector<std::string>& names,
                                                 const std::filesystem::path& from,
                                                 const Photographs& pictures,
                                                 bool may_share = false);

/// The names of photographs in the cameras file.
std::vector<std::string> photograph_names(const std::vector<LensCamera>& cameras);

// One line names the data that a command uses.

/// "9 cameras in transforms.json (pinhole)".
std::string cameras_sentence(const CameraSet& set);

/// "8 of 9 cameras in transforms.json (pinhole), photographs in images".
std::string used_sentence(const CameraSet& set, std::size_t used,
                          const std::filesystem::path& photographs);

/// The cameras and photographs that are left out, and why: "1 camera without a photograph (b)".
/// `used` has the photograph of every camera.
std::vector<std::string> left_out_of(const CameraSet& set,
                                     const std::vector<std::filesystem::path>& used,
                                     const Photographs& photographs);

/// A warning about pictures in other folders than their names say: "1 photograph found by the
/// file's name alone (cam0/1.jpg is cam1/1.jpg)", or "".
std::string other_folder_sentence(const std::vector<std::string>& names,
                                  const std::vector<std::filesystem::path>& used);

/// A warning if photographs have an EXIF orientation that may be their cameras' or not; else "".
std::string orientation_sentence(const std::vector<LensCamera>& cameras,
                                 const std::vector<std::filesystem::path>& photographs);

/// "3 views without a photograph are left out".
std::string skipped_sentence(std::size_t views);

/// Reads a photograph as RGB, blended over the background where it is transparent. It has the shape
/// of its camera's image if the camera has a size. Throws Error(input).
Image read_as_taken(const std::filesystem::path& path, glm::vec3 background,
                    const LensCamera& taken);

/// read_as_taken(), undistorted if `taken` has a lens, and area-averaged to 1 / `divisor` of its
/// size, rounded. Throws Error.
Image read_photograph(const std::filesystem::path& path, glm::vec3 background, int divisor,
                      ThreadPool& pool, const LensCamera& taken = {});

/// The photograph area-averaged to 1 / `divisor` of its size, rounded.
Image divided(const Image& photograph, int divisor, ThreadPool& pool);

/// A photograph may be smaller or larger than its camera's image, but must have its aspect ratio,
/// up to rounded sizes. Otherwise it was cropped or rotated: throws Error(input) naming `path`.
void require_same_shape(const Image& photograph, const std::filesystem::path& path,
                        glm::dvec2 camera_size);

/// The photograph without the distortion of its lens: every pixel is interpolated at the point at
/// which the lens shows its direction, and is 0 if there is none. Interpolation is linear, and in
/// faces bicubic (Catmull-Rom), so that values can exceed the photograph's range by a little; a
/// pixel of a face that covers several pixels of the photograph is the mean of several points. The
/// size is the camera's, scaled as the photograph is to the lens's size.
Image undistorted(const Image& photograph, const LensCamera& camera, ThreadPool& pool);

/// A value per pixel of the undistorted photograph at this size, row by row: 1 if the photograph
/// shows the whole pixel, with all pixels from which a face is interpolated, else 0; empty if it
/// shows all pixels.
std::vector<std::uint8_t> lens_mask(const LensCamera& camera, int width, int height,
                                    ThreadPool& pool);

}  // namespace qs
