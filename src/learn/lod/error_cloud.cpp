// SPDX-License-Identifier: MIT
#include "learn/lod/error_cloud.h"

#include <algorithm>

#include "learn/lod/cut.h"
#include "learn/lod/merging.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"

namespace qs {

GaussianCloud error_cloud(const RadLevels& levels, std::span<const std::uint32_t> cut,
                          GaussianCloud drawn, const Camera& camera) {
  RadLevels part{{}, levels.footprint};
  for (const std::uint32_t i : cut) {
    part.nodes.push_back(levels.nodes[i]);
    part.nodes.back().gains = part.nodes.back().errors;
  }
  const LodGains errors = gains_in(part, drawn, {&camera, 1}, 1);
  for (std::size_t k = 0; k < cut.size(); ++k) {
    const double h = static_cast<double>(errors.footprints[k]);
    const double v = drawn.antialiased ? 0 : static_cast<double>(kDilation) * h * h;
    const Covariance3<double> c = world_covariance(drawn, k);
    LodCovariance wide;
    std::ranges::transform(std::array{c.xx + v, c.xy, c.xz, c.yy + v, c.yz, c.zz + v}, wide.begin(),
                           [](double value) { return static_cast<float>(value); });
    // The integral of a Gaussian's opacity is twice the mean area of its projections.
    const double light = opacity_of_logit(drawn.opacity_logits[k]) *
                         static_cast<double>(ellipsoid_area(wide)) / (2 * h * h);
    const double grey = light > 0 ? static_cast<double>(errors.gains[k]) / light : 0;
    glm::vec3* const sh = sh_of(drawn, k);
    std::fill_n(sh, sh_count(drawn), glm::vec3(0));
    sh[0] = glm::vec3(static_cast<float>((grey - 0.5) / static_cast<double>(kSh0)));
  }
  return drawn;
}

}  // namespace qs
