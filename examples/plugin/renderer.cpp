// SPDX-License-Identifier: MIT
//
// A renderer of 3D Gaussians as a plugin of quadsplat, in one file: copy it and replace the body of
// draw() by your renderer. It follows the rules of 3DGS (Kerbl et al. 2023): project every Gaussian,
// sort by depth, and composite them front to back over the pixels of their bounding boxes. It runs
// in one thread, has no tiles, and is slow but correct.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <vector>

#include "quadsplat/plugin.h"

namespace {

constexpr double kAlphaMin = 1.0 / 255, kAlphaMax = 0.99, kTransmittanceMin = 1e-4;

struct Splat {
  double depth, x, y;           // view z; pixels
  double a, b, c;               // inverse of the covariance on the image: a xx + 2 b xy + c yy
  double opacity, half_x, half_y;  // half sides of the box with alpha >= 1/255, pixels
  double color[3];
};

// Colour of Gaussian `i` in the unit direction (x, y, z): real spherical harmonics.
void evaluate_sh(const QsScene& scene, int degree, uint64_t i, double x, double y, double z,
                 double color[3]) {
  const double xx = x * x, yy = y * y, zz = z * z;
  const double basis[16] = {0.28209479177387814,
                            -0.4886025119029199 * y,
                            0.4886025119029199 * z,
                            -0.4886025119029199 * x,
                            1.0925484305920792 * x * y,
                            -1.0925484305920792 * y * z,
                            0.31539156525252005 * (2 * zz - xx - yy),
                            -1.0925484305920792 * x * z,
                            0.5462742152960396 * (xx - yy),
                            -0.5900435899266435 * y * (3 * xx - yy),
                            2.890611442640554 * x * y * z,
                            -0.4570457994644658 * y * (4 * zz - xx - yy),
                            0.3731763325901154 * z * (2 * zz - 3 * xx - 3 * yy),
                            -0.4570457994644658 * x * (4 * zz - xx - yy),
                            1.445305721320277 * z * (xx - yy),
                            -0.5900435899266435 * x * (xx - 3 * yy)};
  const int stored = (scene.sh_degree + 1) * (scene.sh_degree + 1);
  for (int channel = 0; channel < 3; ++channel) {
    double sum = 0.5;
    for (int k = 0; k < (degree + 1) * (degree + 1); ++k)
      sum += basis[k] * scene.sh[3 * (i * stored + k) + channel];
    color[channel] = std::max(sum, 0.0);
  }
}

// Returns false if the Gaussian is behind the camera or too faint.
bool project(const QsScene& scene, const QsView& view, uint64_t i, Splat& splat) {
  const double* const m = view.view_from_world;
  const float* const p = scene.positions + 3 * i;
  double t[3];  // position in view axes
  for (int row = 0; row < 3; ++row)
    t[row] = m[4 * row] * p[0] + m[4 * row + 1] * p[1] + m[4 * row + 2] * p[2] + m[4 * row + 3];
  if (!(t[2] > view.near_depth)) return false;

  // Rows of J W: the Jacobian of the projection, its slopes clamped to 1.3 x the field of view.
  double jw[2][3];
  const double sides[2] = {double(view.width), double(view.height)};
  for (int axis = 0; axis < 2; ++axis) {
    const double f = view.focal_px[axis], limit = 1.3 * sides[axis] / (2 * f);
    const double slope = std::min(std::max(t[axis] / t[2], -limit), limit);
    for (int k = 0; k < 3; ++k) jw[axis][k] = f / t[2] * (m[4 * axis + k] - slope * m[8 + k]);
  }
  // The covariance on the image, J W Sigma W^T J^T.
  const float* const s = scene.covariances + 6 * i;
  const double sigma[3][3] = {{s[0], s[1], s[2]}, {s[1], s[3], s[4]}, {s[2], s[4], s[5]}};
  double v[2][2] = {};
  for (int r = 0; r < 2; ++r) {
    for (int q = 0; q < 2; ++q) {
      for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < 3; ++k) v[r][q] += jw[r][j] * sigma[j][k] * jw[q][k];
      }
      v[r][q] *= double(view.splat_scale) * view.splat_scale;
    }
  }
  const double before = v[0][0] * v[1][1] - v[0][1] * v[0][1];
  v[0][0] += view.dilation_px2;
  v[1][1] += view.dilation_px2;
  const double after = v[0][0] * v[1][1] - v[0][1] * v[0][1];
  if (!(after > 0) || !std::isfinite(after)) return false;
  splat.opacity = scene.opacities[i];
  if (view.antialiased) splat.opacity *= std::sqrt(std::max(before / after, 2.5e-5));
  if (!(splat.opacity > kAlphaMin)) return false;
  const double extent = std::sqrt(2 * std::log(255 * splat.opacity));  // in standard deviations
  splat.half_x = extent * std::sqrt(v[0][0]);
  splat.half_y = extent * std::sqrt(v[1][1]);
  splat.a = v[1][1] / after;
  splat.b = -v[0][1] / after;
  splat.c = v[0][0] / after;
  splat.depth = t[2];
  splat.x = view.focal_px[0] * t[0] / t[2] + view.center_px[0];
  splat.y = view.focal_px[1] * t[1] / t[2] + view.center_px[1];

  // The direction from the camera, rotated back to world axes.
  const double length = std::sqrt(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]);
  double d[3];
  for (int k = 0; k < 3; ++k) d[k] = (m[k] * t[0] + m[4 + k] * t[1] + m[8 + k] * t[2]) / length;
  evaluate_sh(scene, std::min(view.sh_degree, scene.sh_degree), i, d[0], d[1], d[2], splat.color);
  return true;
}

// Draws one frame and returns the number of Gaussians on the image.
uint32_t draw(const QsScene& scene, const QsView& view, float* image) {
  std::vector<Splat> splats;
  for (uint64_t i = 0; i < scene.count; ++i) {
    Splat splat;
    if (project(scene, view, i, splat)) splats.push_back(splat);
  }
  std::stable_sort(splats.begin(), splats.end(),
                   [](const Splat& a, const Splat& b) { return a.depth < b.depth; });

  const size_t pixels = size_t(view.width) * size_t(view.height);
  std::vector<double> light(3 * pixels), transmittance(pixels, 1);
  std::vector<char> stopped(pixels, 0);
  uint32_t visible = 0;
  for (const Splat& splat : splats) {
    const auto clamped = [](double value, int size) { return int(std::clamp(value, 0.0, double(size))); };
    const int x0 = clamped(std::ceil(splat.x - splat.half_x), view.width);
    const int x1 = clamped(std::floor(splat.x + splat.half_x) + 1, view.width);
    const int y0 = clamped(std::ceil(splat.y - splat.half_y), view.height);
    const int y1 = clamped(std::floor(splat.y + splat.half_y) + 1, view.height);
    if (x0 < x1 && y0 < y1) ++visible;
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        const size_t pixel = size_t(y) * size_t(view.width) + size_t(x);
        if (stopped[pixel]) continue;
        const double dx = x - splat.x, dy = y - splat.y;
        const double power = -0.5 * (splat.a * dx * dx + splat.c * dy * dy) - splat.b * dx * dy;
        const double alpha = std::min(kAlphaMax, splat.opacity * std::exp(power));
        if (power > 0 || alpha < kAlphaMin) continue;
        const double next = transmittance[pixel] * (1 - alpha);
        if (next < kTransmittanceMin) {
          stopped[pixel] = 1;
          continue;
        }
        for (int channel = 0; channel < 3; ++channel)
          light[3 * pixel + channel] += transmittance[pixel] * alpha * splat.color[channel];
        transmittance[pixel] = next;
      }
    }
  }
  for (size_t i = 0; i < 3 * pixels; ++i)
    image[i] = float(light[i] + transmittance[i / 3] * view.background[i % 3]);
  return visible;
}

// quadsplat's arrays stay valid until close(), so this renderer keeps the pointers only. Others copy
// or convert the arrays here; that time is not measured.
int32_t open_scene(const QsScene* scene, void** renderer, char* message) try {
  *renderer = new QsScene(*scene);
  return 0;
} catch (const std::exception& error) {
  std::snprintf(message, QS_MESSAGE_BYTES, "%s", error.what());
  return 1;
}

// frame_ms stays 0: quadsplat measures the call. A renderer on a GPU sets it from events, or waits
// for the device before it returns.
int32_t render(void* renderer, const QsView* view, QsFrame* frame, char* message) try {
  frame->visible = draw(*static_cast<const QsScene*>(renderer), *view, frame->image);
  return 0;
} catch (const std::exception& error) {
  std::snprintf(message, QS_MESSAGE_BYTES, "%s", error.what());
  return 1;
}

void close_scene(void* renderer) { delete static_cast<QsScene*>(renderer); }

}  // namespace

const QsPlugin* qs_plugin() {
  static const QsPlugin plugin = {
      QS_PLUGIN_VERSION, QS_MEMORY_HOST, QS_IMAGE_HWC, 0,
      "example",         "quadsplat's example of a plugin, one thread, no tiles",
      open_scene,        render,         close_scene};
  return &plugin;
}
