// SPDX-License-Identifier: MIT
#include "learn/run/data_files.h"

#include <algorithm>
#include <utility>

#include "base/fail.h"
#include "base/list_of.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/camera/camera_formats.h"
#include "io/camera/photographs.h"

namespace qs::train {
namespace {

namespace fs = std::filesystem;

// A file of Blender's data sets. Names have the photographs' folders.
CameraSet blender_cameras(const fs::path& file) {
  CameraSet set = read_camera_set(file);
  for (LensCamera& camera : set.cameras)
    camera.camera.name = photograph_name(path_of(camera.photograph).generic_string());
  sort_by_name(set.cameras);
  return set;
}

// Sets `set` and `first_test`.
void read_cameras_of(const fs::path& data, DataFiles& files) {
  const fs::path train = data / "transforms_train.json", test = data / "transforms_test.json";
  CameraSet& set = files.set;
  if (!is_file(train)) {
    set = read_camera_set(data);
    sort_by_name(set.cameras);
  } else {
    set = blender_cameras(train);
    files.first_test = set.cameras.size();
    if (is_file(test)) {
      const CameraSet more = blender_cameras(test);
      set.cameras.insert(set.cameras.end(), more.cameras.begin(), more.cameras.end());
      set.left_out.insert(set.left_out.end(), more.left_out.begin(), more.left_out.end());
      set.warnings.insert(set.warnings.end(), more.warnings.begin(), more.warnings.end());
    }
  }
  for (const fs::path& unused : {data / "transforms_val.json", set.folder() / "test.txt"})
    if (is_file(unused)) set.warnings.push_back(unused.string() + ": is not used");
}

// The folder above `sparse` if the folder is `sparse` or a model in it; else empty.
fs::path above_sparse(const fs::path& folder) {
  fs::path above = (folder / "").lexically_normal().parent_path();
  if (above.parent_path().filename() == "sparse") above = above.parent_path();
  if (above.filename() != "sparse") return {};
  return above.has_parent_path() ? above.parent_path() : ".";
}

bool none_exists(const std::vector<fs::path>& files) {
  return std::ranges::all_of(files, [](const fs::path& file) { return file.empty(); });
}

// The folder `given` in the data set, or where the program runs; if it is empty, `usual` in the
// data set, or `otherwise` if that is missing.
fs::path folder_of(const DataFiles& files, const fs::path& given, const char* usual,
                   const fs::path& otherwise) {
  const fs::path folder = files.folder / (given.empty() ? usual : given);
  if (given.empty()) return is_folder(folder) ? folder : otherwise;
  return !is_folder(folder) && is_folder(given) ? given : folder;
}

bool names_photographs_by_path(const CameraSet& set) { return set.file.extension() == ".json"; }

fs::path photographs_folder(const fs::path& images, const DataFiles& files) {
  const fs::path folder = folder_of(files, images, "images", files.folder);
  if (!images.empty() || !names_photographs_by_path(files.set)) return folder;
  return shared_folder(photograph_names(files.set.cameras), files.set.folder()).value_or(folder);
}

// Sets `photographs_folder`, `photographs`, and what is said about them.
void find_photographs_of(const fs::path& images, DataFiles& files) {
  const CameraSet& set = files.set;
  const std::vector<std::string> names = photograph_names(set.cameras);
  const fs::path& folder = files.photographs_folder = photographs_folder(images, files);
  const Photographs pictures(folder);
  fs::path from;  // a folder that the user names has all photographs
  if (images.empty()) from = names_photographs_by_path(set) ? set.folder() : folder;
  const bool has_faces = std::ranges::any_of(set.cameras, &LensCamera::is_face);
  files.photographs = find_pictures(names, from, pictures, has_faces);
  if (none_exists(files.photographs)) {
    const std::vector<fs::path> others = pictures.files();
    fail(
        "{}: holds no photograph named like one of the {} cameras of {}, such as {}; it has {}: "
        "name the folder with --images",
        folder.string(), names.size(), set.file.string(),
        names.front().empty() ? "one without a name" : names.front(),
        others.empty() ? "no picture" : path_in(others.front(), folder).string());
  }
  if (images.empty()) add_new(files.warnings, other_folder_sentence(names, files.photographs));
  add_new(files.warnings, orientation_sentence(set.cameras, files.photographs));
  files.left_out = left_out_of(set, files.photographs, pictures);
}

// Masks that the cameras file names. Photographs may share one.
void find_named_masks(DataFiles& files) {
  const CameraSet& set = files.set;
  const auto names = list_of<std::string>(set.cameras, &LensCamera::mask);
  std::vector<std::string> given = names;
  std::erase(given, "");
  const Photographs pictures(shared_folder(given, set.folder()).value_or(set.folder()));
  files.masks = find_pictures(names, set.folder(), pictures, true);
  if (none_exists(files.masks))
    fail("{}: none of the masks that it names exists, such as {}", set.file.string(), given[0]);
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i].empty() || !files.masks[i].empty()) continue;
    files.warnings.push_back(fmt::format("{}: there is no mask {}, which it names for {}",
                                         set.file.string(), names[i], set.cameras[i].camera.name));
    break;
  }
}

// Masks of a folder: NAME.jpg.png or NAME.png.
void find_masks_in(const fs::path& folder, DataFiles& files) {
  const Photographs pictures(folder);
  for (const char* ending : {".png", ""}) {
    std::vector<std::string> names(files.masks.size());  // of photographs without a mask so far
    for (std::size_t i = 0; i < names.size(); ++i)
      if (const fs::path& file = files.photographs[i]; !file.empty() && files.masks[i].empty())
        names[i] = path_in(file, files.photographs_folder).generic_string() + ending;
    const auto found = find_pictures(names, {}, pictures);
    for (std::size_t i = 0; i < names.size(); ++i)
      if (!found[i].empty()) files.masks[i] = found[i];
  }
}

// Sets `masks`. Returns what is said about them.
std::string find_masks_of(const fs::path& masks, DataFiles& files) {
  const CameraSet& set = files.set;
  std::string place = "as " + set.file.filename().string() + " names them";
  const bool are_named = std::ranges::any_of(
      set.cameras, [](const LensCamera& camera) { return !camera.mask.empty(); });
  if (masks.empty() && are_named) {
    find_named_masks(files);
  } else {
    const fs::path folder = folder_of(files, masks, "masks", {});
    files.masks.resize(set.cameras.size());
    if (folder.empty()) return "no masks";
    find_masks_in(folder, files);
    if (none_exists(files.masks) && !masks.empty())
      fail("{}: holds no mask named like one of the photographs of {}", folder.string(),
           files.photographs_folder.string());
    if (none_exists(files.masks))
      return fmt::format("no masks, because {} has none that is named like a photograph",
                         folder.string());
    place = "in " + folder.string();
  }
  std::size_t views = 0, covered = 0;
  for (std::size_t i = 0; i < files.masks.size(); ++i) {
    views += files.photographs[i].empty() ? 0 : 1;
    covered += files.photographs[i].empty() || files.masks[i].empty() ? 0 : 1;
  }
  return covered == views
             ? fmt::format("{} {}", counted(covered, "mask"), place)
             : fmt::format("masks of {} of {} photographs {}, the others count as a whole", covered,
                           views, place);
}

fs::path find_points_of(DataFiles& files) {
  const CameraSet& set = files.set;
  if (!set.points.empty()) {
    if (const auto file = file_at(set.folder(), set.points)) return *file;
    files.warnings.push_back(fmt::format("{}: there is no file of points {}, which it names",
                                         set.file.string(), set.points));
  }
  const fs::path model = names_photographs_by_path(set) ? files.folder / "sparse/0" : set.folder();
  return find_points_file(model, files.folder).value_or(fs::path());
}

}  // namespace

DataFiles find_data_files(const fs::path& data, const fs::path& images, const fs::path& masks) {
  DataFiles files;
  files.folder = is_file(data) ? data.parent_path() : data;
  read_cameras_of(data, files);
  if (files.set.cameras.empty()) fail("{}: has no cameras", files.set.file.string());
  files.warnings = files.set.sentences();
  if (const fs::path above = above_sparse(files.folder);
      !above.empty() && Photographs(files.folder).files().empty() &&
      (images.empty() || !is_folder(files.folder / images))) {
    files.warnings.push_back(
        fmt::format("{}: a COLMAP model without photographs; its data set is {}",
                    files.folder.string(), above.string()));
    files.folder = above;
  }
  find_photographs_of(images, files);
  files.used_masks = find_masks_of(masks, files);
  files.points = find_points_of(files);
  std::erase(files.warnings, "");
  return files;
}

}  // namespace qs::train
