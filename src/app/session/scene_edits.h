// SPDX-License-Identifier: MIT
//
// Applies a file of edits (docs/formats.md#edits) to a scene that was read.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "base/parallel.h"
#include "io/cloud/scene.h"
#include "io/edits/edits_file.h"
#include "raster/select/editing.h"

namespace qs {

/// The choice of edits that commands offer.
struct EditOptions {
  std::optional<std::filesystem::path> file;
  bool anyway = false;      ///< also for another scene
  bool recomputes = false;  ///< uses the tools in place of the lists in the file
};

/// A whole scene with its edits.
struct EditedCloud {
  EditState state;
  EditsFile file;
  glm::dmat4 transform{1.0};  ///< its steps scale and level
};

/// Carries out the steps of the file on a scene as it was read, and prints a line; warnings go to
/// stderr. The scene stays as it is. Throws Error(input) if the file belongs to another scene.
EditedCloud edited(const Scene& scene, const EditOptions& options, ThreadPool& pool);

/// The facts of the scene for a file of edits.
EditedScene edited_scene(const Scene& scene);

/// Keeps these Gaussians of the scene as it was read, and notes the steps.
void keep_edited(Scene& scene, const EditedCloud& edited, const GaussianSet& kept);

/// Leaves the rest of the edits in the scene if a file is given. Throws Error(usage) if no Gaussian
/// is left.
void apply_edits(Scene& scene, const EditOptions& options, ThreadPool& pool);

}  // namespace qs
