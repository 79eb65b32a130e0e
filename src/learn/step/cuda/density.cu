// SPDX-License-Identifier: MIT
#include "learn/diff/cuda/segment.cuh"
#include "learn/gradient/density.h"
#include "learn/gradient/error_map.h"
#include "learn/step/cuda/density.cuh"
#include "raster/cuda/common/stream.cuh"

namespace qs::cuda::train {
namespace {

using diff::SharedSegment;

constexpr unsigned kPixelsPerThread = 16;  // so that few blocks add their histograms

/// One block per kPixelsPerThread * kThreads pixels.
__global__ void __launch_bounds__(kThreads)
    find_errors(Comparison in, std::uint32_t pixels, std::uint16_t* bins,
                std::uint32_t* histogram_of_all) {
  __shared__ std::uint32_t histogram[kErrorBins];
  for (unsigned bin = threadIdx.x; bin < kErrorBins; bin += kThreads) histogram[bin] = 0;
  __syncthreads();
  const std::uint32_t first = blockIdx.x * kPixelsPerThread * kThreads + threadIdx.x;
  for (unsigned k = 0; k < kPixelsPerThread; ++k) {
    const std::uint32_t i = first + k * kThreads;
    if (i >= pixels) break;
    const bool masked = in.mask != nullptr && in.mask[i] == 0;
    const std::uint16_t bin = masked ? kMaskedError : error_bin(in.color[i], in.target[i]);
    bins[i] = bin;
    if (!masked) atomicAdd(&histogram[bin], 1u);
  }
  __syncthreads();
  for (unsigned bin = threadIdx.x; bin < kErrorBins; bin += kThreads)
    if (histogram[bin] > 0) atomicAdd(&histogram_of_all[bin], histogram[bin]);
}

/// One block.
__global__ void __launch_bounds__(kThreads)
    find_limit(const std::uint32_t* counts, std::uint16_t* limit) {
  __shared__ std::uint32_t histogram[kErrorBins];
  for (unsigned bin = threadIdx.x; bin < kErrorBins; bin += kThreads) histogram[bin] = counts[bin];
  __syncthreads();
  if (threadIdx.x == 0) *limit = error_limit(histogram);
}

/// One block per segment, with one pixel per thread.
__global__ void __launch_bounds__(kTilePixels)
    count_pixels(TilesView tiles, diff::GpuPixelBlock pixels, const std::uint16_t* bins,
                 const std::uint16_t* limit, std::uint32_t* blended, std::uint32_t* flagged) {
  __shared__ SharedSegment segment;
  __shared__ std::uint32_t blended_of_entry[kSegment], flagged_of_entry[kSegment];
  const std::uint32_t tile = pixels.segment_tiles[blockIdx.x];
  if (tile == kNoTile) return;
  const unsigned thread = threadIdx.x;
  const uint2 range = tiles.ranges[tile];
  const std::uint32_t first = (blockIdx.x - first_segment(range.x, tile)) * kSegment;
  const std::uint32_t size = min(range.y - range.x - first, kSegment);
  segment.load(tiles, tile, range.x + first, size);
  blended_of_entry[thread] = flagged_of_entry[thread] = 0;

  const int x = tiles.x_of(tile, thread), y = tiles.y_of(tile, thread);
  std::uint32_t end = 0;  // entries of the segment up to the last blended entry
  bool is_flagged = false;
  if (tiles.contains(x, y)) {
    const std::size_t at = tiles.index_of(x, y);
    const std::uint16_t bin = bins[at];
    if (bin != kMaskedError) end = max(pixels.last[at], first) - first;
    is_flagged = bin > *limit;
  }
  __syncthreads();
  const unsigned end_of_warp = min(size, largest_of_warp(end));
  for (std::uint32_t group = 0; group < end_of_warp; group += kWarp) {
    for (unsigned reaching = segment.reaching(group, end_of_warp); reaching != 0;
         reaching &= reaching - 1) {
      const std::uint32_t entry = group + lowest_bit(reaching);
      const bool blends =
          entry < end &&
          segment.contribution(entry, static_cast<float>(x), static_cast<float>(y)).counts;
      const unsigned all = __ballot_sync(kAllLanes, blends);
      const unsigned wrong = __ballot_sync(kAllLanes, blends && is_flagged);
      if (lane_index() != 0) continue;
      if (all != 0) atomicAdd(&blended_of_entry[entry], static_cast<std::uint32_t>(__popc(all)));
      if (wrong != 0)
        atomicAdd(&flagged_of_entry[entry], static_cast<std::uint32_t>(__popc(wrong)));
    }
  }
  __syncthreads();
  if (thread >= size || blended_of_entry[thread] == 0) return;
  const std::uint32_t owner = tiles.owners[tiles.places[range.x + first + thread]];
  atomicAdd(&blended[owner], blended_of_entry[thread]);
  if (flagged_of_entry[thread] > 0) atomicAdd(&flagged[owner], flagged_of_entry[thread]);
}

void start_counting(std::uint32_t gaussians, cudaStream_t stream, PixelCounts& counts) {
  for (DeviceBuffer<std::uint32_t>* each : {&counts.blended, &counts.flagged})
    each->reserve("the counts", with_room(gaussians));
  for (DeviceBuffer<std::uint32_t>* each : {&counts.blended, &counts.flagged})
    set_zero("count errors", each->data(), gaussians, stream);
  counts.count = gaussians;
}

}  // namespace

void DensityStatistics::reset(std::uint32_t gaussians, cudaStream_t stream) {
  count = gaussians;
  sums.reserve("the statistics", with_room(count));
  views.reserve("the statistics", with_room(count));
  has_absolute = false;
  if (count == 0) return;
  set_zero("reset", sums.data(), count, stream);
  set_zero("reset", views.data(), count, stream);
}

void DensityStatistics::upload(const qs::train::DensityStatistics& host, cudaStream_t stream) {
  count = static_cast<std::uint32_t>(host.sums.size());
  copy_to_device(host.sums.data(), sums, count, stream);
  copy_to_device(host.views.data(), views, count, stream);
  has_absolute = !host.absolute.empty();
  copy_to_device(host.absolute.data(), absolute, host.absolute.size(), stream);
}

void DensityStatistics::download(cudaStream_t stream, qs::train::DensityStatistics& to) const {
  copy_to_host(sums.data(), to.sums, count, stream);
  copy_to_host(views.data(), to.views, count, stream);
  copy_to_host(absolute.data(), to.absolute, has_absolute ? count : 0, stream);
}

void DensityStatistics::add(const Gradients& gradients, CountedGaussians counted, int width,
                            int height, cudaStream_t stream) {
  if (count == 0) return;
  if (gradients.has_absolute && !has_absolute) {
    absolute.reserve("the statistics", with_room(count));
    set_zero("density", absolute.data(), count, stream);
    has_absolute = true;
  }
  const glm::vec2 half_px(0.5f * static_cast<float>(width), 0.5f * static_cast<float>(height));
  for_each_item("add_movements", count, stream,
                [=, d_mean_px = gradients.mean_px.data(),
                 absolute_px = gradients.has_absolute ? gradients.absolute_px.data() : nullptr,
                 sums = sums.data(), absolute = absolute.data(),
                 views = views.data()] __device__(std::uint32_t i) {
                  if (!counted.has(i)) return;
                  add_movement(half_px, d_mean_px[i], sums[i]);
                  if (absolute_px != nullptr) add_movement(half_px, absolute_px[i], absolute[i]);
                  ++views[i];
                });
}

void PixelCounts::download(cudaStream_t stream, qs::train::PixelCounts& to) const {
  copy_to_host(blended.data(), to.blended, count, stream);
  copy_to_host(flagged.data(), to.flagged, count, stream);
}

void count_errors(const StepView& view, const ForwardFrame& frame, const Comparison& pictures,
                  std::uint32_t gaussians, ErrorScratch& scratch, PixelCounts& counts) {
  const auto pixels = static_cast<std::uint32_t>(view.pixels());
  scratch.bins.reserve("the errors", pixels);
  scratch.histogram.reserve("the errors", kErrorBins);
  scratch.limit.reserve("the errors", 1);
  if (counts.count == 0) start_counting(gaussians, view.stream, counts);
  set_zero("count errors", scratch.histogram.data(), kErrorBins, view.stream);
  launch("find_errors", find_errors, blocks_for((pixels + kPixelsPerThread - 1) / kPixelsPerThread),
         view.stream, pictures, pixels, scratch.bins.data(), scratch.histogram.data());
  launch("find_limit", find_limit, 1u, view.stream, scratch.histogram.data(), scratch.limit.data());
  if (frame.segments == 0) return;
  launch("count_pixels", count_pixels, Blocks(frame.segments, kTilePixels), view.stream,
         frame.listed.tiles(), frame.pixels, scratch.bins.data(), scratch.limit.data(),
         counts.blended.data(), counts.flagged.data());
}

}  // namespace qs::cuda::train
