// SPDX-License-Identifier: MIT
//
// Applies files of edits and of measures (docs/formats.md#edits) to a scene that was read.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "io/cloud/scene.h"
#include "io/edits/edits_file.h"
#include "io/edits/measures_file.h"
#include "raster/select/editing.h"

namespace qs {

/// The choice of edits that commands offer.
struct EditOptions {
  std::optional<std::filesystem::path> file;
  std::optional<std::string> text = {};  ///< the file's content, if it is not of this machine
  bool anyway = false;                   ///< also for another scene
  bool recomputes = false;               ///< uses the tools in place of the lists in the file
};

/// A whole scene with its edits.
struct EditedCloud {
  EditState state;
  EditsFile file;
  glm::dmat4 transform{1.0};  ///< its steps scale and level
};

/// Carries out the steps of the file on a scene as it was read, and prints a line; warnings go to
/// stderr. The scene stays as it is. `each`: called with every step and the state after it; may be
/// null. Throws Error(input) if the file belongs to another scene.
EditedCloud edited(const Scene& scene, const EditOptions& options, ThreadPool& pool,
                   const std::function<void(const EditStep&, const EditState&)>& each = {});

/// The scene as its file has it; `hashes`: with the hash of the file.
EditedScene edited_scene(const Scene& scene, bool hashes);
/// The reason why a file is not of this scene, which has so many Gaussians, or "". Hashes the
/// scene's file only if the other file has a hash.
std::string other_scene(const EditedScene& of, const Scene& scene, std::size_t gaussians);

/// Reads a file of measures of this scene. `text`: its content, if it is not of this machine.
/// Throws Error(input), also if it is of another scene.
MeasuresFile measures_of(const Scene& scene, const std::filesystem::path& path,
                         const std::optional<std::string>& text = {});

/// Reads a file of edits of a tree that is not read whole. The tree's file is not hashed, because
/// it can be far larger than the pages that are needed. Throws Error(input), also if it is of
/// another scene.
EditsFile edits_of_tree(const Scene& scene, const EditOptions& options);

/// The file of these steps, which were carried out on the scene. If the scene is a part of its
/// file, because of earlier edits or Gaussians that were left out, the steps are of the whole file,
/// and the first two remove the others. `hashes`: with the hash of the file.
EditsFile edits_file(const Scene& scene, std::vector<EditStep> steps, bool hashes);

/// Keeps these Gaussians of the scene as it was read, and notes the steps.
void keep_edited(Scene& scene, const EditedCloud& edited, const GaussianSet& kept);

/// Leaves the rest of the edits in the scene if a file is given. Throws Error(usage) if no Gaussian
/// is left.
void apply_edits(Scene& scene, const EditOptions& options, ThreadPool& pool);

}  // namespace qs
