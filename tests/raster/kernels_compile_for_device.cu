// SPDX-License-Identifier: MIT
// Compile-only: uses every function of kernel/ once in device code, so that code which only g++
// accepts fails the build.
#include <tuple>

#include "raster/kernel/cull/modes.h"
#include "raster/kernel/footprint.h"
#include "raster/kernel/sh.h"

namespace qs {

template <class P>
__global__ void use_culler(View<float> view, FootprintRules rules, const ActiveGaussian* gaussians,
                           TileGrid grid, unsigned* counts, int* tiles) {
  Projected projected;
  if (!project(view, rules, gaussians[threadIdx.x], projected)) return;
  counts[threadIdx.x] = count_tiles<P>(projected.footprint, grid);
  for_each_tile<P>(projected.footprint, grid, [&](int tile) { *tiles++ = tile; });
}

__global__ void use_sh(int degree, const glm::vec3* coefficients, glm::vec3* colors) {
  colors[0] = sh_color<float>(degree, glm::vec3(0, 0, 1), [&](int i) { return coefficients[i]; });
}

template __global__ void use_culler<Square>(View<float>, FootprintRules, const ActiveGaussian*,
                                            TileGrid, unsigned*, int*);
template __global__ void use_culler<AdrAabb>(View<float>, FootprintRules, const ActiveGaussian*,
                                             TileGrid, unsigned*, int*);
template __global__ void use_culler<DualBox>(View<float>, FootprintRules, const ActiveGaussian*,
                                             TileGrid, unsigned*, int*);
template __global__ void use_culler<QuadBox>(View<float>, FootprintRules, const ActiveGaussian*,
                                             TileGrid, unsigned*, int*);
template __global__ void use_culler<QuadBoxNaive>(View<float>, FootprintRules,
                                                  const ActiveGaussian*, TileGrid, unsigned*, int*);
template __global__ void use_culler<Exact>(View<float>, FootprintRules, const ActiveGaussian*,
                                           TileGrid, unsigned*, int*);

}  // namespace qs
