// SPDX-License-Identifier: MIT
//
// Metadata of every picture of a scene: enough to render it again.
#pragma once

#include "io/picture/image_file.h"
#include "raster/api/renderer.h"

namespace qs {

ImageMetadata frame_metadata(const std::filesystem::path& scene, const Camera& camera,
                             CullMode mode, const RenderStats& stats);

}  // namespace qs
