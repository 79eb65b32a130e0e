// SPDX-License-Identifier: MIT
// Lists the tiles of a Gaussian on a GPU: a kernel that counts them and marks each in a map.
#include <cmath>
#include <cstdio>
#include <string>

#include <quadsplat/cull/modes.h>

template <class P>
__global__ void list_tiles(qs::Footprint footprint, qs::TileGrid grid, unsigned* count, char* map) {
  *count = qs::count_tiles<P>(footprint, grid);
  qs::for_each_tile<P>(footprint, grid, [&](int tile) { map[tile + tile / grid.columns] = '#'; });
}

int main() {
  int devices = 0;
  if (cudaGetDeviceCount(&devices) != cudaSuccess || devices == 0)
    return std::puts("skipped: no GPU"), 0;
  const float gamma = 2.0f * std::log(255.0f * 0.152602926f);  // of the opacity
  const qs::Footprint footprint =
      qs::make_footprint({64.0f, 64.0f}, {352.592926f, 370.484192f, 400.15683f}, gamma);
  const qs::TileGrid grid = qs::TileGrid::of_image(160, 128);
  std::string empty;
  for (int row = 0; row < grid.rows; ++row)
    empty += std::string(row > 0, '/') + std::string(grid.columns, '.');
  unsigned* count = nullptr;
  char* map = nullptr;
  cudaMalloc(&count, sizeof *count);
  cudaMalloc(&map, empty.size());
  for (qs::CullMode mode = 1; mode <= qs::kModeCount; ++mode) {
    cudaMemcpy(map, empty.data(), empty.size(), cudaMemcpyHostToDevice);
    qs::with_culler(
        mode, [&](auto p) { list_tiles<decltype(p)><<<1, 1>>>(footprint, grid, count, map); });
    unsigned listed = 0;
    std::string text = empty;
    cudaMemcpy(&listed, count, sizeof listed, cudaMemcpyDeviceToHost);
    cudaMemcpy(text.data(), map, text.size(), cudaMemcpyDeviceToHost);
    std::printf("%s %u %s\n", qs::kCullers[mode].name, listed, text.c_str());
  }
  return cudaDeviceSynchronize() == cudaSuccess ? 0 : 1;
}
