// SPDX-License-Identifier: MIT
#include <algorithm>

#include <glm/geometric.hpp>

#include "learn/diff/cuda/color_blend.cuh"
#include "learn/diff/cuda/tiles.cuh"
#include "learn/step/cuda/forward.cuh"
#include "raster/cuda/common/footprints.cuh"
#include "raster/cuda/common/limits.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/kernel/cull/in_view.h"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/sh.h"

namespace qs::cuda::train {
namespace {

/// One thread per Gaussian. Activates in double precision, as every backend does before it decides.
/// The splats get no colours.
template <class P>
__global__ void __launch_bounds__(kThreads)
    project_gaussians(ParametersView parameters, View<float> view, FootprintRules rules,
                      TileGrid grid, diff::GpuGaussianBlock out, FootprintArrays footprints) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  unsigned tiles = 0;
  if (i < parameters.count) {
    const GaussianValues<float> gaussian = parameters.gaussian(i);
    const Covariance3<double> sigma =
        covariance_of(glm::dvec3(gaussian.log_scale), unit_rotation(glm::dquat(gaussian.rotation)));
    const double opacity = opacity_of(static_cast<double>(gaussian.opacity_logit));
    Projected projected;
    const Footprint& footprint = projected.footprint;
    const bool exists =
        !masked_out(double{gaussian.mask_logit}) &&
        project(view, rules, active_gaussian(gaussian.mean, sigma, opacity), projected);
    if (exists) tiles = count_tiles<P>(footprint, grid);
    out.tile_counts[i] = tiles;
    out.projected[i] = exists && is_in_view(footprint, grid) ? 1 : 0;
    if (tiles > 0) {
      out.depths[i] = projected.depth;
      footprints.store(i, footprint);
      const float alpha = static_cast<float>(opacity) * projected.opacity_factor;
      out.splats[i] = {make_splat(footprint, alpha, glm::vec3(0.0f)), ellipse_of(footprint)};
    }
  }
  const std::uint32_t first_place = diff::take_places(tiles, out.total);
  if (tiles > 0) out.first_places[i] = first_place;
}

/// A block in memory that grows with the frames.
template <class Block>
Block block_in(const char* what, DeviceBuffer<std::byte>& memory, const diff::GpuHeldSizes& sizes) {
  memory.reserve(what, diff::bytes_of<Block>(sizes));
  return diff::block_at<Block>(memory.data(), sizes);
}

/// Lists nothing if there are more pairs than `room`.
void enqueue_lists(const StepView& view, std::uint32_t count, std::uint32_t room,
                   ForwardFrame& frame) {
  constexpr const char* kWhat = "the step's pairs";
  diff::GpuHeldSizes sizes = frame.listed.sizes;
  sizes.pairs = room;
  frame.listed.sizes.pairs = 0;  // if memory is short
  frame.listed.pairs = block_in<diff::GpuPairBlock>(kWhat, frame.of_pairs, sizes);
  const auto unsorted = block_in<diff::ListScratch>(kWhat, frame.of_lists, sizes);
  frame.listed.sizes.pairs = room;
  diff::list_pairs(view.settings.mode, frame.listed.input(count, frame.footprints, unsorted),
                   view.stream);
}

}  // namespace

void project_view(const StepView& view, const ParametersView& parameters, ForwardFrame& frame) {
  view.throw_if_cancelled();
  constexpr const char* kWhat = "the step's Gaussians";
  diff::GpuHeldSizes& sizes = frame.listed.sizes;
  const std::uint32_t room = sizes.pairs;
  sizes = diff::GpuHeldSizes::of(view.camera, with_room(parameters.count)).blended(3, false);
  sizes.pairs = room;
  frame.listed.gaussians = block_in<diff::GpuGaussianBlock>(kWhat, frame.of_gaussians, sizes);
  frame.footprints = block_in<diff::ProjectScratch>(kWhat, frame.of_footprints, sizes).footprints;
  unsigned long long* const total = frame.listed.gaussians.total;
  set_zero("project", total, 1, view.stream);
  if (parameters.count > 0)
    with_culler(view.settings.mode, [&]<class P>(P) {
      launch("project", project_gaussians<P>, blocks_for(parameters.count), view.stream, parameters,
             make_view<float>(view.camera), footprint_rules(view.settings, view.antialiased()),
             view.grid(), frame.listed.gaussians, frame.footprints);
    });
  check(cudaMemcpyAsync(&*frame.total, total, sizeof *total, cudaMemcpyDeviceToHost, view.stream),
        "project");
  frame.total_arrived.record(view.stream);
}

void color_view(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
                cudaStream_t stream) {
  const glm::vec3 position = make_view<float>(view.camera).position;
  const int sh_degree = std::min(view.settings.sh_degree, parameters.sh_degree);
  for_each_item("color", parameters.count, stream,
                [=, tile_counts = frame.listed.gaussians.tile_counts,
                 splats = frame.listed.gaussians.splats] __device__(std::uint32_t i) {
                  if (tile_counts[i] == 0) return;
                  const glm::vec3 direction = glm::normalize(parameters.means[i] - position);
                  splats[i].splat.color = sh_color<float>(
                      sh_degree, direction, [&](int k) { return parameters.coefficient(i, k); });
                });
}

void list_view(const StepView& view, std::uint32_t count, ForwardFrame& frame) {
  const std::uint32_t room = frame.listed.sizes.pairs;
  frame.pairs = 0;
  enqueue_lists(view, count, room, frame);
  frame.total_arrived.wait();
  view.throw_if_cancelled();
  require_indexable(*frame.total);
  const auto pairs = static_cast<std::uint32_t>(*frame.total);
  if (pairs > room) {
    constexpr auto bytes_for = [](std::uint64_t number) {
      return number * (4 * sizeof(std::uint32_t) + sizeof(SortEntry));
    };
    require_memory("the step's pairs", bytes_for(pairs), bytes_for(room));
    enqueue_lists(view, count, with_headroom(pairs, UINT32_MAX, bytes_for(room), bytes_for), frame);
  }
  frame.pairs = pairs;
}

void draw_view(const StepView& view, ForwardFrame& frame) {
  const diff::GpuHeldSizes& sizes = frame.listed.sizes;
  frame.segments = diff::segments_of(frame.pairs, diff::tiles_of(sizes));
  frame.pixels = block_in<diff::GpuPixelBlock>("the step's image", frame.of_pixels, sizes);
  diff::launch_blend(frame.listed, frame.pixels, diff::TrainedView{view.settings.background},
                     view.stream);
}

}  // namespace qs::cuda::train
