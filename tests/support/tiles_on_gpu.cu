// SPDX-License-Identifier: MIT
#include "raster/cuda/common/check.cuh"
#include "raster/cuda/common/device_buffer.cuh"
#include "raster/kernel/cull/modes.h"
#include "support/tiles_on_gpu.h"

namespace qs::test {
namespace {

using cuda::check;

struct Case {
  Footprint footprint;
  TileGrid grid;
  std::uint32_t first = 0;  // of its flags, one per tile
};

/// Sets the flag of each listed tile, a thread per case.
template <class P>
__global__ void list_tiles(const Case* cases, std::uint32_t count, std::uint8_t* flags) {
  const std::uint32_t i = blockIdx.x * cuda::kThreads + threadIdx.x;
  if (i >= count) return;
  const Case own = cases[i];
  constexpr bool kKeepsFaint = row_of<P>().keeps_faint;  // the table itself is in host memory
  if (!(own.footprint.gamma > 0) && !kKeepsFaint) return;
  for_each_tile<P>(own.footprint, own.grid, [&](int tile) { flags[own.first + tile] = 1; });
}

}  // namespace

std::vector<std::set<int>> tiles_on_gpu(CullMode mode, const std::vector<CullVector>& vectors) {
  std::vector<Case> cases;
  std::uint32_t flag_count = 0;
  for (const CullVector& vector : vectors) {
    cases.push_back({vector.footprint, vector.grid, flag_count});
    flag_count += static_cast<std::uint32_t>(vector.grid.count());
  }
  cuda::DeviceBuffer<Case> device_cases;
  cuda::DeviceBuffer<std::uint8_t> device_flags;
  device_cases.reserve("cases", cases.size());
  device_flags.reserve("flags of tiles", flag_count);
  check(cudaMemcpyAsync(device_cases.data(), cases.data(), cases.size() * sizeof(Case),
                        cudaMemcpyHostToDevice, nullptr),
        "copying the cases");
  check(cudaMemsetAsync(device_flags.data(), 0, flag_count, nullptr), "clearing the flags");
  const auto count = static_cast<std::uint32_t>(cases.size());
  with_culler(mode, [&]<class P>(P) {
    cuda::launch("list_tiles", list_tiles<P>, cuda::blocks_for(count), nullptr, device_cases.data(),
                 count, device_flags.data());
  });
  std::vector<std::uint8_t> flags(flag_count);
  check(cudaMemcpyAsync(flags.data(), device_flags.data(), flag_count, cudaMemcpyDeviceToHost,
                        nullptr),
        "copying the flags");
  check(cudaStreamSynchronize(nullptr), "listing tiles");

  std::vector<std::set<int>> tiles(cases.size());
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (int tile = 0; tile < cases[i].grid.count(); ++tile) {
      if (flags[cases[i].first + static_cast<std::uint32_t>(tile)] != 0) tiles[i].insert(tile);
    }
  }
  return tiles;
}

}  // namespace qs::test
