// SPDX-License-Identifier: MIT
#include "learn/lod/error_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "learn/lod/cut.h"
#include "learn/lod/merging.h"
#include "raster/kernel/constants.h"
#include "raster/scene/activated_cloud.h"

namespace qs {
namespace {

void paint(GaussianCloud& cloud, std::size_t k, double grey) {
  glm::vec3* const sh = sh_of(cloud, k);
  std::fill_n(sh, sh_count(cloud), glm::vec3(0));
  sh[0] = glm::vec3(static_cast<float>((grey - 0.5) / static_cast<double>(kSh0)));
}

// The grey of a node that is Gaussian `k` of the cloud. `scale`: of its instance.
double grey_of_error(LodFacts node, float scale, float smallest, const LodView& view,
                     double dilation, const GaussianCloud& drawn, std::size_t k) {
  node.gains = node.errors;
  const float footprint = view(drawn.positions[k], scale * node.radius).footprint;
  const double h = static_cast<double>(footprint), v = dilation * h * h;
  const Covariance3<double> c = world_covariance(drawn, k);
  LodCovariance wide;
  std::ranges::transform(std::array{c.xx + v, c.xy, c.xz, c.yy + v, c.yz, c.zz + v}, wide.begin(),
                         [](double value) { return static_cast<float>(value); });
  // The integral of a Gaussian's opacity is twice the mean area of its projections.
  const double light = opacity_of_logit(drawn.opacity_logits[k]) *
                       static_cast<double>(ellipsoid_area(wide)) / (2 * h * h);
  return light > 0 ? static_cast<double>(lod_gain(node, smallest, footprint / scale)) / light : 0;
}

double grey_of_level(const LodFacts& node) {
  return node.child_count == 0
             ? 0
             : (1 + std::floor(std::log2(std::max(static_cast<double>(node.opacities), 1.0)))) /
                   255;
}

}  // namespace

void paint_levels(const LodPages& tree, const LodCut& cut, const LodView& view, double dilation,
                  bool errors, GaussianCloud& drawn) {
  const CutPlaces places(tree, cut);
  std::size_t node_of_cut = 0;
  for (const LodPart& part : cut.parts) {
    const LodPlacement* const placement = tree.placement(part.page);
    const float scale = placement ? placement->scale : 1;
    part.for_each([&](std::size_t row) {
      const std::size_t k = places[node_of_cut++];
      const LodFacts& node = tree.pages[part.page]->nodes[row];
      paint(drawn, k,
            errors ? grey_of_error(node, scale, tree.footprint, view, dilation, drawn, k)
                   : grey_of_level(node));
    });
  }
}

}  // namespace qs
