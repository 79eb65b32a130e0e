// SPDX-License-Identifier: MIT
//
// COLMAP's cameras.txt, images.txt and points3D.txt. Lines that begin with # are comments.
//   cameras.txt  ID MODEL WIDTH HEIGHT PARAMETERS...
//   images.txt   two lines each: ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then its points as
//                X Y POINT_ID ..., which may be an empty line and are skipped
//   points3D.txt ID X Y Z R G B, then values that are skipped
#include <charconv>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/mapped_file.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"
#include "io/camera/colmap.h"

namespace qs {
namespace {

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

  const ColmapModel& model() {
    const std::string_view name = word("the model");
    const ColmapModel* const found = find_colmap_model(name);
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
      : file_(path), path_(path.string()), rest_(text_of(file_.content())) {}

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

}  // namespace

std::vector<LensCamera> read_colmap_text(const std::filesystem::path& file) {
  ColmapLenses lenses;
  for (Lines lines(file.parent_path() / "cameras.txt"); !lines.at_end();) {
    Line line = lines.next();
    if (!line.empty() && !line.is_comment()) read_colmap_lens(line, lenses);
  }
  std::vector<LensCamera> cameras;
  for (Lines lines(file.parent_path() / "images.txt"); !lines.at_end();) {
    Line line = lines.next();
    if (line.empty() || line.is_comment()) continue;
    ColmapImage image = read_colmap_image(line);
    image.name = line.all("the name");
    cameras.push_back(colmap_camera(lenses, image, line.where()));
    if (!lines.at_end()) skip_points(lines.next());
  }
  sort_by_name(cameras);
  return cameras;
}

std::vector<ScenePoint> read_colmap_points_text(const std::filesystem::path& file) {
  std::vector<ScenePoint> points;
  for (Lines lines(file); !lines.at_end();) {
    Line line = lines.next();
    if (!line.empty() && !line.is_comment()) points.push_back(read_colmap_point(line));
  }
  return points;
}

}  // namespace qs
