// SPDX-License-Identifier: MIT
//
// Footprints in three arrays with elements of 16, 16 and 8 bytes, by index in the cloud.
#pragma once

#include "raster/api/renderer.h"
#include "raster/cuda/common/device_buffer.cuh"
#include "raster/kernel/footprint.h"

namespace qs::cuda {

/// The pointers that kernels use. Passed by value.
struct FootprintArrays {
  float4* means;   ///< mean x, y, covariance xx, xy
  float4* conics;  ///< covariance yy, conic a, b, c
  float2* levels;  ///< determinant, gamma

  QS_HD Footprint load(std::size_t i) const {
    const float4 m = means[i], c = conics[i];
    const float2 l = levels[i];
    return {{m.x, m.y}, {m.z, m.w, c.x}, {c.y, c.z, c.w}, l.x, l.y};
  }

  QS_HD void store(std::size_t i, const Footprint& f) const {
    const Covariance2<float>& s = f.covariance;
    means[i] = {f.mean_px.x, f.mean_px.y, s.xx, s.xy};
    conics[i] = {s.yy, f.conic.x, f.conic.y, f.conic.z};
    levels[i] = {f.determinant, f.gamma};
  }
};

struct FootprintBuffers {
  DeviceBuffer<float4> means, conics;
  DeviceBuffer<float2> levels;

  /// See DeviceBuffer::reserve().
  void reserve(const char* what, std::size_t count) {
    means.reserve(what, count);
    conics.reserve(what, count);
    levels.reserve(what, count);
  }

  FootprintArrays arrays() { return {means.data(), conics.data(), levels.data()}; }
};

}  // namespace qs::cuda
