// SPDX-License-Identifier: MIT
#include "raster/select/by_shape.h"

#include <algorithm>

namespace qs {

GaussianSet gaussians_through(const GaussianCloud& cloud, const Camera& camera, const Shape& shape,
                              ThreadPool& pool) {
  const Camera here = camera.placed(cloud.origin);
  return GaussianSet::where(cloud.size(), pool, [&](std::size_t i) {
    const glm::dvec3 at = here.view_from_world * glm::dvec4(cloud.positions[i], 1);
    return at.z > here.near_depth &&
           shape.contains(glm::dvec2(at) / at.z * here.focal_px + here.center_px);
  });
}

std::shared_ptr<const SeenPixels> pixels_in(const Shape& shape, glm::ivec2 size, float weight,
                                            ThreadPool& pool) {
  auto pixels = std::make_shared<SeenPixels>(SeenPixels{shape.pixels(size), {}, weight});
  const PixelBox& box = pixels->box;
  const auto width = static_cast<std::size_t>(std::max(box.x1 - box.x0, 0));
  const auto height = static_cast<std::size_t>(std::max(box.y1 - box.y0, 0));
  pixels->chosen.resize(width * height);
  pool.for_each(height, 8, [&](std::size_t row) {
    shape.choose_row({box.x0, box.y0 + static_cast<int>(row)},
                     std::span(pixels->chosen).subspan(row * width, width));
  });
  return pixels;
}

}  // namespace qs
