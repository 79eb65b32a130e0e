// SPDX-License-Identifier: MIT
#include "support/scene_files.h"

#include <fstream>

#include "io/camera/cameras.h"

namespace qs::test {

Scene read_scene(const std::filesystem::path& path, const ReadOptions& options) {
  ThreadPool pool(0);
  return qs::read_scene(path, pool, options);
}

const WriterRow& write_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                             const Progress& progress, std::string_view format) {
  ThreadPool pool(0);
  return qs::write_scene(cloud, path, pool, progress, format);
}

void write_cameras(const std::vector<Camera>& cameras, const std::filesystem::path& path) {
  std::ofstream file(path);
  const char* before = "[";
  for (const Camera& camera : cameras) {
    file << before << format_camera(camera);
    before = ",\n";
  }
  file << "]\n";
}

}  // namespace qs::test
