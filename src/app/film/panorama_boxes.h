// SPDX-License-Identifier: MIT
//
// The boxes of an MP4 file by which players show it as a film of 360 degrees or as VR180: st3d and
// sv3d of Google's Spherical Video V2, and the XML of V1 (https://github.com/google/spatial-media).
#pragma once

#include <filesystem>

namespace qs {

/// The shape of an equirectangular film.
struct PanoramaFilm {
  bool is_half = false;    ///< 180 degrees across, not 360
  bool is_stereo = false;  ///< the left eye's pictures above the right eye's
};

/// Adds the boxes to a finished file, which is written again. `shown` names it in messages. Throws
/// Error(input) if it is not an MP4 file with a video.
void add_panorama_boxes(const std::filesystem::path& file, const std::filesystem::path& shown,
                        const PanoramaFilm& film);

}  // namespace qs
