// SPDX-License-Identifier: MIT
#include "io/camera/photographs.h"

#include <algorithm>
#include <cmath>

#include "base/fail.h"
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

Image read_photograph(const std::filesystem::path& path, glm::vec3 background, int divisor,
                      ThreadPool& pool, const LensCamera& taken) {
  return divided(undistorted(as_rgb(read_image(path), background), taken, pool), divisor, pool);
}

Image divided(const Image& photograph, int divisor, ThreadPool& pool) {
  const auto side = [&](int pixels) { return std::max(1, (pixels + divisor / 2) / divisor); };
  return area_average(photograph, side(photograph.width), side(photograph.height), pool);
}

void require_same_shape(const Image& photograph, const std::filesystem::path& path,
                        const Camera& camera) {
  const double scale = static_cast<double>(photograph.width) / camera.width;
  const double height = scale * camera.height;
  if (std::abs(height - photograph.height) <= 1 + scale) return;
  const double turned_scale = static_cast<double>(photograph.height) / camera.width;
  const bool is_turned =
      std::abs(turned_scale * camera.height - photograph.width) <= 1 + turned_scale;
  if (const int orientation = exif_orientation(path); orientation > 1 && is_turned)
    fail(
        "{}: {} x {} pixels, but its camera has {} x {}: its EXIF tag Orientation is {}, and the "
        "camera is of the turned picture; turn the pixels of the photographs first (mogrify "
        "-auto-orient)",
        path.string(), photograph.width, photograph.height, camera.width, camera.height,
        orientation);
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
