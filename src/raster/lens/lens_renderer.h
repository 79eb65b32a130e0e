// SPDX-License-Identifier: MIT
//
// Draws frames through lenses (RenderSettings::lens) by a renderer of pinhole and orthographic
// frames.
#pragma once

#include <memory>

#include "raster/api/renderer.h"

namespace qs {

/// A renderer that draws frames without a lens, and of parallel rays, by one frame of `inner`.
/// Other lenses are drawn by a frame of `inner` for each face (lens_map.h), which the host
/// combines: the target must be a HostImage or a DeviceImage, and there is no trace and no region.
/// Numbers of pairs, Gaussians and stages' milliseconds are sums over the faces, also in the maps
/// of tiles. Depths are distances from the eye, each of one pixel of a face. `pool` outlives the
/// result.
std::unique_ptr<Renderer> with_lenses(std::unique_ptr<Renderer> inner, ThreadPool& pool);

}  // namespace qs
