// SPDX-License-Identifier: MIT
#include "raster/cpu/reference.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/geometric.hpp>

#include "raster/kernel/sh.h"

namespace qs::cpu {
namespace {

struct PixelBox {
  int x0, y0, x1, y1;  // half-open
};

struct ReferenceSplat {
  glm::dvec2 mean;
  glm::dvec3 conic;  // (a, b, c) of a dx^2 + 2 b dx dy + c dy^2
  double opacity;
  glm::dvec3 color;
  PixelBox box;
  std::uint32_t depth_bits, gaussian;
};

/// Pixels from floor(low) to ceil(high), one more on each side, clamped to [0, limit).
void grown_range(double low, double high, int limit, int& begin, int& end) {
  begin = static_cast<int>(std::clamp(std::floor(low) - 1, 0.0, static_cast<double>(limit)));
  end = static_cast<int>(std::clamp(std::ceil(high) + 2, 0.0, static_cast<double>(limit)));
}

bool project_reference(const FrameContext& frame, const View<double>& view, std::size_t i,
                       ReferenceSplat& splat) {
  const GaussianCloud& cloud = frame.cloud;
  const glm::dvec3 position(cloud.positions[i]);
  const glm::dvec3 point = to_view(view, position);
  if (!(point.z > view.near_depth)) return false;
  Covariance2<double> covariance = project_covariance(view, point, world_covariance(cloud, i));
  const double scale2 = static_cast<double>(frame.settings.splat_scale) *
                        static_cast<double>(frame.settings.splat_scale);
  covariance = {covariance.xx * scale2, covariance.xy * scale2, covariance.yy * scale2};
  const double before = covariance.determinant();
  covariance.xx += kDilation;
  covariance.yy += kDilation;
  const double determinant = covariance.determinant();
  if (!(determinant > 0) || !std::isfinite(determinant)) return false;
  splat.opacity = opacity_of_logit(cloud.opacity_logits[i]);
  if (frame.antialiased()) splat.opacity *= compensation(before, determinant);
  const double gamma = 2 * std::log(255 * splat.opacity);
  if (!(gamma > 0)) return false;
  splat.mean = to_pixel(view, point);
  splat.conic = {covariance.yy / determinant, -covariance.xy / determinant,
                 covariance.xx / determinant};
  if (!std::isfinite(splat.mean.x + splat.mean.y)) return false;
  const glm::dvec2 half(std::sqrt(gamma * covariance.xx), std::sqrt(gamma * covariance.yy));
  grown_range(splat.mean.x - half.x, splat.mean.x + half.x, frame.camera.width, splat.box.x0,
              splat.box.x1);
  grown_range(splat.mean.y - half.y, splat.mean.y + half.y, frame.camera.height, splat.box.y0,
              splat.box.y1);
  if (splat.box.x0 >= splat.box.x1 || splat.box.y0 >= splat.box.y1) return false;
  const glm::vec3* sh =
      cloud.sh.data() + i * static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  splat.color = sh_color<double>(frame.sh_degree(), glm::normalize(position - view.position),
                                 [sh](int k) { return glm::dvec3(sh[k]); });
  splat.depth_bits = std::bit_cast<std::uint32_t>(static_cast<float>(point.z));
  splat.gaussian = static_cast<std::uint32_t>(i);
  return true;
}

/// Composites `splats`, front to back, onto one row of pixels.
void blend_row(const FrameContext& frame, const std::vector<const ReferenceSplat*>& splats, int y,
               const Outputs& outputs, Frame& result) {
  const auto width = static_cast<std::size_t>(frame.camera.width);
  std::vector<double> transmittance(width, 1.0);
  std::vector<glm::dvec3> color(width, glm::dvec3(0));
  std::vector<std::uint32_t> considered(width, 0);
  std::vector<char> live(width, 1);
  for (const ReferenceSplat* splat : splats) {
    const double dy = y - splat->mean.y;
    for (int px = splat->box.x0; px < splat->box.x1; ++px) {
      const auto x = static_cast<std::size_t>(px);
      if (live[x] == 0) continue;
      ++considered[x];
      const double dx = px - splat->mean.x;
      const double power =
          -0.5 * (splat->conic.x * dx * dx + splat->conic.z * dy * dy) - splat->conic.y * dx * dy;
      if (power > 0) continue;
      const double alpha = std::min(0.99, splat->opacity * std::exp(power));
      if (alpha < 1.0 / 255) continue;
      const double next = transmittance[x] * (1 - alpha);
      if (next < 1e-4) {
        live[x] = 0;
        continue;
      }
      color[x] += alpha * transmittance[x] * splat->color;
      transmittance[x] = next;
    }
  }
  for (std::size_t x = 0; x < width; ++x) {
    if (outputs.evaluated)
      result.evaluated[static_cast<std::size_t>(y) * width + x] = considered[x];
    if (!outputs.color) continue;
    const glm::dvec3 value = color[x] + transmittance[x] * glm::dvec3(frame.settings.background);
    for (int c = 0; c < 3; ++c)
      result.color.at(static_cast<int>(x), y, c) = static_cast<float>(value[c]);
  }
}

}  // namespace

void render_reference(const FrameContext& frame, const Outputs& outputs, Frame& result) {
  const View<double> view = make_view<double>(frame.camera);
  constexpr std::size_t kChunk = 2048;
  std::vector<std::vector<ReferenceSplat>> chunks((frame.cloud.size() + kChunk - 1) / kChunk);
  frame.for_chunks(frame.cloud.size(), kChunk, [&](std::size_t begin, std::size_t end, int) {
    ReferenceSplat splat;
    for (std::size_t i = begin; i < end; ++i) {
      if (project_reference(frame, view, i, splat)) chunks[begin / kChunk].push_back(splat);
    }
  });

  std::vector<const ReferenceSplat*> order;
  for (const auto& chunk : chunks) {
    for (const ReferenceSplat& splat : chunk) order.push_back(&splat);
  }
  std::sort(order.begin(), order.end(), [](const ReferenceSplat* a, const ReferenceSplat* b) {
    return a->depth_bits != b->depth_bits ? a->depth_bits < b->depth_bits
                                          : a->gaussian < b->gaussian;
  });
  result.stats.visible = static_cast<std::uint32_t>(order.size());

  // Bands of rows share one list; a row takes from it the Gaussians whose box holds it.
  constexpr std::size_t kBand = 8;
  frame.for_chunks(
      static_cast<std::size_t>(frame.camera.height), kBand,
      [&](std::size_t begin, std::size_t end, int) {
        std::vector<const ReferenceSplat*> band, row;
        for (const ReferenceSplat* splat : order) {
          if (splat->box.y0 < static_cast<int>(end) && splat->box.y1 > static_cast<int>(begin))
            band.push_back(splat);
        }
        for (int y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
          row.clear();
          for (const ReferenceSplat* splat : band) {
            if (splat->box.y0 <= y && y < splat->box.y1) row.push_back(splat);
          }
          blend_row(frame, row, y, outputs, result);
        }
      });
}

}  // namespace qs::cpu
