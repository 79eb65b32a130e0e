// SPDX-License-Identifier: MIT
#include "raster/cpu/common/reference.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <glm/geometric.hpp>

#include "raster/kernel/depth.h"
#include "raster/kernel/sh.h"
#include "raster/scene/activated_cloud.h"

namespace qs::cpu {
namespace {

struct ReferenceSplat {
  glm::dvec2 mean;
  Covariance2<double> covariance;
  glm::dvec3 conic;  // (a, b, c) of a dx^2 + 2 b dx dy + c dy^2
  double opacity;
  glm::dvec3 color;
  PixelBox box;
  double gamma, depth;
  std::uint32_t depth_bits, gaussian;
};

/// Pixels from floor(low) to ceil(high) and one more on each side, clamped to [first, limit).
void grown_range(double low, double high, int first, int limit, int& begin, int& end) {
  const auto clamped = [&](double x) {
    return static_cast<int>(std::clamp(x, static_cast<double>(first), static_cast<double>(limit)));
  };
  begin = clamped(std::floor(low) - 1);
  end = clamped(std::ceil(high) + 2);
}

bool project_reference(const FrameContext& frame, const View<double>& view, const PixelBox& region,
                       std::size_t i, ReferenceSplat& splat) {
  const GaussianCloud& cloud = frame.cloud;
  // Project the mean and the covariance.
  const glm::dvec3 position(cloud.positions[i]);
  const glm::dvec3 in_view = to_view(view, position);
  splat.depth = depth_of(view, in_view);
  if (!(splat.depth > view.near_depth)) return false;
  const glm::dvec3 point = projected_point(view, in_view);
  Covariance2<double> covariance = project_covariance(view, point, world_covariance(cloud, i));
  const DrawnShape shape = drawn_shape(frame.settings);
  const double scale2 = shape.splat_scale * shape.splat_scale;
  covariance = {covariance.xx * scale2, covariance.xy * scale2, covariance.yy * scale2};
  const double before = covariance.determinant();
  dilate(view, SlopeLimits<double>::of(view), point, shape.dilation, covariance);
  const double determinant = covariance.determinant();
  if (!(determinant > 0) || !std::isfinite(determinant)) return false;
  // Drop the Gaussian if no pixel can have alpha >= 1/255.
  splat.opacity = opacity_of_logit(cloud.opacity_logits[i]);
  if (is_solid(frame.settings.style)) {
    if (!(splat.opacity > shape.least_opacity)) return false;
    splat.opacity = std::exp2(double{kSolidLog2});
  } else if (frame.antialiased()) {
    splat.opacity *= compensation(before, determinant);
  }
  const double gamma = splat.gamma = 2 * std::log(255 * splat.opacity);
  if (!(gamma > 0)) return false;
  // Store the ellipse and its box of pixels in the region.
  splat.covariance = covariance;
  splat.mean = to_pixel(view, point);
  splat.conic = {covariance.yy / determinant, -covariance.xy / determinant,
                 covariance.xx / determinant};
  if (!std::isfinite(splat.mean.x + splat.mean.y)) return false;
  const glm::dvec2 half(std::sqrt(gamma * covariance.xx), std::sqrt(gamma * covariance.yy));
  grown_range(splat.mean.x - half.x, splat.mean.x + half.x, region.x0, region.x1, splat.box.x0,
              splat.box.x1);
  grown_range(splat.mean.y - half.y, splat.mean.y + half.y, region.y0, region.y1, splat.box.y0,
              splat.box.y1);
  if (splat.box.x0 >= splat.box.x1 || splat.box.y0 >= splat.box.y1) return false;
  // Evaluate the colour.
  const glm::vec3* sh =
      cloud.sh.data() + i * static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  splat.color = sh_color<double>(frame.sh_degree(), glm::normalize(position - view.position),
                                 [sh](int k) { return glm::dvec3(sh[k]); });
  splat.depth_bits = std::bit_cast<std::uint32_t>(static_cast<float>(splat.depth));
  splat.gaussian = static_cast<std::uint32_t>(i);
  return true;
}

/// Composites `splats`, front to back, onto one row of the region's pixels.
void blend_row(const FrameContext& frame, const PixelBox& region,
               const std::vector<const ReferenceSplat*>& splats, int y, const Outputs& outputs,
               Frame& result) {
  const auto width = static_cast<std::size_t>(frame.camera.width);
  std::vector<PixelDepth<double>> pixels(width);
  std::vector<glm::dvec3> color(width, glm::dvec3(0));
  std::vector<std::uint32_t> considered(width, 0);
  std::vector<char> live(width, 1);
  const double least_transmittance = frame.least_transmittance();
  for (const ReferenceSplat* splat : splats) {
    // Composite the Gaussian onto the live pixels of its box.
    const double dy = y - splat->mean.y;
    for (int px = splat->box.x0; px < splat->box.x1; ++px) {
      const auto x = static_cast<std::size_t>(px);
      if (live[x] == 0) continue;
      ++considered[x];
      const double dx = px - splat->mean.x;
      const double power =
          -0.5 * (splat->conic.x * dx * dx + splat->conic.z * dy * dy) - splat->conic.y * dx * dy;
      if (power > 0) continue;
      const double alpha = std::min(fp64::kAlphaMax, splat->opacity * std::exp(power));
      if (alpha < fp64::kAlphaMin) continue;
      const double next = pixels[x].transmittance * (1 - alpha);
      if (next < least_transmittance) {
        live[x] = 0;
        continue;
      }
      color[x] += alpha * pixels[x].transmittance * splat->color;
      pixels[x].add(alpha, splat->depth, next);
    }
  }
  // Store the maps that were asked for.
  for (auto x = static_cast<std::size_t>(region.x0); x < static_cast<std::size_t>(region.x1); ++x) {
    const std::size_t at = frame.pixel(static_cast<int>(x), y);
    if (outputs.evaluated) result.evaluated[at] = considered[x];
    if (outputs.depth) {
      result.depth.alpha[at] = static_cast<float>(pixels[x].alpha());
      result.depth.expected[at] = static_cast<float>(pixels[x].expected());
      result.depth.median[at] = static_cast<float>(pixels[x].median);
    }
    if (!outputs.color) continue;
    const glm::dvec3 value =
        color[x] + pixels[x].transmittance * glm::dvec3(frame.settings.background);
    for (int c = 0; c < 3; ++c)
      result.color.at(static_cast<int>(x), y, c) = static_cast<float>(value[c]);
  }
}

void collect_trace(const std::vector<std::vector<ReferenceSplat>>& chunks,
                   const std::vector<const ReferenceSplat*>& order, Trace& trace) {
  for (const auto& chunk : chunks) {
    for (const ReferenceSplat& splat : chunk) {
      const Covariance2<float> covariance{static_cast<float>(splat.covariance.xx),
                                          static_cast<float>(splat.covariance.xy),
                                          static_cast<float>(splat.covariance.yy)};
      trace.gaussians.push_back(splat.gaussian);
      trace.footprints.push_back({glm::vec2(splat.mean), covariance, glm::vec3(splat.conic),
                                  static_cast<float>(splat.covariance.determinant()),
                                  static_cast<float>(splat.gamma)});
      trace.depths.push_back(std::bit_cast<float>(splat.depth_bits));
      trace.splats.push_back(make_splat(trace.footprints.back(), static_cast<float>(splat.opacity),
                                        glm::vec3(splat.color)));
    }
  }
  for (const ReferenceSplat* splat : order) trace.listed.push_back(splat->gaussian);
  trace.tile_begin = {0, order.size()};
}

}  // namespace

void render_reference(const FrameContext& frame, const Outputs& outputs, Frame& result) {
  const View<double> view = make_view<double>(frame.camera);
  const PixelBox whole{0, 0, frame.camera.width, frame.camera.height};
  PixelBox region = outputs.region.value_or(whole);
  region.x0 = std::clamp(region.x0, 0, whole.x1);
  region.y0 = std::clamp(region.y0, 0, whole.y1);
  region.x1 = std::clamp(region.x1, region.x0, whole.x1);
  region.y1 = std::clamp(region.y1, region.y0, whole.y1);
  if (outputs.region)  // clears an earlier frame outside of the region
    std::fill(result.color.values.begin(), result.color.values.end(), 0.0f);
  constexpr std::size_t kChunk = 2048;
  std::vector<std::vector<ReferenceSplat>> chunks((frame.cloud.size() + kChunk - 1) / kChunk);
  frame.for_chunks(frame.cloud.size(), kChunk, [&](std::size_t begin, std::size_t end, int) {
    ReferenceSplat splat;
    for (std::size_t i = begin; i < end; ++i)
      if (frame.draws(i) && project_reference(frame, view, region, i, splat))
        chunks[begin / kChunk].push_back(splat);
  });

  std::vector<const ReferenceSplat*> order;
  for (const auto& chunk : chunks)
    for (const ReferenceSplat& splat : chunk) order.push_back(&splat);
  std::sort(order.begin(), order.end(), [](const ReferenceSplat* a, const ReferenceSplat* b) {
    return a->depth_bits != b->depth_bits ? a->depth_bits < b->depth_bits
                                          : a->gaussian < b->gaussian;
  });
  result.stats.visible = static_cast<std::uint32_t>(order.size());
  if (outputs.trace) collect_trace(chunks, order, result.trace);

  // Rows of a band share one list, and each row uses the Gaussians whose boxes contain it.
  constexpr std::size_t kBand = 8;
  frame.for_frame(static_cast<std::size_t>(region.y1 - region.y0), kBand,
                  [&](std::size_t first, std::size_t last, int) {
                    const int begin = region.y0 + static_cast<int>(first);
                    const int end = region.y0 + static_cast<int>(last);
                    std::vector<const ReferenceSplat*> band, row;
                    for (const ReferenceSplat* splat : order)
                      if (splat->box.y0 < end && splat->box.y1 > begin) band.push_back(splat);
                    for (int y = begin; y < end; ++y) {
                      row.clear();
                      for (const ReferenceSplat* splat : band)
                        if (splat->box.y0 <= y && y < splat->box.y1) row.push_back(splat);
                      blend_row(frame, region, row, y, outputs, result);
                    }
                  });
}

}  // namespace qs::cpu
