// SPDX-License-Identifier: MIT
#include "raster/select/by_shape.h"

#include <utility>

#include "base/error.h"
#include "raster/api/trace.h"
#include "raster/kernel/composite.h"

namespace qs {
namespace {

// Marks the Gaussians that a pixel of the shape in the tile blends with that weight.
void mark_seen(const Frame& frame, glm::ivec2 size, const std::vector<std::uint32_t>& slots,
               int tile, const Shape& shape, float weight, GaussianSet& seen) {
  const PixelBox pixels = pixels_of(frame.grid, size, tile);
  const int width = pixels.x1 - pixels.x0;
  // The transmittance of the pixels; 0: it is outside of the shape, or has stopped.
  std::vector<float> transmittance;
  int running = 0;
  for_each_pixel(pixels, [&](int x, int y) {
    const bool inside = shape.contains(glm::dvec2(x, y));
    transmittance.push_back(inside ? 1.0f : 0.0f);
    running += inside;
  });
  for (const std::uint32_t gaussian : list_of(frame.trace, tile)) {
    if (running == 0) return;
    const std::uint32_t slot = slots[gaussian];
    bool marked = false;
    for_each_pixel(reached(pixels, frame.trace.footprints[slot]), [&](int x, int y) {
      float& left =
          transmittance[static_cast<std::size_t>((y - pixels.y0) * width + x - pixels.x0)];
      if (left == 0) return;
      const float before = left;
      float alpha = 0;
      const Step step = composite(frame.trace.splats[slot], static_cast<float>(x),
                                  static_cast<float>(y), left, alpha);
      if (step == Step::stops) {
        left = 0;
        --running;
      }
      marked = marked || (step == Step::blends && alpha * before >= weight);
    });
    if (marked) seen.add_atomically(gaussian);
  }
}

}  // namespace

GaussianSet gaussians_through(const GaussianCloud& cloud, const Camera& camera, const Shape& shape,
                              ThreadPool& pool) {
  const Camera here = camera.placed(cloud.origin);
  return GaussianSet::where(cloud.size(), pool, [&](std::size_t i) {
    const glm::dvec3 at = here.view_from_world * glm::dvec4(cloud.positions[i], 1);
    return at.z > here.near_depth &&
           shape.contains(glm::dvec2(at) / at.z * here.focal_px + here.center_px);
  });
}

GaussianSet gaussians_seen(const Frame& frame, glm::ivec2 size, const Shape& shape, float weight,
                           ThreadPool& pool, std::stop_token stop) {
  GaussianSet seen(frame.stats.gaussians);
  const std::vector<std::uint32_t> slots = slots_of(frame.trace, seen.size());
  const PixelBox box = shape.pixels(size);
  if (box.x0 >= box.x1 || box.y0 >= box.y1) return seen;
  const int side = frame.grid.tile_px, columns = (box.x1 - 1) / side - box.x0 / side + 1;
  const int rows = (box.y1 - 1) / side - box.y0 / side + 1;
  pool.for_each(static_cast<std::size_t>(columns * rows), 4, [&](std::size_t i) {
    if (stop.stop_requested()) throw Cancelled{};
    const int at = static_cast<int>(i);
    const int tile =
        (box.y0 / side + at / columns) * frame.grid.columns + box.x0 / side + at % columns;
    mark_seen(frame, size, slots, tile, shape, weight, seen);
  });
  return seen;
}

}  // namespace qs
