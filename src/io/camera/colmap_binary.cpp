// SPDX-License-Identifier: MIT
//
// COLMAP's cameras.bin, images.bin and points3D.bin, little endian:
//   cameras  u64 count, each: u32 id, i32 model, u64 width, u64 height, f64 per parameter
//   images   u64 count, each: u32 id, f64 quaternion w x y z, f64 translation x y z, u32 camera,
//            name ending with 0, u64 points, each: f64 x, f64 y, u64 point (skipped)
//   points3D u64 count, each: u64 id, f64 x y z, u8 r g b, f64 error, u64 images, each: u32 image,
//            u32 point (skipped)
#include <algorithm>
#include <array>
#include <functional>

#include "base/not_copied.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/mapped_file.h"
#include "io/camera/camera_formats.h"
#include "io/camera/cameras.h"
#include "io/camera/colmap.h"

namespace qs {
namespace {

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

  const ColmapModel& model() {
    const auto id = read<std::int32_t>("the model");
    const ColmapModel* const found = find_colmap_model(id);
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

std::vector<LensCamera> read_colmap_binary(const std::filesystem::path& file) {
  ColmapLenses lenses;
  for_each_record(file.parent_path() / "cameras.bin", "camera",
                  [&](Record& record) { read_colmap_lens(record, lenses); });
  std::vector<LensCamera> cameras;
  for_each_record(file.parent_path() / "images.bin", "image", [&](Record& record) {
    ColmapImage image = read_colmap_image(record);
    while (const char c = record.read<char>("the name")) image.name += c;
    record.skip_list(kPointBytes, "points");
    cameras.push_back(colmap_camera(lenses, image, record.where()));
  });
  sort_by_name(cameras);
  return cameras;
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
