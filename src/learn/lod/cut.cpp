// SPDX-License-Identifier: MIT
#include "learn/lod/cut.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "io/cloud/cloud_memory.h"
#include "learn/lod/merging.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/transform.h"

namespace qs {
namespace {

// Stores node `i` of `nodes` as Gaussian `k`, as it is drawn by a filter of the variance `v`, world
// units^2.
void put_drawn(const GaussianCloud& nodes, std::size_t i, const LodFacts& node, float v,
               GaussianCloud& cloud, std::size_t k) {
  copy_gaussian(nodes, i, cloud, k);
  if (node.child_count == 0 || v == 0) return;
  const DrawnLod shown = drawn_faint(merged_node(nodes, i, node), v);
  cloud.opacity_logits[k] = std::log(shown.opacity / (1 - shown.opacity));
  if (node.layers <= 1 && shown.opacity < 1) return;
  const auto& s = shown.covariance;
  set_covariance(cloud, k, glm::dmat3(s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]));
}

}  // namespace

LodGaussian merged_node(const GaussianCloud& nodes, std::size_t i, const LodFacts& node) {
  // The file has the node as it is drawn without a filter.
  const Covariance3<double> c = world_covariance(nodes, i);
  const double growth = node.layers > 1 ? static_cast<double>(harmonic_number(node.layers)) : 1;
  const std::array<double, 6> grown{c.xx, c.xy, c.xz, c.yy, c.yz, c.zz};
  LodGaussian gaussian;
  for (std::size_t axes = 0; axes < 6; ++axes)
    gaussian.covariance[axes] = static_cast<float>(grown[axes] / growth);
  gaussian.mass = node.layers * ellipsoid_area(gaussian.covariance);
  gaussian.opacities = node.opacities;
  gaussian.is_leaf = false;
  return gaussian;
}

float filter_variance(const LodPages& tree, std::size_t page, std::size_t row, const LodView& view,
                      double dilation) {
  if (tree.footprint == 0 || tree.pages[page]->nodes[row].child_count == 0) return 0;
  const auto [center, radius] = lod_ball(*tree.pages[page], row, tree.placement(page));
  const float footprint = view(center, radius).footprint;
  return static_cast<float>(dilation) * footprint * footprint;
}

float put_node(const LodPages& tree, std::size_t page, std::size_t row, const LodView& view,
               double dilation, GaussianCloud& cloud, std::size_t k) {
  const float variance = filter_variance(tree, page, row, view, dilation);
  const LodPlacement* const placement = tree.placement(page);
  const float unit = placement ? placement->scale * placement->scale : 1;
  put_drawn(tree.pages[page]->cloud, row, tree.pages[page]->nodes[row], variance / unit, cloud, k);
  if (placement) placement->apply(cloud, k);
  return variance;
}

CutPlaces::CutPlaces(const LodPages& tree, const LodCut& cut) {
  if (std::ranges::all_of(
          cut.parts, [&](const LodPart& part) { return tree.pages[part.page]->numbers.empty(); }))
    return;
  // The instance, the number and k.
  std::vector<std::tuple<const LodPlacement*, std::uint32_t, std::uint32_t>> order;
  for (const LodPart& part : cut.parts)
    part.for_each([&, &numbers = tree.pages[part.page]->numbers](std::size_t row) {
      order.emplace_back(tree.placement(part.page), numbers.empty() ? kNoNumber : numbers[row],
                         static_cast<std::uint32_t>(order.size()));
    });
  std::ranges::sort(order);
  places_.resize(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) places_[std::get<2>(order[i])] = i;
}

std::vector<std::size_t> starts_of_parts(const LodCut& cut) {
  std::vector<std::size_t> starts(1);
  for (const LodPart& part : cut.parts) starts.push_back(starts.back() + part.count);
  return starts;
}

GaussianCloud cut_cloud(const LodPages& tree, const LodCut& cut, const LodView& view,
                        double dilation, ThreadPool& pool, std::vector<float>* variances,
                        int degree, std::size_t least) {
  const GaussianCloud& top = tree.pages[0]->cloud;
  GaussianCloud cloud = make_cloud(std::max(cut.count, least), std::min(degree, top.sh_degree));
  cloud.antialiased = top.antialiased;
  cloud.origin = top.origin;
  if (variances) variances->resize(cloud.size());
  const CutPlaces places(tree, cut);
  const std::vector<std::size_t> starts = starts_of_parts(cut);
  pool.for_each(cut.parts.size(), 1, [&](std::size_t p) {
    std::size_t k = starts[p];
    cut.parts[p].for_each([&](std::size_t row) {
      const std::size_t place = places[k++];
      const float variance = put_node(tree, cut.parts[p].page, row, view, dilation, cloud, place);
      if (variances) (*variances)[place] = variance;
    });
  });
  constexpr std::size_t kGrain = 1024;
  pool.for_each(cloud.size() - cut.count, kGrain,
                [&](std::size_t i) { copy_gaussian(cloud, cut.count - 1, cloud, cut.count + i); });
  return cloud;
}

}  // namespace qs
