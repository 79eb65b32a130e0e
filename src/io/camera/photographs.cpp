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

// Calls visit(x, y) for every pixel, from several threads.
template <class Visit>
void for_each_pixel(int width, int height, ThreadPool& pool, const Visit& visit) {
  pool.for_chunks(static_cast<std::size_t>(height), 16,
                  [&](std::size_t begin, std::size_t end, int) {
                    for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y)
                      for (int x = 0; x < width; ++x) visit(x, y);
                  });
}

}  // namespace

Image read_as_taken(const std::filesystem::path& path, glm::vec3 background,
                    const LensCamera& taken) {
  Image photograph = as_rgb(read_image(path), background);
  if (taken.camera.width > 0) require_same_shape(photograph, path, taken.photograph_size());
  return photograph;
}

Image read_photograph(const std::filesystem::path& path, glm::vec3 background, int divisor,
                      ThreadPool& pool, const LensCamera& taken) {
  return divided(undistorted(read_as_taken(path, background, taken), taken, pool), divisor, pool);
}

Image divided(const Image& photograph, int divisor, ThreadPool& pool) {
  const auto side = [&](int pixels) { return std::max(1, (pixels + divisor / 2) / divisor); };
  return area_average(photograph, side(photograph.width), side(photograph.height), pool);
}

void require_same_shape(const Image& photograph, const std::filesystem::path& path,
                        glm::dvec2 camera_size) {
  const double scale = photograph.width / camera_size.x;
  if (std::abs(scale * camera_size.y - photograph.height) <= 1 + scale) return;
  const double turned_scale = photograph.height / camera_size.x;
  const bool is_turned =
      std::abs(turned_scale * camera_size.y - photograph.width) <= 1 + turned_scale;
  if (const int orientation = exif_orientation(path); orientation > 1 && is_turned)
    fail(
        "{}: {} x {} pixels, but its camera has {} x {}: its EXIF tag Orientation is {}, and the "
        "camera is of the turned picture; turn the pixels of the photographs first (mogrify "
        "-auto-orient)",
        path.string(), photograph.width, photograph.height, camera_size.x, camera_size.y,
        orientation);
  fail("{}: {} x {} pixels do not have the aspect ratio of its camera, {} x {}", path.string(),
       photograph.width, photograph.height, camera_size.x, camera_size.y);
}

Image undistorted(const Image& photograph, const LensCamera& camera, ThreadPool& pool) {
  if (!camera.lens) return photograph;
  const glm::dvec2 factor = glm::dvec2(photograph.width, photograph.height) / camera.lens->size_px;
  const auto scaled_side = [](int side, double by) {
    return std::max(1, static_cast<int>(std::lround(side * by)));
  };
  LensCamera view = camera.scaled(scaled_side(camera.camera.width, factor.x),
                                  scaled_side(camera.camera.height, factor.y));
  view.lens = camera.lens->scaled(factor);
  Image result(view.camera.width, view.camera.height, photograph.channels);
  const bool goes_around = view.lens->model->plane == LensPlane::panorama;
  const int last_x = photograph.width - 1, last_y = photograph.height - 1;
  for_each_pixel(result.width, result.height, pool, [&](int x, int y) {
    const std::optional<glm::dvec2> source = view.source_of({x, y});
    if (!source) return;
    const glm::dvec2 at(goes_around ? source->x : std::clamp(source->x, 0.0, double(last_x)),
                        std::clamp(source->y, 0.0, double(last_y)));
    int x0 = static_cast<int>(std::floor(at.x)), x1 = std::min(x0 + 1, last_x);
    const int y0 = static_cast<int>(at.y), y1 = std::min(y0 + 1, last_y);
    const auto fx = static_cast<float>(at.x - x0), fy = static_cast<float>(at.y - y0);
    if (goes_around) {
      x1 = (x0 + 1) % photograph.width;
      x0 = (x0 + photograph.width) % photograph.width;
    }
    for (int c = 0; c < result.channels; ++c) {
      const float top = (1 - fx) * photograph.at(x0, y0, c) + fx * photograph.at(x1, y0, c);
      const float bottom = (1 - fx) * photograph.at(x0, y1, c) + fx * photograph.at(x1, y1, c);
      result.at(x, y, c) = (1 - fy) * top + fy * bottom;
    }
  });
  return result;
}

std::vector<std::uint8_t> lens_mask(const LensCamera& camera, int width, int height,
                                    ThreadPool& pool) {
  if (!camera.lens) return {};
  const LensCamera view = camera.scaled(width, height);
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(width) *
                                 static_cast<std::size_t>(height));
  // Corners at 0.5 would leave out pixels at edges that rounding moved.
  constexpr double kCorner = 0.45;
  for_each_pixel(width, height, pool, [&](int x, int y) {
    bool is_shown = true;
    for (const glm::dvec2 corner : {glm::dvec2(-1, -1), {1, -1}, {-1, 1}, {1, 1}})
      is_shown = is_shown && view.source_of(glm::dvec2(x, y) + kCorner * corner);
    mask[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(x)] = is_shown ? 1 : 0;
  });
  if (std::ranges::count(mask, std::uint8_t{0}) == 0) return {};
  return mask;
}

}  // namespace qs
