// SPDX-License-Identifier: MIT
//
// The words and numbers of the panels, apart from their drawing, so that tests can compare them
// with independent computations. The performance panel's are in hud_text.h.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <glm/vec2.hpp>

#include "app/session/alterations.h"
#include "app/viewer/state/viewer.h"

namespace qs {

/// A label and its value.
struct Fact {
  std::string label, value;
};

/// "garden   500 Gaussians   cpu   640 x 480": the right end of the menu bar.
std::string scene_summary(const Viewer& viewer);

/// The settings of the window's picture. A picture with maps of tiles, or of several frames, has no
/// lens of faces; an orthographic picture is as high as the view at the pivot.
RenderSettings shown_settings(const Viewer& viewer);

/// The alterations of the scene in the window, of which its pictures and numbers are. Empty without
/// a scene.
Alterations alterations_of(const Viewer& viewer);

/// The facts of the scene and of the view.
std::vector<Fact> scene_facts_of(const Viewer& viewer);

/// An entry of the list of cameras, and of the list of keyframes; both count from 0.
std::string camera_label(const ViewedScene& scene, std::size_t index);
std::string keyframe_label(const Viewer& viewer, std::size_t index);

inline constexpr const char* kNothingInspected = "Click a pixel of the picture.";
inline constexpr const char* kInspectedEarlier = "of an earlier view: click again";

/// Depth, alpha, transmittance in front and weight of a Gaussian in the inspected pixel; `stops`:
/// the pixel stopped before it, so it has no weight.
std::array<std::string, 4> contribution_cells(const Contribution& row, bool stops);
std::string inspected_pixel_text(const PixelReport& pixel);

/// The legend of the heat map in the window. Its facts are heat_facts() and scale_text().
Legend heat_legend(const Viewer& viewer);

/// The map that the user chose, while the picture does not show it yet.
std::optional<HeatQuantity> awaited_map(const Viewer& viewer);

/// The title of awaited_map(), empty if there is none, and the words behind it.
std::string awaited_title(const Viewer& viewer);
inline constexpr const char* kComputing = "computing ...";

/// For a window with a heat map: the mode with its total, or both totals of a split window.
std::string heat_facts(const Viewer& viewer);

/// The mode whose map gives the heat map in the window its scale.
CullMode mode_of_scale(const Viewer& viewer);

/// The origin of the scale: "scale of 3dgs", "fixed scale", or "scale of an earlier view" while the
/// camera moves.
std::string scale_text(const Viewer& viewer);

/// The heat map at a pixel of the picture: in a split window the map of the pixel's side.
const Heatmap& heatmap_at(const Viewer& viewer, glm::dvec2 pixel);

/// The value in a cell of `map`, which is a map of `shown`.
std::string heat_text(const ShownFrame& shown, const Heatmap& map, std::size_t cell);

/// The value at a pixel of ShownFrame::values, which must exist.
std::string value_text(const ShownFrame& shown, std::size_t pixel);

/// The names of the scene and of the second scene: their paths if the names are equal.
std::array<std::string, 2> names_of_scenes(const Viewer& viewer, const SceneBeside& beside);

/// For a split window with two frames: the names of the variants or scenes on the left and on the
/// right, and the legend of the map of pair differences.
std::array<std::string, 2> split_names(const Viewer& viewer);
Legend pair_legend(const ShownFrame& shown);

/// The factor by which the difference of a split window is shown: Split::amplification, or chosen
/// from the frames.
int shown_amplification(const Viewer& viewer);

/// Viewer::split with shown_amplification().
Split shown_split(const Viewer& viewer);

/// The legend of the map of differences, from the 8-bit difference that is drawn black to the one
/// that is drawn white.
Legend difference_legend(int amplification);

/// True if the last comparison with the reference is of the view and the mode in the window.
bool verdict_is_current(const Viewer& viewer);

/// The facts of a comparison: its subject, the numbers, the failing pixel and the reason.
std::vector<Fact> verdict_facts(const ReferenceComparison& comparison);

/// Minutes and seconds since the start: "3:07".
std::string log_time(const LogEntry& entry);

/// "photograph frame_7.png · PSNR 31.20 dB, SSIM 0.941": the numbers are of the view in the window.
std::string photograph_text(const Viewer& viewer);

/// The hints that are still shown.
std::vector<std::string> hint_texts(const Hints& hints);

// ---- messages that are shortened to fit
// ----------------------------------------------------------
/// The text with at most `most` letters, at least 3: an ellipsis replaces letters in its middle, so
/// that the begin of a path and the name of its file stay. The text is UTF-8.
std::string shortened_middle(const std::string& text, std::size_t most);

/// The leading parts of a text for which fits() holds, at least the first; `separator`: between
/// parts.
std::string fitting_parts(std::string text, std::string_view separator,
                          const std::function<bool(const std::string&)>& fits);

/// The letters of a UTF-8 text.
std::size_t letters_of(const std::string& text);

}  // namespace qs
