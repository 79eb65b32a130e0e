// SPDX-License-Identifier: MIT
//
// The settings and edits that alter a scene: its numbers and pictures differ from the numbers and
// pictures of its file. Everything that is written says them, and says nothing if there are none.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "app/session/session.h"

namespace qs {

/// The facts of a scene from which settings differ.
struct SceneNature {
  int sh_degree = 0;
  bool antialiased = false, white_background = false;
  std::string axes, declared_axes;  ///< as it was read, and as the file declares
  EditFacts edits;
  const char* exact_colors = "";  ///< "all" or "reference": the frames with the network's colours
  bool levels = false;            ///< cuts are drawn in the place of all leaves
};

/// All alterations of a scene. To add a setting: a line in alterations_of().
struct Alterations {
  /// {"splat_scale": 0.56, "edits": {...}, "text": "..."}; null if nothing is altered.
  nlohmann::ordered_json json;
  /// "splat scale 0.56, edited: 1 step, 23,615 of 34,321 Gaussians, crc32:89abcdef"; or empty.
  std::string text;
  std::string brief;  ///< for a window: "splat scale 0.56, edited: 23,615 of 34,321 Gaussians"

  /// Sets "altered" in an object, if anything is altered.
  void add_to(nlohmann::ordered_json& object) const;
};

Alterations alterations_of(const RenderSettings& settings, const SceneNature& scene);
Alterations alterations_of(const Session& session);

/// ", splat scale 0.56" for the end of a line; empty if nothing is altered.
std::string altered_clause(const Session& session);

}  // namespace qs
