// SPDX-License-Identifier: MIT
//
// The options of drawing through a lens: --lens and the options of single lenses. To add a lens: a
// row in lens_options.cpp.
#pragma once

#include <optional>
#include <string>

#include "app/cli/camera_choice.h"
#include "app/cli/shared_options.h"
#include "raster/lens/lens_view.h"

namespace qs {

struct LensOptions {
  std::string lens = {};                            ///< empty: none is given
  std::optional<double> fov, height, eye_distance;  ///< degrees, world units, world units
  bool stereo = false, level = false;

  bool is_drawn() const { return !lens.empty() && lens != "pinhole"; }
  /// True if the frames have faces; else they are as any frame.
  bool has_faces() const { return is_drawn() && lens != "orthographic"; }
  /// True if the pictures are panoramas.
  bool is_panorama() const { return lens == "equirectangular"; }
  double panorama_degrees() const { return fov.value_or(360); }
};

/// HeatQuantity::missed compares the traces of two pictures.
inline constexpr const char* kNoLensHeatmap =
    "--heatmap missed compares the lists of one picture, and a --lens has a picture for each face";

void declare_lens_options(Options& options, LensOptions& lens);

/// Throws Error(usage) if the options do not fit together or with the size of the pictures, which
/// is set for panoramas and camera models without --size. `command`: its name.
void check_lens(const char* command, const LensOptions& lens, FrameOptions& frame);

/// Without --lens the lens of the camera that --camera-index chooses alone, if no pinhole camera
/// shows its picture, with a line that says so. Throws Error.
void use_own_lens(LensOptions& lens, const CameraChoice& cameras, const FrameOptions& frame);

/// Lets the session draw through the lens.
void set_lens(const LensOptions& lens, const FrameOptions& frame, Session& session);

}  // namespace qs
