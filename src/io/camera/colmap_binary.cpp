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

#include "io/bytes/byte_cursor.h"
#include "io/bytes/mapped_file.h"
#include "io/camera/camera_formats.h"
#include "io/camera/colmap.h"
#include "io/camera/points.h"

namespace qs {
namespace {

constexpr std::uint64_t kPointBytes = 24;
constexpr std::uint64_t kTrackBytes = 8;

// Names the record for a message. A file may have millions, so nothing is formatted before.
using Where = std::function<std::string()>;

// Calls read(cursor, where) for every record of a file that begins with their number.
template <class F>
void for_each_record(const std::filesystem::path& path, const char* record, F read) {
  const MappedFile file(path);
  ByteCursor header(file.content(), path.string());
  const auto count = header.read<std::uint64_t>("the number of records");
  auto rest = file.content().subspan(header.offset());
  std::uint64_t i = 0;
  const Where where = [&] { return fmt::format("{}: {} {}", path.string(), record, i); };
  for (; i < count; ++i) {
    ByteCursor cursor(rest, [&where] { return where(); });
    read(cursor, where);
    rest = rest.subspan(cursor.offset());
  }
  if (!rest.empty()) {
    fail("{}: {} bytes follow the {} {}s that it announces", path.string(), rest.size(), count,
         record);
  }
}

void read_lens(ByteCursor& cursor, const Where& where, ColmapLenses& lenses) {
  const auto id = cursor.read<std::uint32_t>("id");
  const auto model_id = cursor.read<std::int32_t>("model");
  const auto width = cursor.read<std::uint64_t>("width");
  const auto height = cursor.read<std::uint64_t>("height");
  const ColmapModel* model = find_colmap_model(model_id);
  if (model == nullptr) fail("{}: there is no camera model {}", where(), model_id);
  std::array<double, 16> parameters{};
  const auto count = static_cast<std::size_t>(model->parameters);
  for (std::size_t i = 0; i < count; ++i) parameters.at(i) = cursor.read<double>("parameters");
  add_colmap_lens(lenses, {id, *model, width, height, std::span(parameters).first(count)}, where());
}

ColmapImage read_image_record(ByteCursor& cursor, const Where& where) {
  ColmapImage image;
  cursor.read<std::uint32_t>("id");
  image.rotation.w = cursor.read<double>("quaternion");
  image.rotation.x = cursor.read<double>("quaternion");
  image.rotation.y = cursor.read<double>("quaternion");
  image.rotation.z = cursor.read<double>("quaternion");
  for (int i = 0; i < 3; ++i) image.translation[i] = cursor.read<double>("translation");
  image.lens = cursor.read<std::uint32_t>("camera");
  while (const char c = cursor.read<char>("name")) image.name += c;
  const auto points = cursor.read<std::uint64_t>("the number of points");
  if (!fits(points, kPointBytes, cursor.left()))
    fail("{}: cut off: {} points do not fit into {} bytes", where(), points, cursor.left());
  cursor.take(points * kPointBytes, "points");
  return image;
}

ScenePoint read_point_record(ByteCursor& cursor, const Where& where) {
  ScenePoint point;
  cursor.read<std::uint64_t>("id");
  for (int i = 0; i < 3; ++i) point.position[i] = cursor.read<double>("position");
  for (int i = 0; i < 3; ++i)
    point.color[i] = static_cast<float>(cursor.read<std::uint8_t>("colour")) / 255;
  cursor.read<double>("error");
  const auto images = cursor.read<std::uint64_t>("the number of images");
  if (!fits(images, kTrackBytes, cursor.left()))
    fail("{}: cut off: {} images do not fit into {} bytes", where(), images, cursor.left());
  cursor.take(images * kTrackBytes, "images");
  if (!is_finite(point)) fail("{}: its position is not finite", where());
  return point;
}

}  // namespace

bool recognises_colmap_binary(const std::filesystem::path& file, std::string_view) {
  return file.filename() == "images.bin" || file.filename() == "cameras.bin";
}

std::vector<LensCamera> read_colmap_binary(const std::filesystem::path& file) {
  ColmapLenses lenses;
  for_each_record(
      file.parent_path() / "cameras.bin", "camera",
      [&](ByteCursor& cursor, const Where& where) { read_lens(cursor, where, lenses); });
  std::vector<LensCamera> cameras;
  for_each_record(file.parent_path() / "images.bin", "image",
                  [&](ByteCursor& cursor, const Where& where) {
                    const ColmapImage image = read_image_record(cursor, where);
                    cameras.push_back(colmap_camera(lenses, image, where()));
                  });
  sort_by_name(cameras);
  return cameras;
}

std::vector<ScenePoint> read_colmap_points_binary(const std::filesystem::path& file) {
  std::vector<ScenePoint> points;
  for_each_record(file, "point", [&](ByteCursor& cursor, const Where& where) {
    points.push_back(read_point_record(cursor, where));
  });
  return points;
}

}  // namespace qs
