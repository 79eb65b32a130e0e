// SPDX-License-Identifier: MIT
#include "learn/lod/cut.h"

#include <algorithm>
#include <cmath>

#include "io/cloud/cloud_memory.h"
#include "learn/lod/merging.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/transform.h"

namespace qs {
namespace {

constexpr float kSmallestDepth = 1e-3f;  // of a ball around a camera, in depths of its near plane

// Gain of a node at a footprint, per square of the footprint.
float gain_of(const LodNode& node, float smallest, float footprint) {
  if (node.child_count == 0) return 0;
  const float place = std::clamp(std::log2(footprint / smallest) / std::log2(kLodFootprintRatio),
                                 0.0f, static_cast<float>(kLodFootprints - 1));
  const auto below = std::min(static_cast<std::size_t>(place), kLodFootprints - 2);
  const float part = place - static_cast<float>(below);
  const float step = static_cast<float>(node.gains[below]) * (1 - part) +
                     static_cast<float>(node.gains[below + 1]) * part;
  return smallest * smallest * std::exp2(step / 4 - 28) / (footprint * footprint);
}

}  // namespace

LodGains gains_at(const RadLevels& levels, float footprint) {
  LodGains result;
  result.footprints.assign(levels.nodes.size(), footprint);
  for (const LodNode& node : levels.nodes)
    result.gains.push_back(gain_of(node, levels.footprint, footprint));
  return result;
}

LodGains gains_in(const RadLevels& levels, const GaussianCloud& nodes,
                  std::span<const Camera> cameras, float outside) {
  LodGains result;
  const std::size_t count = levels.nodes.size();
  result.footprints.assign(count, INFINITY);
  result.gains.assign(count, 0);
  for (const Camera& camera : cameras) {
    const auto near = static_cast<float>(camera.near_depth);
    const glm::vec2 focal(camera.focal_px), center(camera.center_px);
    const float mean_focal = std::sqrt(focal.x * focal.y);
    for (std::size_t i = 0; i < count; ++i) {
      const float radius = levels.nodes[i].radius;
      const glm::vec3 at(camera.view_from_world * glm::dvec4(glm::dvec3(nodes.positions[i]), 1));
      // The planes of the frustum: distance of the ball's centre to each, outward.
      const auto beyond = [&](float along, float f, float pixels) {
        return (along * f - at.z * pixels) / std::sqrt(f * f + pixels * pixels);
      };
      const auto width = static_cast<float>(camera.width),
                 height = static_cast<float>(camera.height);
      const float farthest =
          std::max({near - at.z, beyond(at.x, focal.x, width - center.x),
                    beyond(-at.x, focal.x, center.x + 1), beyond(at.y, focal.y, height - center.y),
                    beyond(-at.y, focal.y, center.y + 1)});
      const bool is_inside = farthest <= radius;
      const float depth = (is_inside ? at.z : glm::length(at)) - radius;
      const float footprint = std::max(depth, kSmallestDepth * near) / mean_focal;
      result.footprints[i] = std::min(result.footprints[i], footprint);
      result.gains[i] +=
          (is_inside ? 1 : outside) * gain_of(levels.nodes[i], levels.footprint, footprint);
    }
  }
  return result;
}

std::vector<std::uint32_t> choose_cut(const RadLevels& levels, const LodGains& gains,
                                      std::size_t budget) {
  // Nodes collapse in the order of their gains; of equal ones, children do before their parents,
  // which have smaller numbers.
  std::vector<std::uint32_t> merged;
  for (std::uint32_t i = 0; i < levels.nodes.size(); ++i)
    if (levels.nodes[i].child_count > 0) merged.push_back(i);
  std::size_t count = levels.nodes.size() - merged.size();
  std::ranges::sort(merged, [&](std::uint32_t a, std::uint32_t b) {
    return gains.gains[a] != gains.gains[b] ? gains.gains[a] < gains.gains[b] : a > b;
  });
  std::vector<bool> is_open(levels.nodes.size(), false);
  for (const std::uint32_t i : merged) {
    is_open[i] = count <= budget;
    if (!is_open[i]) count -= levels.nodes[i].child_count - 1u;
  }
  std::vector<std::uint32_t> cut;
  for (std::uint32_t i = 0; i < levels.nodes.size(); ++i)
    if (!is_open[i] && (i == 0 || is_open[levels.nodes[i].parent])) cut.push_back(i);
  return cut;
}

GaussianCloud cut_cloud(const RadLevels& levels, const GaussianCloud& nodes,
                        std::span<const std::uint32_t> cut, const LodGains& gains) {
  GaussianCloud cloud = make_cloud(cut.size(), nodes.sh_degree);
  cloud.antialiased = nodes.antialiased;
  cloud.origin = nodes.origin;
  for (std::size_t k = 0; k < cut.size(); ++k) {
    const std::uint32_t i = cut[k];
    copy_gaussian(nodes, i, cloud, k);
    const LodNode& node = levels.nodes[i];
    if (node.child_count == 0 || nodes.antialiased) continue;
    // The file has the node as it is drawn without a filter.
    const Covariance3<double> c = world_covariance(nodes, i);
    const double growth = node.layers > 1 ? static_cast<double>(harmonic_number(node.layers)) : 1;
    const std::array<double, 6> grown{c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
    LodGaussian gaussian;
    for (std::size_t v = 0; v < 6; ++v)
      gaussian.covariance[v] = static_cast<float>(grown[v] / growth);
    gaussian.mass = node.layers * ellipsoid_area(gaussian.covariance);
    gaussian.opacities = node.opacities;
    gaussian.is_leaf = false;
    const float footprint = gains.footprints[i];
    const DrawnLod shown = drawn(gaussian, static_cast<float>(kDilation) * footprint * footprint);
    cloud.opacity_logits[k] = std::log(shown.opacity / (1 - shown.opacity));
    if (node.layers <= 1 && shown.opacity < 1) continue;
    const auto& s = shown.covariance;
    set_covariance(cloud, k, glm::dmat3(s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]));
  }
  return cloud;
}

}  // namespace qs
