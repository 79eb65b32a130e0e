// SPDX-License-Identifier: MIT
#include "io/camera/lens.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/fail.h"

namespace qs {
namespace {

constexpr double kLeastFactor = 0.5, kMostFactor = 2;
constexpr int kBorderPoints = 64;  // per side

glm::dvec2 scaled_center(glm::dvec2 center, glm::dvec2 factor) {
  return (center + 0.5) * factor - 0.5;  // distances from the pixel corner are scaled
}

// Calls visit(pixel) for points on the image's border.
template <class Visit>
void for_each_border_point(const Camera& camera, const Visit& visit) {
  const glm::dvec2 low(-0.5), high(camera.width - 0.5, camera.height - 0.5);
  for (int i = 0; i <= kBorderPoints; ++i) {
    const glm::dvec2 at = low + (high - low) * (static_cast<double>(i) / kBorderPoints);
    for (const glm::dvec2 point : {glm::dvec2(at.x, low.y), glm::dvec2(at.x, high.y),
                                   glm::dvec2(low.x, at.y), glm::dvec2(high.x, at.y)})
      visit(point);
  }
}

// True if every pixel of the pinhole camera is inside the photograph, and no direction is shown
// twice.
bool fills(const Camera& camera, const Lens& lens) {
  bool inside = true;
  for_each_border_point(camera, [&](glm::dvec2 point) {
    const glm::dvec2 slope = (point - camera.center_px) / camera.focal_px;
    const double r2 = glm::dot(slope, slope);
    // The radius grows with the angle up to here: the derivative of r (1 + k1 r^2 + k2 r^4).
    for (int step = 1; step <= 8; ++step) {
      const double s = r2 * step / 8;
      inside = inside && 1 + 3 * lens.k1 * s + 5 * lens.k2 * s * s > 0;
    }
    const glm::dvec2 source = lens.focal_px * lens.distort(slope) + lens.center_px;
    constexpr double kRounding = 1e-9;
    inside = inside && source.x >= -0.5 - kRounding && source.y >= -0.5 - kRounding &&
             source.x <= camera.width - 0.5 + kRounding &&
             source.y <= camera.height - 0.5 + kRounding;
  });
  return inside;
}

}  // namespace

glm::dvec2 Lens::distort(glm::dvec2 slope) const {
  const double x = slope.x, y = slope.y, r2 = x * x + y * y;
  const double radial = 1 + (k1 + k2 * r2) * r2;
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)};
}

LensCamera LensCamera::scaled(int width, int height) const {
  const glm::dvec2 factor(static_cast<double>(width) / camera.width,
                          static_cast<double>(height) / camera.height);
  LensCamera result = *this;
  result.camera.focal_px *= factor;
  result.camera.center_px = scaled_center(camera.center_px, factor);
  result.camera.width = width;
  result.camera.height = height;
  if (result.lens) {
    result.lens->focal_px *= factor;
    result.lens->center_px = scaled_center(lens->center_px, factor);
  }
  return result;
}

LensCamera undistorted_camera(const Camera& size, const Lens& lens, const std::string& where) {
  const auto at = [&](double factor) {
    Camera camera = size;
    camera.focal_px = lens.focal_px * factor;
    camera.center_px = lens.center_px;
    return camera;
  };
  double low = kLeastFactor, high = kMostFactor;
  if (!fills(at(high), lens))
    fail(
        "{}: the lens distorts too strongly; undistort the photographs first (colmap "
        "image_undistorter)",
        where);
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (fills(at(middle), lens) ? high : low) = middle;
  }
  return {at(high), lens, {}};
}

void sort_by_name(std::vector<LensCamera>& cameras) {
  std::ranges::stable_sort(cameras, [](const LensCamera& a, const LensCamera& b) {
    return a.camera.name < b.camera.name;
  });
}

std::vector<Camera> pinhole_cameras(const std::vector<LensCamera>& cameras) {
  std::vector<Camera> result(cameras.size());
  std::ranges::transform(cameras, result.begin(), &LensCamera::camera);
  return result;
}

}  // namespace qs
