// SPDX-License-Identifier: MIT
#include "app/session/frame_metadata.h"

#include <fmt/format.h>

#include "io/camera/cameras.h"
#include "version.h"

namespace qs {

ImageMetadata frame_metadata(const std::filesystem::path& scene, const Camera& camera,
                             CullMode mode, const RenderStats& stats) {
  return {{"Software", fmt::format("quadsplat {} ({})", kVersion, kCommit)},
          {"Scene", scene.filename().string()},
          {"Camera", format_camera(camera)},
          {"Mode", mode_name(mode)},
          {"TilePairs", fmt::format("{}", stats.tile_pairs)}};
}

}  // namespace qs
