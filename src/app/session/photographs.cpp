// SPDX-License-Identifier: MIT
#include "app/session/photographs.h"

#include <algorithm>
#include <cmath>
#include <system_error>

#include "io/camera/camera_formats.h"
#include "io/picture/image_file.h"
#include "raster/base/fail.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

Image as_rgb(const Image& image, glm::vec3 background) {
  const bool gray = image.channels < 3, transparent = image.channels % 2 == 0;
  Image rgb(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float alpha = transparent ? image.at(x, y, image.channels - 1) : 1.0f;
      for (int c = 0; c < 3; ++c) {
        rgb.at(x, y, c) = image.at(x, y, gray ? 0 : c) * alpha + background[c] * (1 - alpha);
      }
    }
  }
  return rgb;
}

int divided(int side, int divisor) { return std::max(1, (side + divisor / 2) / divisor); }

}  // namespace

Photographs::Photographs(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (!fs::is_directory(folder, error)) fail("{}: not a folder of photographs", folder.string());
  const auto options = fs::directory_options::skip_permission_denied;
  for (auto entry = fs::recursive_directory_iterator(folder, options, error);
       !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code unreachable;  // for example a broken link
    if (!entry->is_regular_file(unreachable)) continue;
    const std::string file = entry->path().lexically_relative(folder).generic_string();
    const std::string name = photograph_name(file);
    if (name == file) continue;  // not the ending of a picture
    const auto [place, added] = files_.emplace(name, entry->path());
    // Of several endings the first in the alphabet, because folders are listed in any order.
    if (!added && entry->path() < place->second) place->second = entry->path();
  }
  if (error) fail("{}: cannot be listed: {}", folder.string(), error.message());
}

std::optional<std::filesystem::path> Photographs::find(const std::string& camera_name) const {
  for (std::string name = camera_name; !name.empty();) {
    if (const auto found = files_.find(name); found != files_.end()) return found->second;
    const std::size_t slash = name.find('/');
    if (slash == std::string::npos) break;
    name.erase(0, slash + 1);
  }
  return std::nullopt;
}

Image read_photograph(const std::filesystem::path& path, glm::vec3 background, int divisor,
                      ThreadPool& pool) {
  const Image image = as_rgb(read_image(path), background);
  return area_average(image, divided(image.width, divisor), divided(image.height, divisor), pool);
}

void require_same_shape(const Image& photograph, const std::filesystem::path& path,
                        const Camera& camera) {
  const double scale = static_cast<double>(photograph.width) / camera.width;
  const double height = scale * camera.height;
  if (std::abs(height - photograph.height) <= 1 + scale) return;
  fail("{}: {} x {} pixels do not have the aspect ratio of its camera, {} x {}", path.string(),
       photograph.width, photograph.height, camera.width, camera.height);
}

}  // namespace qs
