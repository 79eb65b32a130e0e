// SPDX-License-Identifier: MIT
//
// COLMAP's cameras.txt, images.txt and points3D.txt. Lines that begin with # are comments.
//   cameras.txt  ID MODEL WIDTH HEIGHT PARAMETERS...
//   images.txt   two lines each: ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then its points as
//                X Y POINT_ID ..., which may be an empty line and are skipped
//   points3D.txt ID X Y Z R G B, then values that are skipped
//
// COLMAP's cameras.bin, images.bin and points3D.bin, little endian:
//   cameras  u64 count, each: u32 id, i32 model, u64 width, u64 height, f64 per parameter
//   images   u64 count, each: u32 id, f64 quaternion w x y z, f64 translation x y z, u32 camera,
//            name ending with 0, u64 points, each: f64 x, f64 y, u64 point (skipped)
//   points3D u64 count, each: u64 id, f64 x y z, u8 r g b, f64 error, u64 images, each: u32 image,
//            u32 point (skipped)
#include "io/camera/colmap.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <span>
#include <system_error>

#include <glm/gtc/quaternion.hpp>

#include "base/fail.h"
#include "base/not_copied.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/mapped_file.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

constexpr std::uint64_t kMaxSide = 65535;

constexpr std::string_view kSpace = " \t\r";

// One line, split into words; errors name file and line.
class Line {
 public:
  Line(std::string_view text, const std::string& path, std::uint64_t number)
      : rest_(text), path_(path), number_(number) {
    skip_space();
  }

  std::string where() const { return fmt::format("{}: line {}", path_, number_); }
  bool empty() const { return rest_.empty(); }
  bool is_comment() const { return rest_.starts_with('#'); }

  std::string_view word(const char* what) {
    if (rest_.empty()) fail("{}: {} is missing", where(), what);
    const std::size_t end = std::min(rest_.find_first_of(kSpace), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    skip_space();
    return word;
  }

  template <class T>
  T read(const char* what) {
    const std::string_view text = word(what);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
      fail("{}: {} '{}' is not a number", where(), what, text.substr(0, 40));
    return value;
  }

  const LensModel& model() {
    const std::string_view name = word("the model");
    const LensModel* const found = find_lens_model(name);
    if (found == nullptr) fail("{}: there is no camera model '{}'", where(), name.substr(0, 40));
    return *found;
  }

  /// The rest of the line, which may contain spaces: a file name.
  std::string_view all(const char* what) {
    if (rest_.empty()) fail("{}: {} is missing", where(), what);
    return rest_.substr(0, rest_.find_last_not_of(kSpace) + 1);
  }

 private:
  void skip_space() {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
  }

  std::string_view rest_;
  const std::string& path_;
  std::uint64_t number_;
};

class Lines {
 public:
  explicit Lines(const std::filesystem::path& path)
      : file_(path), path_(path.string()), rest_(without_mark(text_of(file_.content()))) {}

  bool at_end() const { return rest_.empty(); }

  Line next() {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    const std::string_view text = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return {text, path_, ++number_};
  }

 private:
  MappedFile file_;
  std::string path_;
  std::string_view rest_;
  std::uint64_t number_ = 0;
};

// Skips the second line of an image. If a file had lost these lines, every other image would be
// skipped silently, so the line is checked.
void skip_points(Line line) {
  int words = 0;
  for (; !line.empty(); ++words) line.word("a point");
  if (words % 3 != 0)
    fail("{}: not a list of points, but every image has such a line, even if empty", line.where());
}

constexpr std::uint64_t kPointBytes = 24;
constexpr std::uint64_t kTrackBytes = 8;

// A file may have millions of records, so nothing is formatted before an error.
class Record : NotCopied {
 public:
  Record(ByteSpan bytes, const std::string& name, std::uint64_t number)
      : name_(name), number_(number), cursor_(bytes, [this] { return where(); }) {}

  std::string where() const { return fmt::format("{} {}", name_, number_); }
  std::uint64_t bytes() const { return cursor_.offset(); }

  template <class T>
  T read(const char* what) {
    return cursor_.read<T>(what);
  }

  const LensModel& model() {
    const auto id = read<std::int32_t>("the model");
    const LensModel* const found = find_lens_model(id);
    if (found == nullptr) fail("{}: there is no camera model {}", where(), id);
    return *found;
  }

  // A number of items, and the items.
  void skip_list(std::uint64_t item_bytes, const char* items) {
    const auto count = read<std::uint64_t>("the number of items");
    if (!fits(count, item_bytes, cursor_.left()))
      fail("{}: cut off: {} {} do not fit into {} bytes", where(), count, items, cursor_.left());
    cursor_.take(count * item_bytes, items);
  }

 private:
  const std::string& name_;
  std::uint64_t number_;
  ByteCursor cursor_;
};

// Calls read(record) for every record of a file that begins with their number.
template <class F>
void for_each_record(const std::filesystem::path& path, const char* kind, F read) {
  const MappedFile file(path);
  ByteCursor header(file.content(), path.string());
  const auto count = header.read<std::uint64_t>("the number of records");
  auto rest = file.content().subspan(header.offset());
  const std::string name = fmt::format("{}: {}", path.string(), kind);
  for (std::uint64_t i = 0; i < count; ++i) {
    Record record(rest, name, i);
    read(record);
    rest = rest.subspan(record.bytes());
  }
  if (!rest.empty())
    fail("{}: {} bytes follow the {} {}s that it announces", path.string(), rest.size(), count,
         kind);
}

}  // namespace

Lens colmap_lens(const ColmapLens& stored, const std::string& where) {
  const auto& [model, width, height, parameters] = stored;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
    fail("{}: a picture of {} x {} pixels is not between 1 x 1 and {} x {}", where, width, height,
         kMaxSide, kMaxSide);
  Lens lens{&model, {width, height}};
  if (model.focal_lengths == 0) {  // a panorama, whose parameters are its sides
    if (parameters[0] != lens.size_px.x || parameters[1] != lens.size_px.y)
      fail("{}: the parameters of {} are {} x {}, but its picture has {} x {} pixels", where,
           model.name, parameters[0], parameters[1], width, height);
    return lens;
  }
  const auto focal_lengths = static_cast<std::size_t>(model.focal_lengths);
  lens.focal_px = {parameters[0], parameters[focal_lengths - 1]};
  lens.center_px = {parameters[focal_lengths] - 0.5, parameters[focal_lengths + 1] - 0.5};
  std::ranges::copy(std::span(parameters).subspan(focal_lengths + 2), lens.coefficients.begin());
  return lens;
}

std::vector<double> colmap_parameters(const Lens& lens) {
  const int focal_lengths = lens.model->focal_lengths;
  if (focal_lengths == 0) return {lens.size_px.x, lens.size_px.y};
  std::vector<double> parameters = {lens.focal_px.x};
  if (focal_lengths == 2) parameters.push_back(lens.focal_px.y);
  parameters.insert(parameters.end(), {lens.center_px.x + 0.5, lens.center_px.y + 0.5});
  parameters.insert(parameters.end(), lens.coefficients.begin(),
                    lens.coefficients.begin() + lens.model->coefficients());
  return parameters;
}

LensCamera colmap_camera(const ColmapLenses& lenses, const ColmapImage& image,
                         const std::string& where) {
  const auto lens = lenses.find(image.lens);
  if (lens == lenses.end()) fail("{}: there is no camera {}", where, image.lens);
  if (lens->second.error) std::rethrow_exception(lens->second.error);
  const double length = glm::length(image.rotation);
  if (!std::isfinite(length) || length < 1e-9)
    fail_not_finite("{}: its quaternion is no rotation", where);
  for (int i = 0; i < 3; ++i)
    if (!std::isfinite(image.translation[i]))
      fail_not_finite("{}: its translation is not finite", where);
  const glm::dmat3 rotation = glm::mat3_cast(image.rotation / length);
  LensCamera result = lens->second.camera;
  result.photograph = image.name;
  Camera& camera = result.camera;
  camera.view_from_world = glm::dmat4x3(rotation[0], rotation[1], rotation[2], image.translation);
  camera.name = photograph_name(image.name);
  return result;
}

CameraSet read_colmap_text(const std::filesystem::path& file) {
  ColmapLenses lenses;
  for (Lines lines(file.parent_path() / "cameras.txt"); !lines.at_end();) {
    Line line = lines.next();
    if (line.empty() || line.is_comment()) continue;
    add_colmap_lens(lenses, line.read<std::uint32_t>("the camera's id"), line.where(), [&] {
      const LensCamera camera =
          lens_camera(colmap_lens(read_colmap_lens(line), line.where()), line.where());
      if (!line.empty()) fail("{}: more parameters than the camera model has", line.where());
      return camera;
    });
  }
  CameraSet set{file};
  for (Lines lines(file.parent_path() / "images.txt"); !lines.at_end();) {
    Line line = lines.next();
    if (line.empty() || line.is_comment()) continue;
    ColmapImage image = read_colmap_image(line);
    image.name = line.all("the name");
    add_camera(set, image.name, [&] { return colmap_camera(lenses, image, line.where()); });
    if (!lines.at_end()) skip_points(lines.next());
  }
  sort_by_name(set.cameras);
  return set;
}

std::size_t count_colmap_images(const std::filesystem::path& file) try {
  if (file.extension() == ".bin") {
    const MappedFile content(file);
    return ByteCursor(content.content(), "").read<std::uint64_t>("the number of images");
  }
  std::size_t count = 0;
  for (Lines lines(file); !lines.at_end();) {
    const Line line = lines.next();
    if (line.empty() || line.is_comment()) continue;
    ++count;
    if (!lines.at_end()) lines.next();
  }
  return count;
} catch (const Error&) {
  return 0;
}

std::vector<ScenePoint> read_colmap_points_text(const std::filesystem::path& file) {
  std::vector<ScenePoint> points;
  for (Lines lines(file); !lines.at_end();) {
    Line line = lines.next();
    if (!line.empty() && !line.is_comment()) points.push_back(read_colmap_point(line));
  }
  return points;
}

CameraSet read_colmap_binary(const std::filesystem::path& file) {
  ColmapLenses lenses;
  for_each_record(file.parent_path() / "cameras.bin", "camera", [&](Record& record) {
    const auto id = record.read<std::uint32_t>("the camera's id");
    const ColmapLens stored = read_colmap_lens(record);
    add_colmap_lens(lenses, id, record.where(), [&] {
      return lens_camera(colmap_lens(stored, record.where()), record.where());
    });
  });
  CameraSet set{file};
  for_each_record(file.parent_path() / "images.bin", "image", [&](Record& record) {
    ColmapImage image = read_colmap_image(record);
    while (const char c = record.read<char>("the name")) image.name += c;
    record.skip_list(kPointBytes, "points");
    add_camera(set, image.name, [&] { return colmap_camera(lenses, image, record.where()); });
  });
  sort_by_name(set.cameras);
  return set;
}

std::vector<ScenePoint> read_colmap_points_binary(const std::filesystem::path& file) {
  std::vector<ScenePoint> points;
  for_each_record(file, "point", [&](Record& record) {
    points.push_back(read_colmap_point(record));
    record.read<double>("the error");
    record.skip_list(kTrackBytes, "images");
  });
  return points;
}

}  // namespace qs
