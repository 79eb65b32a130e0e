// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/frame_blocks.cuh"
#include "learn/diff/cuda/project.h"
#include "learn/diff/cuda/shared_sh.cuh"
#include "learn/diff/cuda/sums.cuh"
#include "learn/diff/gaussian_terms.h"
#include "raster/cuda/common/limits.cuh"
#include "raster/cuda/common/stream.cuh"
#include "raster/kernel/cull/modes.h"

namespace qs::cuda::diff {
namespace {

/// One thread per Gaussian. `source` keeps faint Gaussians, which may have a row in the boundary;
/// `keep_faint` decides whether tiles may list them. Sets the tile counts of the Gaussians that
/// count_tiles_of() must look at to 1, the others to 0.
__global__ void __launch_bounds__(kThreads, 3)
    project_given(GivenGaussians<float> source, SharedSh shared, bool keep_faint,
                  GpuGaussianBlock out, FootprintArrays footprints) {
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  bool exists = i < source.in.count;
  if (exists) {
    out.tile_counts[i] = 0;
    out.projected[i] = 0;
    source.clear(i);
    exists = source.has_finite_shape(i);
  }
  glm::vec3 mean(0.0f);
  Covariance3<double> sigma{};
  double opacity = 0;
  Projected projected;
  if (exists) {
    mean = source.mean(i);
    sigma = source.covariance(i);
    opacity = source.opacity(i);
    exists = qs::project(source.rules.view, source.rules, active_gaussian(mean, sigma, opacity),
                         projected);
  }
  const SharedSh::Row sh = shared.load(source.in.sh, exists);
  if (!exists || !source.has_finite_color(sh)) return;
  const auto values = SplatValues<float>::of(source.rules, mean, sigma, opacity, projected);
  const glm::vec3 color = source.color(mean, sh);
  if (!source.report(i, projected, values, color)) return;
  out.projected[i] = 1;
  if (!keep_faint && !(projected.footprint.gamma > 0.0f)) return;
  out.tile_counts[i] = 1;
  out.depths[i] = projected.depth;
  out.splats[i] = {make_splat(values.mean_px, values.conic, values.opacity, color),
                   ellipse_of(projected.footprint)};
  footprints.store(i, projected.footprint);
}

/// Counts the tiles that mode P lists. One thread per Gaussian.
template <class P>
__global__ void __launch_bounds__(kThreads)
    count_tiles_of(std::uint32_t count, FootprintArrays footprints, TileGrid grid,
                   GpuGaussianBlock out) {
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  const bool exists = i < count && out.tile_counts[i] != 0;
  const unsigned tiles = exists ? count_tiles<P>(footprints.load(i), grid) : 0;
  const std::uint32_t first_place = take_places(tiles, out.total);
  if (!exists) return;
  out.tile_counts[i] = tiles;
  out.first_places[i] = first_place;
}

constexpr unsigned kPoseNumbers = 15;
static_assert(sizeof(PoseGradient) == kPoseNumbers * sizeof(double));

/// Scratch memory of project_backward().
struct PoseScratch {
  double* sums;  ///< kPoseNumbers per block

  static PoseScratch of(BlockArrays& block, const GpuHeldSizes& sizes) {
    return {block.next<double>(std::size_t{kPoseNumbers} * blocks_for(sizes.gaussians))};
  }
};

/// Where a thread finds the derivatives by the boundary of its Gaussian: in rows, each of which may
/// be missing. A kernel parameter, as the next.
struct RowsOfBoundary {
  Boundary<const float> by;
  const std::uint8_t* projected;

  /// False if all derivatives are 0.
  __device__ bool read(std::uint32_t i, BoundaryGradient<float>& d) const {
    if (projected[i] == 0) return false;
    d = BoundaryGradient<float>::of(by, i);
    return !d.is_zero();
  }
};

/// Takes the derivatives from the sums over the Gaussian's pixels, so that no rows are written and
/// read.
struct SumsOfPixels {
  const std::uint32_t* tile_counts;
  const ListedSplat* splats;
  const float* depths;
  GaussianSums sums;
  bool has_sh;  ///< else the sums of the colour belong to the given channels

  __device__ bool read(std::uint32_t i, BoundaryGradient<float>& d) const {
    if (tile_counts[i] == 0) return false;
    d.splat = splat_gradient<float>(splats[i].splat, sums.pixels[i]);
    if (sums.depths != nullptr) d.depth = depth_gradient(sums.depths[i], depths[i]);
    if (!has_sh) d.splat.color = glm::vec3(0.0f);
    return !d.is_zero();
  }
};

/// One thread per Gaussian. `sums` is null unless `kPose`: the pose has a gradient.
template <bool kPose, class Source>
__global__ void __launch_bounds__(kThreads, kPose ? 1 : 3)
    gradients_of_given(GivenGradient<float> gradient, SharedSh shared, Source source,
                       double* sums) {
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  const bool exists = i < gradient.in.count;
  BoundaryGradient<float> by;
  const bool adds = exists && source.read(i, by);
  // The derivatives take the place of the coefficients, which are read before.
  const SharedSh::Row sh = shared.load(gradient.in.sh, adds);
  PoseGradient pose;
  if (adds)
    gradient.template add<kPose>(i, by, pose, sh);
  else if (exists)
    gradient.clear(i, sh);
  if (gradient.out.sh) shared.store(gradient.out.sh, exists);
  if constexpr (kPose) {
    for (unsigned k = 0; k < kPoseNumbers; ++k) {
      const int at = static_cast<int>(k);
      const double own = k < 12 ? pose.view_from_world[at / 3][at % 3] : pose.position[at - 12];
      const double sum = sum_of_block<kThreads>(own).total;
      if (threadIdx.x == 0) sums[blockIdx.x * kPoseNumbers + k] = sum;
    }
  }
}

template <class Source>
void set_gradients(const DrawnView& view, const GaussianInputs<float>& gaussians,
                   const GpuHeldSizes& sizes, const Source& source, const Queue& queue,
                   void* scratch, const InputGradients<float>& out, PoseGradient* pose) {
  view.check("project_backward");
  gaussians.check("project_backward");
  gaussians.check_frame("project_backward", sizes.gaussians);
  queue.throw_if_cancelled();
  const cudaStream_t stream = stream_of(queue);
  const auto rules = PassRules<float>::of(view, gaussians.sh_degree);
  const unsigned blocks = blocks_for(sizes.gaussians);
  double* const sums = pose != nullptr ? block_at<PoseScratch>(scratch, sizes).sums : nullptr;
  if (blocks > 0) {
    const auto shared =
        SharedSh::of(static_cast<bool>(gaussians.sh), sh_coefficient_count(gaussians.sh_degree));
    launch("project_backward",
           pose != nullptr ? gradients_of_given<true, Source> : gradients_of_given<false, Source>,
           Blocks(blocks, kThreads, shared.bytes()), stream,
           GivenGradient<float>(rules, gaussians, out), shared, source, sums);
  }
  if (pose != nullptr)
    launch("sum_poses", add_rows<double>, 1, stream, sums, blocks, kPoseNumbers,
           reinterpret_cast<double*>(pose));
}

}  // namespace

std::size_t bytes_of_gaussians(const GpuHeldSizes& sizes) {
  return bytes_of<GpuGaussianBlock>(sizes);
}

std::size_t bytes_of_pairs(const GpuHeldSizes& sizes) { return bytes_of<GpuPairBlock>(sizes); }

std::size_t bytes_of_pixels(const GpuHeldSizes& sizes) { return bytes_of<GpuPixelBlock>(sizes); }

std::size_t bytes_to_project(const GpuHeldSizes& sizes) { return bytes_of<ProjectScratch>(sizes); }

std::size_t bytes_to_list(const GpuHeldSizes& sizes) { return bytes_of<ListScratch>(sizes); }

std::size_t bytes_of_pose(const GpuHeldSizes& sizes) { return bytes_of<PoseScratch>(sizes); }

void project(const DrawnView& view, const GaussianInputs<float>& gaussians, const Queue& queue,
             void* scratch, Frame& frame, const Boundary<float>& out,
             const Rows<std::int32_t>& radii) {
  view.check("project");
  gaussians.check("project");
  queue.throw_if_cancelled();
  const cudaStream_t stream = stream_of(queue);
  GpuHeldSizes sizes = GpuHeldSizes::of(view.camera, gaussians.count);
  const auto block = block_at<GpuGaussianBlock>(frame.gaussians, sizes);
  set_zero("project", block.total, 1, stream);
  if (sizes.gaussians > 0) {
    const FootprintArrays footprints = block_at<ProjectScratch>(scratch, sizes).footprints;
    auto rules = PassRules<float>::of(view, gaussians.sh_degree);
    const bool keep_faint = std::exchange(rules.keep_faint, true);
    const auto shared =
        SharedSh::of(static_cast<bool>(gaussians.sh), sh_coefficient_count(rules.sh_degree));
    launch("project", project_given, Blocks(blocks_for(sizes.gaussians), kThreads, shared.bytes()),
           stream, GivenGaussians<float>{rules, gaussians, out, radii}, shared, keep_faint, block,
           footprints);
    with_culler(view.mode, [&]<class P>(P) {
      launch("count_tiles", count_tiles_of<P>, blocks_for(sizes.gaussians), stream, sizes.gaussians,
             footprints, grid_of(sizes), block);
    });
  }
  unsigned long long pairs = 0;
  copy_to_host(block.total, &pairs, 1, stream);
  queue.throw_if_cancelled();
  require_indexable(pairs);
  sizes.pairs = static_cast<std::uint32_t>(pairs);
  frame.sizes = sizes;
}

void list(const DrawnView& view, const Queue& queue, void* projected, void* scratch,
          const Frame& frame) {
  queue.throw_if_cancelled();
  const ListedFrame listed = ListedFrame::of(frame);
  const auto footprints = block_at<ProjectScratch>(projected, frame.sizes).footprints;
  const auto unsorted = block_at<ListScratch>(scratch, frame.sizes);
  list_pairs(view.mode, listed.input(frame.sizes.gaussians, footprints, unsorted),
             stream_of(queue));
}

void project_backward(const DrawnView& view, const GaussianInputs<float>& gaussians,
                      const Frame& frame, const Boundary<const float>& by, const Queue& queue,
                      void* scratch, const InputGradients<float>& out, PoseGradient* pose) {
  const auto block = block_at<GpuGaussianBlock>(frame.gaussians, frame.sizes);
  set_gradients(view, gaussians, frame.sizes, RowsOfBoundary{by, block.projected}, queue, scratch,
                out, pose);
}

void project_backward_of_sums(const DrawnView& view, const GaussianInputs<float>& gaussians,
                              const Frame& frame, const GaussianSums& by, const Queue& queue,
                              void* scratch, const InputGradients<float>& out, PoseGradient* pose) {
  const auto block = block_at<GpuGaussianBlock>(frame.gaussians, frame.sizes);
  const SumsOfPixels source{block.tile_counts, block.splats, block.depths, by,
                            static_cast<bool>(gaussians.sh)};
  set_gradients(view, gaussians, frame.sizes, source, queue, scratch, out, pose);
}

ListCopies copy_lists(const Frame& frame, const Queue& queue) {
  const cudaStream_t stream = stream_of(queue);
  const ListedFrame listed = ListedFrame::of(frame);
  const GpuHeldSizes& sizes = listed.sizes;
  ListCopies copies;
  for (const uint2& range : copied(listed.pairs.ranges, tiles_of(sizes), stream))
    copies.begin.push_back(range.x);
  copies.begin.push_back(sizes.pairs);
  copies.gaussians = copied(listed.pairs.places, sizes.pairs, stream);
  const auto owners = copied(listed.pairs.owners, sizes.pairs, stream);
  for (std::uint32_t& place : copies.gaussians) place = owners[place];
  copies.tile_counts = copied(listed.gaussians.tile_counts, sizes.gaussians, stream);
  copies.projected = copied(listed.gaussians.projected, sizes.gaussians, stream);
  return copies;
}

}  // namespace qs::cuda::diff
