// SPDX-License-Identifier: MIT
//
// The options that several commands share, a function each. A command names the variable, and the
// words of the help that differ between commands.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/cli/options.h"
#include "app/measure/shard.h"
#include "app/picture/canvas.h"
#include "app/picture/heatmap.h"
#include "app/picture/value_map.h"
#include "app/session/session.h"
#include "learn/run/render_options.h"

namespace qs {

struct ViewOptions;
struct ViewPlan;

/// Samples of a scene argument, and its help.
inline const Options::Samples kSceneSamples = {"scene.ply", "model"};
inline constexpr const char* kSceneHelp = "splat file or model folder";

/// The cameras file: given with --cameras or found beside the scene's file; unset without.
std::optional<std::filesystem::path> cameras_file(const FrameOptions& frame,
                                                  const std::filesystem::path& scene);

/// Notes the scene's file and its cameras' as inputs, so that check_targets() refuses to write onto
/// them before any work. Throws Error(input) if there is no such scene.
void note_inputs(const FrameOptions& frame);

/// Throws Error(input) unless this is a folder. `command` is the command's name.
void require_folder(const char* command, const std::filesystem::path& folder);

/// Declares SCENE and the options of declare_common_options().
void declare_frame_options(Options& options, FrameOptions& frame);

/// Declares the options of every rendering command, without SCENE.
void declare_common_options(Options& options, FrameOptions& frame);

/// --axes.
void declare_axes_option(Options& options, std::string& axes);

/// --edits and --edits-anyway.
void declare_edit_options(Options& options, EditOptions& edits);

/// --picture, for commands in which it chooses the quantity of the pixels.
void declare_quantity_option(Options& options, Quantity& quantity, const std::string& help);

/// The quantity of heat maps and the upper end of their scale, as options give them.
struct HeatOptions {
  std::optional<HeatQuantity> quantity;
  std::optional<int> maximum;
};

/// --heatmap and --heatmap-max. `usual` names the default of the latter.
void declare_heatmap_options(Options& options, HeatOptions& heat, const std::string& usual);

/// Throws Error if there are no such maps of one of the modes. `command` is its name.
void require_heatmaps(const char* command, const HeatOptions& heat,
                      const std::vector<CullMode>& modes);

/// Throws Error if heat maps are wanted over another quantity than colours. `command`: its name.
void require_colors(const char* command, const HeatOptions& heat, Quantity quantity);

/// --camera-path.
void declare_camera_path_option(Options& options, std::optional<std::filesystem::path>& path);

/// --frames and --warmup, for each mode and `place`. The defaults are the values of `plan`.
void declare_plan_options(Options& options, ViewPlan& plan, const std::string& place);

/// --settings and --input of commands that open the window. Sets view.settings to its default.
void declare_window_options(Options& options, ViewOptions& view);

/// X,Y from 0. Throws Error(usage) "NAME: ...".
glm::ivec2 parse_pixel(const std::string& name, const std::string& text);

/// The value X,Y,W,H of --part, in pixels. Throws Error(usage) "--part: 'TEXT' is PROBLEM".
PixelRect parse_part(const std::string& text, const char* problem);

/// Throws Error(usage) unless the part lies in the pictures of the camera.
void require_part_inside(const PixelRect& part, const Camera& camera);

/// --exact-color. `what` is drawn so.
void declare_exact_color_option(Options& options, bool& exact_color, const std::string& what);

/// --occlusion: RenderSettings::occlusion.
void declare_occlusion_option(Options& options, FrameOptions& frame);

/// --budget and --lod-error; `in_window`: also --budget-ms.
void declare_level_options(Options& options, LevelOptions& levels, bool in_window = false);

/// --shard, for a Shard or a std::optional<Shard>.
template <class T>
void declare_shard_option(Options& options, T& shard, const std::string& help) {
  options.converted("--shard", "I/N", shard, parse_shard, help + "; see quadsplat merge",
                    {"1/1", "2/2"});
}

}  // namespace qs
