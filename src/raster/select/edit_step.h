// SPDX-License-Identifier: MIT
//
// The steps of editing a scene, as data. A scene's edits are a list of steps; io/edits reads and
// writes it as a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "raster/scene/camera.h"
#include "raster/scene/gaussian_set.h"
#include "raster/scene/removal.h"
#include "raster/select/by_value.h"

namespace qs {

/// The tools that select. The first four draw in a picture.
enum class SelectTool : std::uint8_t {
  rectangle,  ///< two corners
  polygon,
  lasso,
  brush,  ///< a stroke with a radius
  sphere,
  box,
  color,
  opacity,
  size,
  distance,
  list,  ///< SelectStep::members
  flood,
  grow,
  shrink,
  invert,
  all,
  none
};
/// Index = SelectTool.
inline constexpr const char* kSelectToolNames[] = {
    "rectangle", "polygon", "lasso", "brush", "sphere", "box",    "color", "opacity", "size",
    "distance",  "list",    "flood", "grow",  "shrink", "invert", "all",   "none"};

constexpr bool draws_in_picture(SelectTool tool) { return tool <= SelectTool::brush; }
/// True for tools that change the selection as it is, so that SelectHow does not matter.
constexpr bool changes_selection(SelectTool tool) { return tool >= SelectTool::flood; }

/// The new selection from the tool's Gaussians and the old selection.
enum class SelectHow : std::uint8_t { replace, add, take_away, common };
/// Index = SelectHow.
inline constexpr const char* kSelectHowNames[] = {"replace", "add", "take away", "common"};

/// The Gaussians that a tool in a picture meets.
enum class SelectKind : std::uint8_t {
  visible,   ///< a pixel under the tool blends it with at least SelectStep::weight
  touching,  ///< a pixel under the tool blends it
  through    ///< its centre is under the tool
};
/// Index = SelectKind.
inline constexpr const char* kSelectKindNames[] = {"visible", "touching", "through"};

inline constexpr float kSelectWeight = 0.05f;

/// One act of selecting. Each tool uses some of the members; io/edits/edits_file.cpp has the table.
struct SelectStep {
  SelectTool tool = SelectTool::all;
  SelectHow how = SelectHow::replace;
  SelectKind kind = SelectKind::visible;
  float weight = kSelectWeight;  ///< 0..1
  Camera camera = {};            ///< of the picture
  std::vector<glm::dvec2> pixels = {};
  double radius = 0;      ///< > 0; brush: pixels, sphere: world units
  glm::dvec3 point{0.0};  ///< as the cloud's positions count
  std::optional<glm::dvec3> normal = {};
  CropBox box = {};
  glm::dvec3 color{0.0};  ///< sRGB, 0..1
  double tolerance = 0;   ///< CIELAB
  ValueRange range = {};
  int steps = 1;  ///< of grow and shrink

  // The result. A list is used in place of the tool, because visible and touching Gaussians can
  // differ between machines where a weight is next to the limit.
  std::optional<std::uint64_t> count = {};  ///< of the selection after the step
  std::string crc = {};                     ///< its hash, see set_hash(); empty: unknown
  std::optional<std::vector<GaussianRun>> members = {};
};

/// True if the Gaussians of the step depend on a frame.
inline bool needs_frame(const SelectStep& step) {
  return draws_in_picture(step.tool) && step.kind != SelectKind::through;
}

enum class EditKind : std::uint8_t {
  select,
  hide,      ///< hides the selected Gaussians
  show,      ///< shows all hidden Gaussians
  remove,    ///< removes the selected Gaussians
  keep,      ///< removes the Gaussians that are not selected, except hidden ones
  crop,      ///< removes the Gaussians with centres outside of `box`
  floaters,  ///< removes floaters
  scale,     ///< for convert: the scene is `factor` times as large
  level      ///< for convert: the scene is turned by `rotation`
};
/// Index = EditKind.
inline constexpr const char* kEditKindNames[] = {"select", "hide",     "show",  "remove", "keep",
                                                 "crop",   "floaters", "scale", "level"};

/// True for steps that can take Gaussians out of the picture.
constexpr bool takes_away(EditKind kind) {
  return kind == EditKind::hide || (kind >= EditKind::remove && kind <= EditKind::floaters);
}

struct EditStep {
  EditKind kind = EditKind::select;
  SelectStep select = {};
  CropBox box = {};
  Floaters floaters = {};
  double factor = 1;                ///< > 0
  std::string unit = {};            ///< of the scaled scene: "m"; empty: none
  glm::dquat rotation{1, 0, 0, 0};  ///< to the scene as it is written, a unit quaternion
};

}  // namespace qs
