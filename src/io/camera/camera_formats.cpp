// SPDX-License-Identifier: MIT
#include "io/camera/camera_formats.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <span>
#include <system_error>
#include <utility>

#include <glm/common.hpp>
#include <glm/matrix.hpp>
#include <glm/vector_relational.hpp>

#include "base/fail.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/mapped_file.h"
#include "io/camera/cameras.h"
#include "io/camera/lens_views.h"

namespace qs {

namespace {

// The "frames" of transforms.json may follow after the first bytes of the file.
constexpr std::array kFormats = {
    CameraFormat{"cameras.json",
                 "cameras.json",
                 {},
                 {JsonKind::cameras, JsonKind::camera_path},
                 "",
                 read_cameras_json},
    CameraFormat{"COLMAP binary",
                 "sparse/0/images.bin",
                 {"images.bin", "cameras.bin"},
                 {},
                 "",
                 read_colmap_binary},
    CameraFormat{"COLMAP text",
                 "sparse/0/images.txt",
                 {"images.txt", "cameras.txt"},
                 {},
                 "",
                 read_colmap_text},
    CameraFormat{"transforms.json",
                 "transforms.json",
                 {},
                 {JsonKind::transforms, JsonKind::other},
                 "",
                 read_transforms_json},
    CameraFormat{"Metashape XML", "cameras.xml", {}, {}, "<document", read_metashape_xml},
};

template <class Value>
bool holds(const std::array<Value, 2>& values, const Value& value) {
  return std::ranges::find(values, value) != values.end();
}

constexpr std::size_t kStartBytes = 4096;  // that tell the kind of a JSON file

// A COLMAP model: its images.bin or images.txt.
struct ColmapFolder {
  std::filesystem::path file;
  std::size_t photographs;
};

// Adds the models in the folder's subfolders, by name, and its own. COLMAP numbers models.
void add_models(const std::filesystem::path& folder, bool only_numbered,
                std::vector<ColmapFolder>& models) {
  std::error_code error;
  std::vector<std::filesystem::path> parts;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (!only_numbered ||
        entry.path().filename().string().find_first_not_of("0123456789") == std::string::npos)
      parts.push_back(entry.path());
  std::ranges::sort(parts);
  parts.push_back(folder);
  for (const auto& part : parts) {
    const auto file = part / (is_file(part / "images.bin") ? "images.bin" : "images.txt");
    if (is_file(file)) models.push_back({file, count_colmap_images(file)});
  }
}

// The largest model of the folder's `sparse`, or if `own` also of the folder itself. The first of
// equal models counts. A warning names the others.
std::optional<CameraSet> largest_model(const std::filesystem::path& folder, bool own) {
  std::vector<ColmapFolder> models;
  add_models(folder / "sparse", false, models);
  if (own) add_models(folder, true, models);
  const auto largest = std::ranges::max_element(models, {}, &ColmapFolder::photographs);
  if (largest == models.end()) return std::nullopt;
  CameraSet set{largest->file};
  std::vector<std::string> others;
  for (const auto& [file, photographs] : models)
    if (file != largest->file)
      others.push_back(fmt::format("{} has {}", file.parent_path().string(), photographs));
  if (!others.empty())
    set.warnings.push_back(fmt::format(
        "{} is the largest of {} COLMAP models, with {} photographs, and only it is "
        "used: {}",
        set.folder().string(), models.size(), largest->photographs, joined(others, ", ")));
  return set;
}

bool is_colmap(const CameraFormat& format) { return !format.names[0].empty(); }

// The file to read for a folder: the data set's folder, its `sparse`, or one model inside.
CameraSet file_in(const std::filesystem::path& folder) {
  std::vector<CameraSet> found;
  for (const CameraFormat& format : kFormats) {
    if (is_colmap(format)) {
      auto model = largest_model(folder, true);
      if (model && (found.empty() || found.back().file != model->file)) found.push_back(*model);
    } else if (is_file(folder / format.place)) {
      found.push_back({folder / format.place});
    }
  }
  for (std::size_t i = 1; i < found.size(); ++i)
    found[0].warnings.push_back(fmt::format("{}: is not used, because there is {}",
                                            found[i].file.string(), found[0].file.string()));
  if (!found.empty()) return found[0];
  constexpr int kMostLevels = 4;  // dense/0/sparse/0 is one
  std::error_code error;
  std::string elsewhere;
  const auto options = std::filesystem::directory_options::skip_permission_denied;
  for (auto entry = std::filesystem::recursive_directory_iterator(folder, options, error);
       !error && entry != std::filesystem::recursive_directory_iterator(); entry.increment(error)) {
    if (entry.depth() >= kMostLevels) entry.disable_recursion_pending();
    const std::filesystem::path& file = entry->path();
    const bool is_place = std::ranges::any_of(kFormats, [&](const CameraFormat& format) {
      return file.filename() == std::filesystem::path(format.place).filename();
    });
    if (!is_place) continue;
    elsewhere = fmt::format("; {} is one, further below", file.string());
    break;
  }
  fail(
      "{}: a folder without cameras.json, COLMAP's images.bin or images.txt, transforms.json, or "
      "Metashape's cameras.xml{}",
      folder.string(), elsewhere);
}

// Sentences about intrinsics that files rarely mean.
void warn_of_odd_intrinsics(CameraSet& set) {
  const auto warn = [&](const char* what, const char* oddity, const auto& is_odd) {
    const auto odd = std::ranges::count_if(set.cameras, is_odd, &LensCamera::camera);
    if (odd == 0) return;
    set.warnings.push_back(fmt::format(
        "{}: the {} of {} are {} of the picture: are they of another size, or shares of it?",
        set.file.string(), what, counted(static_cast<std::size_t>(odd), "camera"), oddity));
  };
  const auto sides = [](const Camera& camera) { return glm::dvec2(camera.width, camera.height); };
  warn("principal points", "far from the middle", [&](const Camera& camera) {
    const glm::dvec2 offset = camera.center_px - 0.5 * (sides(camera) - 1.0);
    return glm::any(glm::greaterThan(glm::abs(offset), 0.25 * sides(camera)));
  });
  warn("focal lengths", "less than a fiftieth", [&](const Camera& camera) {
    return glm::any(glm::lessThan(camera.focal_px, 0.02 * sides(camera)));
  });
}

// The first result of look(folder) for the folder of the file and up to three folders above.
template <class Look>
std::optional<std::filesystem::path> find_beside(const std::filesystem::path& scene_file,
                                                 const Look& look) {
  std::error_code error;
  std::filesystem::path folder =
      std::filesystem::absolute(scene_file, error).lexically_normal().parent_path();
  for (int level = 0; level <= 3; ++level) {
    if (const std::optional<std::filesystem::path> found = look(folder)) return found;
    if (folder == folder.parent_path()) break;
    folder = folder.parent_path();
  }
  return std::nullopt;
}

std::optional<std::filesystem::path> find_beside(const std::filesystem::path& scene_file,
                                                 const char* name) {
  return find_beside(scene_file, [&](const auto& folder) {
    return is_file(folder / name) ? std::optional(folder / name) : std::nullopt;
  });
}

}  // namespace

std::span<const CameraFormat> camera_formats() { return kFormats; }

std::vector<Camera> read_cameras(const std::filesystem::path& path) {
  return pinhole_cameras(read_camera_set(path).cameras);
}

std::vector<std::string> CameraSet::sentences() const {
  constexpr std::size_t kMost = 3;
  std::vector<std::string> all = warnings;
  const std::size_t shown = std::min(left_out.size(), kMost);
  for (const std::string& sentence : std::span(left_out).first(shown))
    all.push_back(sentence + "; this camera is left out");
  if (left_out.size() > shown)
    all.push_back(fmt::format("{}: {} in all are left out, because their numbers are not finite",
                              file.string(), counted(left_out.size(), "camera")));
  return all;
}

std::vector<std::string> CameraSet::pinhole_sentences() const {
  std::vector<std::string> all = sentences();
  const auto is_wide = [](const LensCamera& camera) {
    return camera.lens && camera.lens->face == kAllFaces;
  };
  const auto first = std::ranges::find_if(cameras, is_wide);
  if (first != cameras.end())
    all.push_back(
        fmt::format("{}: {} of {} cameras have lenses too wide for a pinhole camera: their front "
                    "faces are used, but for render --camera-index N (the lens of the first: "
                    "--lens {})",
                    file.string(), std::ranges::count_if(cameras, is_wide), cameras.size(),
                    photograph_view(*first->lens).text));
  return all;
}

CameraSet read_camera_set(const std::filesystem::path& path) {
  if (!is_there(path)) fail("{}: cannot be read: no such file", path.string());
  const CameraSet found = is_folder(path) ? file_in(path) : CameraSet{path};
  const std::filesystem::path& file = found.file;
  const MappedFile mapped(file);
  const std::string_view start = without_mark(text_of(mapped.content())).substr(0, kStartBytes);
  const JsonKind kind = json_kind(start);
  const std::string name = file.filename().string();
  const auto format = std::ranges::find_if(kFormats, [&](const CameraFormat& row) {
    return holds(row.names, std::string_view(name)) ||
           (kind != JsonKind::none && holds(row.kinds, kind)) ||
           (start.starts_with('<') && !row.root.empty() &&
            start.find(row.root) != std::string_view::npos);
  });
  if (format == kFormats.end() && kind == JsonKind::none)
    fail(
        "{}: not a file of cameras: these are cameras.json, transforms.json, images.bin and "
        "images.txt of COLMAP, and Metashape's XML",
        file.string());
  // Another file is passed to the reader of cameras.json, whose message names the defect.
  CameraSet read = format == kFormats.end() ? read_cameras_json(file) : format->read(file);
  CameraSet set = read;
  set.file = file;
  set.warnings.insert(set.warnings.begin(), found.warnings.begin(), found.warnings.end());
  set.cameras.clear();
  for (std::size_t i = 0; i < read.cameras.size(); ++i) {
    LensCamera& camera = read.cameras[i];
    add_camera(set, camera.camera.name, [&] {
      check_camera(camera.camera, fmt::format("{}: camera {}", file.string(), i));
      return std::move(camera);
    });
  }
  if (set.cameras.empty() && !set.left_out.empty()) fail("{}", set.left_out.front());
  warn_of_odd_intrinsics(set);
  return set;
}

std::string photograph_name(const std::string& file_name) {
  const std::size_t dot = file_name.rfind('.');
  if (dot == std::string::npos || dot == 0) return file_name;
  const std::string ending = lower_case(file_name.substr(dot));
  for (const char* known :
       {".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".exr", ".bmp", ".heic", ".ppm", ".pfm"})
    if (ending == known) return file_name.substr(0, dot);
  return file_name;
}

void check_camera(const Camera& camera, const std::string& where) {
  // Frames are computed in single precision, which holds squares up to 3e38.
  constexpr double kMost = 1e15;
  const glm::dvec3 position = camera.position();
  for (const double value : {position.x, position.y, position.z})
    if (!(std::abs(value) <= kMost))
      fail_not_finite("{}: its position {:.4g} is more than {:g} from the origin", where, value,
                      kMost);
  for (const double value : {camera.focal_px.x, camera.focal_px.y, camera.center_px.x,
                             camera.center_px.y, camera.near_depth})
    if (!(std::abs(value) <= kMost))
      fail_not_finite(
          "{}: {:.4g} for its focal length, principal point or near plane is more than {:g}", where,
          value, kMost);
}

double rotation_error(const glm::dmat3& matrix) {
  const glm::dmat3 product = matrix * glm::transpose(matrix);
  double error = std::abs(glm::determinant(matrix) - 1);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) error = std::max(error, std::abs(product[i][k] - (i == k ? 1 : 0)));
  return error;
}

std::optional<std::filesystem::path> find_cameras_file(const std::filesystem::path& scene_file) {
  const auto model = [](const auto& folder) -> std::optional<std::filesystem::path> {
    const auto found = largest_model(folder, false);
    return found ? std::optional(found->file) : std::nullopt;
  };
  for (const CameraFormat& format : camera_formats()) {
    const auto found =
        is_colmap(format) ? find_beside(scene_file, model) : find_beside(scene_file, format.place);
    if (found) return found;
  }
  return std::nullopt;
}

bool model_wants_white_background(const std::filesystem::path& scene_file) {
  constexpr std::size_t kMaxBytes = 1 << 20;
  const auto path = find_beside(scene_file, "cfg_args");
  // A Python Namespace(...) in one line.
  return path &&
         read_text_file(*path, kMaxBytes).find("white_background=True") != std::string::npos;
}

}  // namespace qs
