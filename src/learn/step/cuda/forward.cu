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

struct ProjectInput {
  ParametersView parameters;
  View<float> view;
  FootprintRules rules;
  TileGrid grid;
};

struct ProjectOutput {
  std::uint32_t* tile_counts;
  FootprintArrays footprints;
  std::uint32_t *depth_keys, *first_places;
  unsigned long long* pairs;  ///< their number is added
  ListedSplat* splats;        ///< without colours
  std::uint8_t* in_view;
};

/// Activates in double precision, as every backend does before it decides. Returns the number of
/// tiles.
template <class P>
__device__ unsigned project_gaussian(const ProjectInput& in, const ProjectOutput& out,
                                     std::uint32_t i) {
  const GaussianValues<float> gaussian = in.parameters.gaussian(i);
  const Covariance3<double> sigma =
      covariance_of(glm::dvec3(gaussian.log_scale), unit_rotation(glm::dquat(gaussian.rotation)));
  const double opacity = opacity_of(static_cast<double>(gaussian.opacity_logit));
  Projected projected;
  const bool exists =
      !masked_out(double{gaussian.mask_logit}) &&
      project(in.view, in.rules, active_gaussian(gaussian.mean, sigma, opacity), projected);
  const unsigned tiles = exists ? count_tiles<P>(projected.footprint, in.grid) : 0;
  out.tile_counts[i] = tiles;
  out.in_view[i] = exists && is_in_view(projected.footprint, in.grid) ? 1 : 0;
  if (tiles == 0) return 0;

  out.depth_keys[i] = __float_as_uint(projected.depth);
  out.footprints.store(i, projected.footprint);
  out.splats[i] = {
      make_splat(projected.footprint, static_cast<float>(opacity) * projected.opacity_factor,
                 glm::vec3(0.0f)),
      ellipse_of(projected.footprint)};
  return tiles;
}

/// One thread per Gaussian.
template <class P>
__global__ void __launch_bounds__(kThreads) project_gaussians(ProjectInput in, ProjectOutput out) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  const unsigned tiles = i < in.parameters.count ? project_gaussian<P>(in, out, i) : 0;
  const std::uint32_t first_place = diff::take_places(tiles, out.pairs);
  if (tiles > 0) out.first_places[i] = first_place;
}

/// Lists nothing if there are more pairs than frame.pairs has room for.
void enqueue_lists(const StepView& view, std::uint32_t count, ForwardFrame& frame) {
  ListedPairs& pairs = frame.pairs;
  diff::list_pairs(
      view.settings.mode,
      {count,
       frame.tile_counts.data(),
       frame.first_places.data(),
       frame.footprints.arrays(),
       view.grid(),
       {frame.total.sum.data(), pairs.room(), frame.depth_keys.data(), pairs.owners.data(),
        pairs.tiles.data(), pairs.slots.data(), pairs.entries.data(), pairs.places.data(),
        frame.lists.sizes.data(), frame.lists.ranges.data(), frame.lists.class_sizes.data(),
        frame.lists.scheduled.data(), static_cast<unsigned>(view.grid().count())}},
      view.stream);
}

}  // namespace

void project_view(const StepView& view, const ParametersView& parameters, ForwardFrame& frame) {
  view.throw_if_cancelled();
  constexpr const char* kWhat = "the step's Gaussians";
  const std::size_t room = with_room(parameters.count);
  frame.tile_counts.reserve(kWhat, room);
  frame.footprints.reserve(kWhat, room);
  frame.splats.reserve(kWhat, room);
  frame.in_view.reserve(kWhat, room);
  frame.first_places.reserve(kWhat, room);
  frame.depth_keys.reserve(kWhat, room);
  frame.total.sum.reserve(kWhat, 1);
  set_zero("project", frame.total.sum.data(), 1, view.stream);
  if (parameters.count > 0) {
    with_culler(view.settings.mode, [&]<class P>(P) {
      const ProjectInput in{parameters, make_view<float>(view.camera),
                            footprint_rules(view.settings, view.antialiased()), view.grid()};
      launch("project", project_gaussians<P>, blocks_for(parameters.count), view.stream, in,
             ProjectOutput{frame.tile_counts.data(), frame.footprints.arrays(),
                           frame.depth_keys.data(), frame.first_places.data(),
                           frame.total.sum.data(), frame.splats.data(), frame.in_view.data()});
    });
  }
  check(cudaMemcpyAsync(&*frame.total.copy, frame.total.sum.data(), sizeof(unsigned long long),
                        cudaMemcpyDeviceToHost, view.stream),
        "project");
  frame.total.arrived.record(view.stream);
}

void color_view(const StepView& view, const ParametersView& parameters, ForwardFrame& frame,
                cudaStream_t stream) {
  const glm::vec3 position = make_view<float>(view.camera).position;
  const int sh_degree = std::min(view.settings.sh_degree, parameters.sh_degree);
  for_each_item("color", parameters.count, stream,
                [=, tile_counts = frame.tile_counts.data(),
                 splats = frame.splats.data()] __device__(std::uint32_t i) {
                  if (tile_counts[i] == 0) return;
                  const glm::vec3 direction = glm::normalize(parameters.means[i] - position);
                  splats[i].splat.color = sh_color<float>(
                      sh_degree, direction, [&](int k) { return parameters.coefficient(i, k); });
                });
}

void ListedPairs::reserve(std::uint32_t pairs) {
  if (pairs <= room()) return;  // places is reserved last
  constexpr const char* kWhat = "the step's pairs";
  constexpr auto bytes_for = [](std::uint64_t count) {
    return count * (4 * sizeof(std::uint32_t) + sizeof(SortEntry));
  };
  const std::uint64_t held = bytes_for(room());
  require_memory(kWhat, bytes_for(pairs), held);
  const std::uint32_t more = with_headroom(pairs, UINT32_MAX, held, bytes_for);
  places.release();
  for (auto* buffer : {&owners, &tiles, &slots}) buffer->reserve(kWhat, more);
  entries.reserve(kWhat, more);
  places.reserve(kWhat, more);
}

void TileLists::reserve(unsigned tiles) {
  constexpr const char* kWhat = "the step's tiles";
  sizes.reserve(kWhat, tiles);
  ranges.reserve(kWhat, tiles);
  class_sizes.reserve(kWhat, kLengthClasses);
  scheduled.reserve(kWhat, std::size_t{kLengthClasses} * tiles);
}

void list_view(const StepView& view, std::uint32_t count, ForwardFrame& frame) {
  frame.pairs.count = 0;
  frame.lists.reserve(static_cast<unsigned>(view.grid().count()));
  enqueue_lists(view, count, frame);
  frame.total.arrived.wait();
  view.throw_if_cancelled();
  require_indexable(*frame.total.copy);
  const auto pairs = static_cast<std::uint32_t>(*frame.total.copy);
  if (pairs > frame.pairs.room()) {
    frame.pairs.reserve(pairs);
    enqueue_lists(view, count, frame);
  }
  frame.pairs.count = pairs;
}

void draw_view(const StepView& view, ForwardFrame& frame) {
  constexpr const char* kWhat = "the step's image";
  const std::size_t pixels = view.pixels();
  const auto tiles = static_cast<unsigned>(view.grid().count());
  frame.segments = diff::segments_of(frame.pairs.count, tiles);
  const std::size_t room = std::max(diff::segments_of(frame.pairs.room(), tiles), frame.segments);
  frame.color.reserve(kWhat, pixels);
  frame.transmittance.reserve(kWhat, pixels);
  frame.last.reserve(kWhat, pixels);
  frame.segment_tiles.reserve("the step's segments", room);
  frame.states.reserve("the step's segments", room * kTilePixels);
  check(cudaMemsetAsync(frame.segment_tiles.data(), 0xff, frame.segments * sizeof(std::uint32_t),
                        view.stream),
        "blend");
  launch("blend", diff::blend_tiles<diff::TrainedView>, tiles, view.stream,
         frame.lists.schedule(tiles), frame.tiles(view),
         diff::TrainedView{view.settings.background},
         diff::BlendTarget{frame.color.data(), frame.transmittance.data(), frame.last.data(),
                           frame.segment_tiles.data(), frame.states.data()});
}

}  // namespace qs::cuda::train
