// SPDX-License-Identifier: MIT
//
// Frames through lenses whose faces stay on the GPU. This header is plain C++.
#pragma once

#include <memory>

#include "raster/api/renderer.h"

namespace qs {

/// with_lenses() for a renderer of the GPU `device`: the map of a lens is copied there once, and
/// faces are not copied to the host. Of a DeviceImage, Frame::on_device has the picture.
std::unique_ptr<Renderer> with_lenses_on_gpu(std::unique_ptr<Renderer> inner, ThreadPool& pool,
                                             int device);

}  // namespace qs
