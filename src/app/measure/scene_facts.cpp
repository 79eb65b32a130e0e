// SPDX-License-Identifier: MIT
#include "app/measure/scene_facts.h"

#include <fstream>
#include <vector>

#include <zlib.h>

#include "base/fail.h"

namespace qs {

std::string file_hash(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  uLong crc = crc32(0, nullptr, 0);
  std::vector<char> block(std::size_t{1} << 20);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0)
    crc =
        crc32(crc, reinterpret_cast<const Bytef*>(block.data()), static_cast<uInt>(file.gcount()));
  if (!file.eof()) fail("{}: cannot be read", path.string());
  return fmt::format("crc32:{:08x}", crc);
}

nlohmann::ordered_json scene_facts(const Scene& scene, const std::string& name) {
  return {{"name", name},
          {"file", scene.path.string()},
          {"hash", file_hash(scene.path)},
          {"bytes", scene.file_bytes},
          {"gaussians", scene.cloud.size()}};
}

std::string scene_name(const std::filesystem::path& scene_file) {
  const std::filesystem::path file = std::filesystem::absolute(scene_file);
  if (file.filename() != "point_cloud.ply") return file.stem().string();
  // MODEL/point_cloud/iteration_N/point_cloud.ply
  return file.parent_path().parent_path().parent_path().filename().string();
}

std::string picture_title(const std::filesystem::path& scene_file, const std::string& view) {
  return fmt::format("{} \u00b7 {}", scene_name(scene_file), view);
}

}  // namespace qs
