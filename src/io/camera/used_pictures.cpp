// SPDX-License-Identifier: MIT
//
// The sentences about the data that a command uses and leaves out.
#include <algorithm>
#include <span>

#include <fmt/format.h>

#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/camera/photographs.h"
#include "io/picture/image_file.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

// "1 camera without a photograph (b)": at most three names.
std::string counted_names(const std::vector<std::string>& names, const char* thing,
                          const char* what) {
  constexpr std::size_t kMost = 3;
  const std::size_t shown = std::min(names.size(), kMost);
  return fmt::format("{} {} ({}{})", counted(names.size(), thing), what,
                     joined(std::span(names).first(shown), ", "),
                     names.size() > shown ? ", .." : "");
}

// "FOV, undistorted": the lens of a camera, and the views that replace it.
std::string kind_of(const LensCamera& camera) {
  if (!camera.lens) return "pinhole";
  const std::string model(camera.lens->model->name);
  if (camera.is_face()) return "faces of " + model;
  return model + (camera.lens->face == kAllFaces ? ", divided into faces" : ", undistorted");
}

// "2 pinhole; 3 FOV, undistorted, 97 % of a photograph used": the share is the first camera's.
std::string lenses_of(const std::vector<LensCamera>& cameras) {
  struct Kind {
    std::string name;
    std::size_t count;
    const LensCamera* first;
  };
  std::vector<Kind> kinds;
  for (const LensCamera& camera : cameras) {
    const std::string name = kind_of(camera);
    const auto known = std::ranges::find(kinds, name, &Kind::name);
    if (known == kinds.end())
      kinds.push_back({name, 1, &camera});
    else
      ++known->count;
  }
  std::vector<std::string> parts;
  for (auto& [name, count, first] : kinds) {
    if (first->lens && first->lens->face == kAllFaces)
      name = fmt::format("{}, {} each", first->lens->model->name,
                         counted(views_of(*first).size(), "face"));
    if (first->lens && !first->is_face())
      name += fmt::format(", {:.0f} % of a photograph used", 100 * used_share(*first));
    parts.push_back(kinds.size() > 1 ? fmt::format("{} {}", count, name) : name);
  }
  return joined(parts, "; ");
}

}  // namespace

std::string cameras_sentence(const CameraSet& set) {
  return fmt::format("{} in {} ({})", counted(set.cameras.size() + set.left_out.size(), "camera"),
                     set.file.string(), lenses_of(set.cameras));
}

std::string used_sentence(const CameraSet& set, std::size_t used, const fs::path& photographs) {
  return fmt::format("{} of {}, photographs in {}", used, cameras_sentence(set),
                     photographs.string());
}

std::vector<std::string> left_out_of(const CameraSet& set, const std::vector<fs::path>& used,
                                     const Photographs& photographs) {
  const std::vector<std::string> names = photograph_names(set.cameras);
  const fs::path folder = photographs.folder();
  std::vector<std::string> missing, unused, parts;
  std::set<fs::path> known;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (used[i].empty())
      missing.push_back(names[i].empty() ? "without a name" : names[i]);
    else
      known.insert(path_in(used[i], folder));
  }
  for (const fs::path& file : photographs.files())
    if (const fs::path path = path_in(file, folder); !known.contains(path))
      unused.push_back(path.generic_string());
  if (!missing.empty()) parts.push_back(counted_names(missing, "camera", "without a photograph"));
  if (!set.left_out.empty())
    parts.push_back(counted(set.left_out.size(), "camera") +
                    " with numbers that are not finite or too large");
  if (!unused.empty()) parts.push_back(counted_names(unused, "photograph", "without a camera"));
  return parts;
}

std::string other_folder_sentence(const std::vector<std::string>& names,
                                  const std::vector<fs::path>& used) {
  std::vector<std::string> others;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const fs::path wanted = path_of(names[i]).parent_path().filename();
    const fs::path found = used[i].parent_path().filename();
    if (!used[i].empty() && !wanted.empty() && wanted != found &&
        lower_case(wanted.string()) != lower_case(found.string()))
      others.push_back(names[i] + " is " + used[i].string());
  }
  return others.empty() ? ""
                        : counted_names(others, "photograph", "found by the file's name alone");
}

std::string orientation_sentence(const std::vector<LensCamera>& cameras,
                                 const std::vector<fs::path>& photographs) {
  constexpr int kFirstWithSwappedSides = 5;
  std::size_t count = 0;
  std::string first;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const int orientation = photographs[i].empty() ? 1 : exif_orientation(photographs[i]);
    const Camera& camera = cameras[i].camera;
    // Other shapes show if the camera is of the stored picture; require_same_shape() compares them.
    const bool has_shape_of_both =
        orientation < kFirstWithSwappedSides || camera.width == camera.height;
    if (orientation == 1 || !has_shape_of_both) continue;
    if (++count == 1)
      first =
          fmt::format("{}: its EXIF tag Orientation is {}", photographs[i].string(), orientation);
  }
  if (count == 0) return "";
  return fmt::format(
      "{}{}, but pixels are used as they are stored; if the cameras are of turned pictures, turn "
      "the pixels first (mogrify -auto-orient)",
      first, count > 1 ? fmt::format(", as of {} photographs in all", count) : "");
}

std::string skipped_sentence(std::size_t views) {
  return fmt::format("{} view{} without a photograph {} left out", views, views == 1 ? "" : "s",
                     views == 1 ? "is" : "are");
}

}  // namespace qs
