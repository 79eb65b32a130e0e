// SPDX-License-Identifier: MIT
#include <algorithm>

#include <glm/geometric.hpp>

#include "raster/cuda/footprint_rules.cuh"
#include "raster/cuda/stages/segment.cuh"
#include "raster/cuda/train/forward.cuh"
#include "raster/cuda/warp.cuh"
#include "raster/kernel/cull/in_view.h"
#include "raster/kernel/cull/modes.h"
#include "raster/kernel/sh.h"

namespace qs::cuda::train {
namespace {

using stages::Contribution;
using stages::SharedSegment;

static_assert(kThreads == kTilePixels);

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
  const std::uint32_t first_place = stages::take_places(tiles, out.pairs);
  if (tiles > 0) out.first_places[i] = first_place;
}

/// Sets the colours of the visible Gaussians. One thread per Gaussian.
__global__ void __launch_bounds__(kThreads)
    color_gaussians(ParametersView parameters, glm::vec3 position, int sh_degree,
                    const std::uint32_t* tile_counts, ListedSplat* splats) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= parameters.count || tile_counts[i] == 0) return;
  const glm::vec3 direction = glm::normalize(parameters.means[i] - position);
  splats[i].splat.color =
      sh_color<float>(sh_degree, direction, [&](int k) { return parameters.coefficient(i, k); });
}

struct BlendTarget {
  glm::vec3* color;
  float* transmittance;
  std::uint32_t* last;
  std::uint32_t* segment_tiles;
  float4* states;
  glm::vec3 background;
};

/// The entries of a segment that reach each warp of a block, in their order.
struct WarpLists {
  static constexpr unsigned kAtOnce = 4;  ///< entries in one read
  alignas(std::uint32_t) std::uint8_t entries[kTilePixels / kWarp][kSegment];

  /// Entry at + k of this warp's list, for k < kAtOnce, is byte k. `at` is a multiple of kAtOnce.
  __device__ std::uint32_t read(unsigned at) const {
    return reinterpret_cast<const std::uint32_t*>(entries[threadIdx.x / kWarp])[at / kAtOnce];
  }

  /// Fills the list of this warp and returns its size. All lanes call it.
  __device__ unsigned fill(const SharedSegment& segment, std::uint32_t size) {
    std::uint8_t* const own = entries[threadIdx.x / kWarp];
    unsigned count = 0;
    __syncwarp();  // the list may be in use
    for (std::uint32_t group = 0; group < size; group += kWarp) {
      const unsigned all = segment.reaching(group, size);
      if ((all >> lane_index() & 1) != 0) {
        own[count + static_cast<unsigned>(__popc(all & lanes_below()))] =
            static_cast<std::uint8_t>(group + lane_index());
      }
      count += static_cast<unsigned>(__popc(all));
    }
    __syncwarp();
    return count;
  }
};

/// The pixel of a thread while it is composited.
struct BlendPixel {
  float open;  ///< the transmittance, or 0 if the pixel has stopped
  glm::vec3 color{0};
  float transmittance = 1;
  std::uint32_t last = 0;  ///< entries up to the last blended entry

  __device__ bool live() const { return open > 0.0f; }

  /// `end` counts the tile's entries up to the Gaussian.
  __device__ void add(const Contribution& by, bool exists, std::uint32_t end) {
    const bool counts = exists && by.counts;
    const float next = by.behind(open);
    const bool blends = counts && !(next < kTransmittanceMin);
    const float weight = by.alpha * open;
    open = blends ? next : counts ? 0.0f : open;
    if (!blends) return;
    color = {fmaf(weight, by.light.z, color.x), fmaf(weight, by.light.w, color.y),
             fmaf(weight, by.blue, color.z)};
    transmittance = next;
    last = end;
  }
};

/// A tile is one block with one thread per pixel.
__global__ void __launch_bounds__(kThreads)
    blend_tiles(ScheduleView schedule, TilesView in, BlendTarget out) {
  // Contributions that are computed before the first of them is composited, because they do not
  // depend on each other. The time of the longest list depends on it.
  constexpr unsigned kAtOnce = WarpLists::kAtOnce;
  __shared__ SharedSegment segment;
  __shared__ WarpLists reaching;
  const std::uint32_t tile = schedule.tile(blockIdx.x);
  const unsigned thread = threadIdx.x;
  const int x = in.x_of(tile, thread), y = in.y_of(tile, thread);
  const auto px = static_cast<float>(x), py = static_cast<float>(y);
  const bool inside = in.contains(x, y);
  const uint2 range = in.ranges[tile];
  std::size_t index = first_segment(range.x, tile);

  BlendPixel pixel{inside ? 1.0f : 0.0f};
  std::uint32_t first = range.x;
  for (; first < range.y; first += kSegment, ++index) {
    if (__syncthreads_count(pixel.live()) == 0) break;
    const std::uint32_t size = min(range.y - first, kSegment);
    segment.load(in, tile, first, size);
    if (thread == 0) out.segment_tiles[index] = tile;
    out.states[index * kTilePixels + thread] = {pixel.color.x, pixel.color.y, pixel.color.z,
                                                pixel.transmittance};
    __syncthreads();
    bool any = __any_sync(kAllLanes, pixel.live());
    const unsigned count = any ? reaching.fill(segment, size) : 0;
    for (unsigned at = 0; at < count && any; at += kAtOnce) {
      const std::uint32_t read = reaching.read(at);
      std::uint32_t entries[kAtOnce];
      Contribution by[kAtOnce];
#pragma unroll
      for (unsigned k = 0; k < kAtOnce; ++k) {
        entries[k] = read >> (8 * k) & 0xff;
        by[k] = segment.contribution(entries[k], px, py);
      }
#pragma unroll
      for (unsigned k = 0; k < kAtOnce; ++k)
        pixel.add(by[k], at + k < count, first - range.x + entries[k] + 1);
      any = __any_sync(kAllLanes, pixel.live());
    }
  }
  // Segments that no pixel reached have no gradient. The backward pass writes zeros for them.
  for (std::uint32_t rest = first + kSegment * thread; rest < range.y; rest += kSegment * kThreads)
    out.segment_tiles[first_segment(range.x, tile) + (rest - range.x) / kSegment] = tile;

  if (!inside) return;
  const std::size_t at = in.index_of(x, y);
  out.color[at] = pixel.color + pixel.transmittance * out.background;
  out.transmittance[at] = pixel.transmittance;
  out.last[at] = pixel.last;
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
  check(cudaMemsetAsync(frame.total.sum.data(), 0, sizeof(unsigned long long), view.stream),
        "project");
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
  if (parameters.count == 0) return;
  launch("color", color_gaussians, blocks_for(parameters.count), stream, parameters,
         make_view<float>(view.camera).position,
         std::min(view.settings.sh_degree, parameters.sh_degree), frame.tile_counts.data(),
         frame.splats.data());
}

void draw_view(const StepView& view, ForwardFrame& frame) {
  constexpr const char* kWhat = "the step's image";
  const std::size_t pixels = view.pixels();
  const auto tiles = static_cast<unsigned>(view.grid().count());
  frame.segments = frame.pairs.count / kSegment + tiles;
  const std::size_t room = std::max(frame.pairs.room() / kSegment + tiles, frame.segments);
  frame.color.reserve(kWhat, pixels);
  frame.transmittance.reserve(kWhat, pixels);
  frame.last.reserve(kWhat, pixels);
  frame.segment_tiles.reserve("the step's segments", room);
  frame.states.reserve("the step's segments", room * kTilePixels);
  check(cudaMemsetAsync(frame.segment_tiles.data(), 0xff, frame.segments * sizeof(std::uint32_t),
                        view.stream),
        "blend");
  launch("blend", blend_tiles, tiles, view.stream, frame.lists.schedule(tiles), frame.tiles(view),
         BlendTarget{frame.color.data(), frame.transmittance.data(), frame.last.data(),
                     frame.segment_tiles.data(), frame.states.data(), view.settings.background});
}

}  // namespace qs::cuda::train
