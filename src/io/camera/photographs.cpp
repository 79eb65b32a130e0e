// SPDX-License-Identifier: MIT
#include "io/camera/photographs.h"

#include <algorithm>
#include <cmath>
#include <system_error>

#include "base/fail.h"
#include "base/list_of.h"
#include "io/camera/camera_formats.h"
#include "io/picture/image_file.h"
#include "raster/scene/image_metrics.h"

namespace qs {
namespace {

Image as_rgb(const Image& image, glm::vec3 background) {
  const bool gray = image.channels < 3, transparent = image.channels % 2 == 0;
  Image rgb(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float alpha = transparent ? image.at(x, y, image.channels - 1) : 1.0f;
      for (int c = 0; c < 3; ++c)
        rgb.at(x, y, c) = image.at(x, y, gray ? 0 : c) * alpha + background[c] * (1 - alpha);
    }
  }
  return rgb;
}

}  // namespace

Photographs::Photographs(const std::filesystem::path& folder,
                         const std::function<void(std::size_t count)>& counted) {
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
    if (name == file) continue;  // not the extension of a picture
    const auto [place, added] = files_.emplace(name, entry->path());
    // Of several endings the first in the alphabet, because folders are listed in any order.
    if (!added && entry->path() < place->second) place->second = entry->path();
    if (counted) counted(files_.size());
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
                      ThreadPool& pool, const LensCamera& taken) {
  return divided(undistorted(as_rgb(read_image(path), background), taken, pool), divisor, pool);
}

Image divided(const Image& photograph, int divisor, ThreadPool& pool) {
  const auto side = [&](int pixels) { return std::max(1, (pixels + divisor / 2) / divisor); };
  return area_average(photograph, side(photograph.width), side(photograph.height), pool);
}

std::vector<std::string> Photographs::names() const {
  return list_of<std::string>(files_, [](const auto& each) { return each.first; });
}

std::string skipped_sentence(std::size_t views) {
  return fmt::format("{} view{} without a photograph {} left out", views, views == 1 ? "" : "s",
                     views == 1 ? "is" : "are");
}

void require_same_shape(const Image& photograph, const std::filesystem::path& path,
                        const Camera& camera) {
  const double scale = static_cast<double>(photograph.width) / camera.width;
  const double height = scale * camera.height;
  if (std::abs(height - photograph.height) <= 1 + scale) return;
  fail("{}: {} x {} pixels do not have the aspect ratio of its camera, {} x {}", path.string(),
       photograph.width, photograph.height, camera.width, camera.height);
}

Image undistorted(const Image& photograph, const LensCamera& camera, ThreadPool& pool) {
  if (!camera.lens) return photograph;
  const LensCamera view = camera.scaled(photograph.width, photograph.height);
  Image result(photograph.width, photograph.height, photograph.channels);
  const auto last_x = static_cast<double>(photograph.width - 1);
  const auto last_y = static_cast<double>(photograph.height - 1);
  pool.for_chunks(
      static_cast<std::size_t>(result.height), 16, [&](std::size_t begin, std::size_t end, int) {
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
          for (int x = 0; x < result.width; ++x) {
            const glm::dvec2 slope =
                (glm::dvec2(x, y) - view.camera.center_px) / view.camera.focal_px;
            const glm::dvec2 at =
                view.lens->focal_px * view.lens->distort(slope) + view.lens->center_px;
            const double sx = std::clamp(at.x, 0.0, last_x), sy = std::clamp(at.y, 0.0, last_y);
            const int x0 = static_cast<int>(sx), y0 = static_cast<int>(sy);
            const int x1 = std::min(x0 + 1, photograph.width - 1);
            const int y1 = std::min(y0 + 1, photograph.height - 1);
            const auto fx = static_cast<float>(sx - x0), fy = static_cast<float>(sy - y0);
            for (int c = 0; c < result.channels; ++c) {
              const float top = (1 - fx) * photograph.at(x0, y0, c) + fx * photograph.at(x1, y0, c);
              const float bottom =
                  (1 - fx) * photograph.at(x0, y1, c) + fx * photograph.at(x1, y1, c);
              result.at(x, y, c) = (1 - fy) * top + fy * bottom;
            }
          }
        }
      });
  return result;
}

}  // namespace qs
