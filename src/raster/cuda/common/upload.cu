// SPDX-License-Identifier: MIT
#include <algorithm>
#include <limits>
#include <span>

#include "raster/cuda/common/stream.cuh"
#include "raster/cuda/common/upload.cuh"
#include "raster/cuda/common/warp.cuh"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/cloud_order.h"

namespace qs::cuda {
namespace {

constexpr std::size_t kChunk = 1 << 16;  // Gaussians per copy
static_assert(kChunk % kBlockGaussians == 0);

/// The places of `count` Gaussians: from `first` on, or `listed` if that is not null.
struct Places {
  unsigned count;
  std::size_t first;
  const std::uint32_t* listed = nullptr;

  __device__ std::size_t operator[](unsigned i) const {
    return listed == nullptr ? first + i : listed[i];
  }
};

void split_gaussians(const ActiveGaussian* chunk, const Places& places, float4* positions,
                     float4* covariances, float2* covariances_z, cudaStream_t stream) {
  for_each_item("split_gaussians", places.count, stream, [=] __device__(unsigned i) {
    const ActiveGaussian& g = chunk[i];
    const Covariance3<float>& c = g.covariance;
    const std::size_t place = places[i];
    positions[place] = {g.position.x, g.position.y, g.position.z, g.log2_255_opacity};
    covariances[place] = {c.xx, c.xy, c.xz, c.yy};
    covariances_z[place] = {c.yz, c.zz};
  });
}

/// A row of `width` values for each Gaussian.
struct Rows {
  const float* values;
  unsigned width;
  Places places;
};

/// Transposes: value k of row i becomes the element of its place in array k < `arrays`. An array
/// has `size` values.
void transpose_rows(const Rows& rows, unsigned arrays, std::size_t size, float* to,
                    cudaStream_t stream) {
  for_each_item("transpose_rows", rows.places.count, stream, [=] __device__(unsigned i) {
    const float* const row = rows.values + std::size_t{i} * rows.width;
    for (unsigned k = 0; k < arrays; ++k) to[k * size + rows.places[i]] = row[k];
  });
}

/// Copies the values from 3 on, as halves. Sets *inexact unless halves equal all of them.
void transpose_to_halves(const Rows& rows, std::size_t size, std::uint16_t* to,
                         std::uint32_t* inexact, cudaStream_t stream) {
  for_each_item("transpose_to_halves", rows.places.count, stream, [=] __device__(unsigned i) {
    const float* const row = rows.values + std::size_t{i} * rows.width;
    bool exact = true;
    for (unsigned k = 3; k < rows.width; ++k) {
      std::uint16_t half = 0;
      exact = to_half(row[k], half) && exact;
      to[(k - 3) * size + rows.places[i]] = half;
    }
    if (!exact) *inexact = 1;
  });
}

/// A part of the scene on the host, in the order of the GPU.
struct Staging {
  Array<ActiveGaussian> gaussians;
  Array<glm::vec3> sh;
  Array<BlockBounds> bounds;

  /// The Gaussians at places `first` ... `first + count - 1` of an order, see Upload.
  void gather(const GaussianCloud& cloud, std::span<const std::uint32_t> order, std::size_t first,
              std::size_t count, ThreadPool& pool) {
    const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
    gaussians.resize(count);
    sh.resize(count * coefficients);
    bounds.assign(blocks_for(count), {});
    pool.for_chunks(count, kBlockGaussians, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t from = order.empty() ? first + i : order[first + i];
        const ActiveGaussian& g = gaussians[i] = activate(cloud, from).gaussian;
        bounds[begin / kBlockGaussians].include(g.position, g.covariance);
        std::copy_n(&cloud.sh[from * coefficients], coefficients, &sh[i * coefficients]);
      }
    });
  }
};

/// Gathers the bits of all places; a warp makes a word.
__global__ void __launch_bounds__(kThreads)
    gather_bits(const std::uint32_t* from, const std::uint32_t* file_indices, std::uint32_t count,
                std::uint32_t* to) {
  const std::uint32_t i = blockIdx.x * kThreads + threadIdx.x;
  bool bit = false;
  if (i < count) {
    const std::uint32_t index = file_indices == nullptr ? i : file_indices[i];
    bit = (from[index / kWarp] >> index % kWarp & 1) != 0;
  }
  const unsigned word = __ballot_sync(kAllLanes, bit);
  if (lane_index() == 0) to[i / kWarp] = word;
}

/// Values of a Gaussian's colour.
unsigned sh_width(const GaussianCloud& cloud) {
  return static_cast<unsigned>(3 * sh_coefficient_count(cloud.sh_degree));
}

/// Uploads a scene, with coefficients as halves on request.
class Upload {
 public:
  Upload(const GaussianCloud& cloud, std::span<const std::uint32_t> order, ThreadPool& pool,
         cudaStream_t stream, DeviceCloud& device)
      : cloud_(cloud), order_(order), pool_(pool), stream_(stream), device_(device) {
    const std::size_t chunk = std::min(kChunk, cloud.size());
    device.positions.reserve(kScene, cloud.size());
    device.covariances.reserve(kScene, cloud.size());
    device.covariances_z.reserve(kScene, cloud.size());
    scratch().gaussians.reserve(kScene, chunk);
    scratch().rows.reserve(kScene, chunk * width_);
    scratch().inexact.reserve(kScene, 1);
    if (order.empty()) return;
    device.file_indices.reserve(kScene, cloud.size());
    device.bounds.reserve(kScene, blocks_for(cloud.size()));
    copy_to_device(order.data(), cloud.size(), device.file_indices.data(), stream);
  }

  /// Returns false at the first chunk with coefficients that halves do not equal. Waits for all
  /// copies.
  bool with_halves(const Progress& progress) {
    device_.sh.reserve(kScene, cloud_.size() * 3);
    device_.sh_halves.reserve(kScene, cloud_.size() * (width_ - 3));
    set_zero("upload", scratch().inexact.data(), 1, stream_);
    for (std::size_t first = 0; first < cloud_.size(); first += kChunk) {
      const Rows rows = copy_chunk(first, progress);
      transpose_rows(rows, 3, cloud_.size(), device_.sh.data(), stream_);
      transpose_to_halves(rows, cloud_.size(), device_.sh_halves.data(), scratch().inexact.data(),
                          stream_);
      if (copied(scratch().inexact.data(), 1, stream_)[0] != 0) return false;
    }
    return true;
  }

  void with_floats(const Progress& progress) {
    device_.sh_halves.release();
    require_memory(kScene, scene_bytes(cloud_, order_.empty() ? Order::file : Order::space),
                   device_.bytes());
    device_.sh.reserve(kScene, cloud_.size() * width_);
    for (std::size_t first = 0; first < cloud_.size(); first += kChunk) {
      const Rows rows = copy_chunk(first, progress);
      transpose_rows(rows, width_, cloud_.size(), device_.sh.data(), stream_);
    }
    check(cudaStreamSynchronize(stream_), "upload");
  }

  /// Gaussians `numbers` of the cloud again, which are at `places`. False as with_halves().
  bool update(std::span<const std::uint32_t> numbers, std::span<const std::uint32_t> places) {
    const bool has_halves = device_.sh_halves.data() != nullptr;
    DeviceBuffer<std::uint32_t>& listed = scratch().places;
    listed.reserve(kScene, numbers.size());
    copy_to_device(places.data(), places.size(), listed.data(), stream_);
    set_zero("update", scratch().inexact.data(), 1, stream_);
    for (std::size_t first = 0; first < numbers.size(); first += kChunk) {
      const auto n = static_cast<unsigned>(std::min(kChunk, numbers.size() - first));
      const Rows rows = copy_part(numbers, first, {n, 0, listed.data() + first});
      transpose_rows(rows, has_halves ? 3 : width_, cloud_.size(), device_.sh.data(), stream_);
      if (has_halves)
        transpose_to_halves(rows, cloud_.size(), device_.sh_halves.data(), scratch().inexact.data(),
                            stream_);
      for (unsigned k = 0; k < n && !device_.host_bounds.empty(); ++k)
        device_.host_bounds[places[first + k] / kBlockGaussians].include(
            staging_.gaussians[k].position, staging_.gaussians[k].covariance);
    }
    copy_to_device(device_.host_bounds.data(), device_.host_bounds.size(), device_.bounds.data(),
                   stream_);
    return !has_halves || copied(scratch().inexact.data(), 1, stream_)[0] == 0;
  }

 private:
  UploadScratch& scratch() { return device_.scratch; }

  /// Enqueues the copy of all values but the coefficients, which are in the returned rows.
  Rows copy_chunk(std::size_t first, const Progress& progress) {
    progress.update(0.3f + 0.7f * static_cast<float>(first) / static_cast<float>(cloud_.size()));
    const auto n = static_cast<unsigned>(std::min(kChunk, cloud_.size() - first));
    const Rows rows = copy_part(order_, first, {n, first});
    if (!order_.empty())
      copy_to_device(staging_.bounds.data(), staging_.bounds.size(),
                     device_.bounds.data() + first / kBlockGaussians, stream_);
    return rows;
  }

  /// The same for Gaussians [first, first + places.count) of an order.
  Rows copy_part(std::span<const std::uint32_t> order, std::size_t first, const Places& places) {
    staging_.gather(cloud_, order, first, places.count, pool_);
    // Copies have left the staging memory when they return, because it is not pinned.
    copy_to_device(staging_.gaussians.data(), places.count, scratch().gaussians.data(), stream_);
    split_gaussians(scratch().gaussians.data(), places, device_.positions.data(),
                    device_.covariances.data(), device_.covariances_z.data(), stream_);
    copy_to_device(&staging_.sh.data()->x, std::size_t{places.count} * width_,
                   scratch().rows.data(), stream_);
    return {scratch().rows.data(), width_, places};
  }

  static constexpr const char* kScene = "the scene";

  const GaussianCloud& cloud_;
  std::span<const std::uint32_t> order_;  // empty: the order of the file
  ThreadPool& pool_;
  cudaStream_t stream_;
  DeviceCloud& device_;
  unsigned width_ = sh_width(cloud_);
  Staging staging_;
};

}  // namespace

std::uint64_t scene_bytes(const GaussianCloud& cloud, Order order) {
  constexpr std::uint64_t kGeometryBytes = 10 * sizeof(float);
  const std::uint64_t each = kGeometryBytes + sh_width(cloud) * sizeof(float);
  const std::uint64_t of_order =
      order == Order::file
          ? 0
          : cloud.size() * sizeof(std::uint32_t) + blocks_for(cloud.size()) * sizeof(BlockBounds);
  return cloud.size() * each + of_order;
}

void expect_updates(cudaStream_t stream, DeviceCloud& device) {
  if (device.file_indices.data() == nullptr || !device.places.empty()) return;
  device.places.resize(device.count);
  const auto indices = copied(device.file_indices.data(), device.count, stream);
  for (std::uint32_t place = 0; place < device.count; ++place)
    device.places[indices[place]] = place;
  device.host_bounds = copied(device.bounds.data(), blocks_for(device.count), stream);
}

bool update(const GaussianCloud& cloud, std::span<const std::uint32_t> changed, ThreadPool& pool,
            cudaStream_t stream, DeviceCloud& device) {
  if (changed.empty()) return true;
  expect_updates(stream, device);
  std::vector<std::uint32_t> places(changed.begin(), changed.end());
  if (!device.places.empty())
    for (std::uint32_t& place : places) place = device.places[place];
  return Upload(cloud, {}, pool, stream, device).update(changed, places);
}

void set_drawn(const GaussianSet& set, cudaStream_t stream, DeviceCloud& device) {
  constexpr const char* kSet = "the set of drawn Gaussians";
  device.draws_all = set.size() == 0;
  if (device.draws_all) return;
  const unsigned blocks = blocks_for(device.count);
  const std::size_t words = std::size_t{blocks} * (kBlockGaussians / kWarp);
  DeviceBuffer<std::uint32_t>& by_file = device.scratch.set;
  device.drawn.reserve(kSet, words);
  by_file.reserve(kSet, words);
  copy_to_device(set.bytes().data(), set.bytes().size(),
                 reinterpret_cast<std::byte*>(by_file.data()), stream);
  launch(kSet, gather_bits, blocks, stream, by_file.data(), device.file_indices.data(),
         device.count, device.drawn.data());
}

void upload(const GaussianCloud& cloud, Order order, ThreadPool& pool, const Progress& progress,
            cudaStream_t stream, DeviceCloud& device) {
  // The old scene is freed first, because both scenes together may not fit.
  device = {};
  if (cloud.size() > std::numeric_limits<std::int32_t>::max())
    throw Error(ErrorKind::device, "cuda: the scene has " + std::to_string(cloud.size()) +
                                       " Gaussians, at most 2147483647 can be drawn");
  progress.update(0);
  Array<std::uint32_t> file_indices;
  if (order == Order::space) file_indices = spatial_order(cloud, pool);
  Upload upload(cloud, file_indices, pool, stream, device);
  const bool may_have_halves = order == Order::space && cloud.sh_degree > 0;
  if (!may_have_halves || !upload.with_halves(progress)) upload.with_floats(progress);
  device.sh_degree = cloud.sh_degree;
  device.antialiased = cloud.antialiased;
  device.count = static_cast<std::uint32_t>(cloud.size());
  device.scratch = {};  // most scenes never change
  progress.update(1);
}

}  // namespace qs::cuda
