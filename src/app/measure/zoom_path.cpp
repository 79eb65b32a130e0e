// SPDX-License-Identifier: MIT
#include "app/measure/zoom_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "app/framing/camera_control.h"

namespace qs {
namespace {

// View depth at which the transmittance of a pixel falls to one half. `frame` has a trace. Empty if
// the pixel is outside the image or stays more transparent.
std::optional<double> pixel_depth(const Frame& frame, const Camera& camera, glm::ivec2 pixel) {
  const Trace& trace = frame.trace;
  const int x = pixel.x, y = pixel.y;
  if (x < 0 || y < 0 || x >= camera.width || y >= camera.height) return std::nullopt;
  const auto tile = static_cast<std::size_t>(frame.grid.tile_of(x, y));
  double transmittance = 1;
  for (std::uint64_t i = trace.tile_begin[tile]; i < trace.tile_begin[tile + 1]; ++i) {
    const auto found = std::lower_bound(trace.gaussians.begin(), trace.gaussians.end(),
                                        trace.listed[static_cast<std::size_t>(i)]);
    const auto slot = static_cast<std::size_t>(found - trace.gaussians.begin());
    const Footprint& footprint = trace.footprints[slot];
    const double dx = x - static_cast<double>(footprint.mean_px.x);
    const double dy = y - static_cast<double>(footprint.mean_px.y);
    const double squared = static_cast<double>(footprint.conic.x) * dx * dx +
                           2 * static_cast<double>(footprint.conic.y) * dx * dy +
                           static_cast<double>(footprint.conic.z) * dy * dy;
    // gamma = 2 ln(255 opacity), so this is 255 alpha before its cap.
    const double alpha_255 = std::exp(0.5 * (static_cast<double>(footprint.gamma) - squared));
    if (alpha_255 < 1) continue;
    transmittance *= 1 - std::min(0.99, alpha_255 / 255);
    if (transmittance <= 0.5) return static_cast<double>(trace.depths[slot]);
  }
  return std::nullopt;
}

}  // namespace

std::vector<Camera> zoom_path(const Camera& start, glm::dvec3 target, int steps, double closest) {
  std::vector<Camera> cameras;
  for (int step = 0; step < steps; ++step)
    cameras.push_back(zoom_camera(start, target, steps, closest, step));
  return cameras;
}

Camera zoom_camera(const Camera& start, glm::dvec3 target, int steps, double closest, int step) {
  assert(steps >= 2 && closest > 0);
  if (step == 0) return start;
  const double distance = std::pow(closest, static_cast<double>(step) / (steps - 1));
  return moved_to(start, target + distance * (start.position() - target));
}

glm::ivec2 center_pixel(const Camera& camera) { return {camera.width / 2, camera.height / 2}; }

std::optional<glm::dvec3> find_point(Renderer& renderer, const Camera& camera,
                                     RenderSettings settings, glm::ivec2 pixel) {
  Outputs outputs;
  outputs.color = false;
  outputs.trace = true;
  settings.mode = default_mode();
  const std::optional<double> depth =
      pixel_depth(renderer.render(camera, settings, outputs), camera, pixel);
  if (!depth) return std::nullopt;
  return point_at(camera, glm::dvec2(pixel), *depth);
}

}  // namespace qs
