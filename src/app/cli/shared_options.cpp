// SPDX-License-Identifier: MIT
#include "app/cli/shared_options.h"

#include <algorithm>
#include <system_error>

#include "app/measure/measure_view.h"
#include "app/viewer/preferences.h"
#include "app/viewer/view_options.h"
#include "base/fail.h"
#include "base/path_kind.h"
#include "io/bytes/file_guard.h"
#include "io/camera/cameras.h"
#include "io/cloud/axes.h"
#include "io/scene/reader.h"
#include "options/suggestion.h"

namespace qs {
namespace {

std::string mode_names() { return joined(mode_list(), ", "); }

// Names separated by commas: a mode, "all" (modes 1 to culler_count()), or "+peers" (the modes of
// other papers). Alone, "+peers" adds to the `usual` modes of a command, or to "all" if these are
// empty because the command chooses them later.
std::vector<CullMode> parse_modes(const std::string& text, const std::vector<CullMode>& usual) {
  std::vector<CullMode> modes;
  const auto add = [&modes](const std::vector<CullMode>& more) {
    for (const CullMode mode : more)
      if (std::ranges::count(modes, mode) == 0) modes.push_back(mode);
  };
  if (text == "+peers") add(usual.empty() ? all_modes() : usual);
  for (const std::string& name : separated(text)) {
    const CullMode mode = find_culler(name);
    if (name == "all") {
      add(all_modes());
    } else if (name == "+peers") {
      add(peer_modes());
    } else if (mode >= 0) {
      add({mode});
    } else {
      std::vector<std::string> words = mode_list();
      words.insert(words.end(), {"all", "+peers"});
      fail(ErrorKind::usage, "--cull: '{}' is none of {}{}", name, joined(words, ", "),
           suggestion(name, words));
    }
  }
  return modes;
}

}  // namespace

void declare_edit_options(Options& options, EditOptions& edits) {
  options.text("--edits", "FILE", edits.file,
               "applies the edits of this file: selections, hidden and removed Gaussians, crops",
               {"plush.edits.json", "missing.json"});
  options.flag("--edits-anyway", edits.anyway,
               "applies edits of another scene, but for its visible and touching Gaussians");
}

namespace {

// The scene, its cameras and the size of their pictures.
void declare_scene(Options& options, FrameOptions& frame) {
  options.integer("--iteration", "N", 0, 1'000'000'000, frame.iteration,
                  "reads point_cloud/iteration_N of a model folder (default: the highest N)");
  declare_axes_option(options, frame.axes);
  declare_edit_options(options, frame.edits);
  options.text(
      "--cameras", "FILE", frame.cameras,
      "cameras.json, transforms.json or a COLMAP folder (default: the one beside the scene)",
      {"cameras.json", "missing.json"});
  options.converted(
      "--up", "DIR", frame.up, parse_direction,
      "direction that is up in the world: x, -x, y, -y, z, -z or X,Y,Z (default: what the "
      "file declares, else the cameras' or an estimate)",
      {"-y", "0,0.5,-1"});
  options.converted(
      "--size", "WxH", frame.size,
      [](const std::string& name, const std::string& text) { return parse_size(name, text); },
      "picture size in pixels; keeps the vertical field of view (default: the camera's)",
      {"48x32", "17x33"});
}

// The culling modes, the backend and its options.
void declare_renderer(Options& options, FrameOptions& frame) {
  options.value("--cull", "NAME",
                fmt::format("tile culling modes, with commas: {}; all = {} to {}, +peers = also "
                            "those of other papers",
                            mode_names(), mode_name(1), mode_name(culler_count())),
                {"3dgs", "all", "reference", "quadbox,dualbox", "accutile", "exact", "snugbox"},
                [&frame, usual = frame.modes](const std::string& text) {
                  frame.modes = parse_modes(text, usual);
                });
  options.offers(mode_list());
  declare_backend_option(options, frame.backend, "what renders");
  options.enumerated(
      "--pipeline", kPipelineNames, frame.settings.pipeline,
      fmt::format("implementation: classic follows the published 3DGS code, fast is optimised; "
                  "both draw the same images (default: {})",
                  kPipelineNames[static_cast<int>(kDefaultPipeline)]));
  declare_device_option(options, frame.device);
  declare_threads_option(options, frame.threads);
  options.choice(
      "--tile-size", {"8", "16", "32"},
      [&frame](int chosen) {
        frame.settings.tile_px = kTileSizes[static_cast<std::size_t>(chosen)];
      },
      "side of a tile in pixels; 8 and 32 need the CPU backend (default: 16)");
}

// The options that change the picture.
void declare_look(Options& options, FrameOptions& frame) {
  declare_sh_degree_option(options, frame.settings.sh_degree, "the scene's");
  options.real("--splat-scale", "X", 1e-6, 1e6, frame.settings.splat_scale,
               "factor on the size of every Gaussian (default: 1)");
  options.enumerated("--style", kDrawStyleNames, frame.settings.style,
                     "draws Gaussians as splats, as points of one size, or as solid ellipsoids "
                     "(default: splats)");
  declare_background_option(
      options, [&frame](const glm::vec3& color) { frame.background = color; },
      "the model's background, else black");
  options.choice(
      "--antialiased", {"on", "off", "auto"},
      [&frame](int chosen) {
        frame.settings.antialiased = chosen == 2 ? std::nullopt : std::optional(chosen == 0);
      },
      "opacity compensation of small Gaussians (default: auto, as the scene was trained)");
  options.flag("--skip-huge", frame.skip_huge,
               "leaves out Gaussians that are larger than the whole scene");
}

}  // namespace

std::optional<std::filesystem::path> cameras_file(const FrameOptions& frame,
                                                  const std::filesystem::path& scene) {
  return frame.cameras ? frame.cameras : find_cameras_file(scene);
}

void note_inputs(const FrameOptions& frame) {
  const std::filesystem::path scene = find_scene_file(frame.scene, frame.iteration);
  note_input(scene);
  if (const auto cameras = cameras_file(frame, scene)) note_input(*cameras);
}

void require_folder(const char* command, const std::filesystem::path& folder) {
  if (!is_there(folder)) fail("{}: {}: does not exist", command, folder.string());
  if (!is_folder(folder))
    fail("{}: {}: is a file, but a folder is needed", command, folder.string());
}

void declare_frame_options(Options& options, FrameOptions& frame) {
  options.positional("SCENE", frame.scene, kSceneHelp, kSceneSamples);
  declare_common_options(options, frame);
}

void declare_common_options(Options& options, FrameOptions& frame) {
  options.common([&] {
    declare_scene(options, frame);
    declare_renderer(options, frame);
    declare_look(options, frame);
  });
}

void declare_axes_option(Options& options, std::string& axes) {
  options.value(
      "--axes", "XYZ",
      "directions of x, y, z, a letter each: Right/Left, Down/Up, Back/Forward; RFU has z "
      "up (default: what the file declares)",
      {"LDF", "RFU"}, [&axes](const std::string& text) {
        if (!is_axes(text))
          fail(ErrorKind::usage,
               "--axes: '{}' is no right-handed frame of three letters, such as RDF (y "
               "down), RUB (y up) or RFU (z up)",
               text);
        axes = text;
      });
}

void declare_quantity_option(Options& options, Quantity& quantity, const std::string& help) {
  options.enumerated("--picture", quantity_names(), quantity, help);
}

void declare_heatmap_options(Options& options, HeatOptions& heat, const std::string& usual) {
  options.enumerated("--heatmap", heatmap_names(), heat.quantity,
                     "draws this quantity over the picture, with a colour scale");
  options.integer("--heatmap-max", "N", 1, 1'000'000'000, heat.maximum,
                  "largest value of the colour scale (default: " + usual + ")");
}

void require_heatmaps(const char* command, const HeatOptions& heat,
                      const std::vector<CullMode>& modes) {
  const HeatQuantity quantity = heat.quantity.value_or(HeatQuantity::evaluated);
  check_rules(command, {{quantity != HeatQuantity::evaluated &&
                             std::ranges::count(modes, kReferenceMode) > 0,
                         fmt::format("--heatmap {}: mode reference has no tile lists",
                                     heatmap_row(quantity).name)}});
}

void require_colors(const char* command, const HeatOptions& heat, Quantity quantity) {
  if (heat.quantity && quantity != Quantity::color)
    fail(ErrorKind::usage, "{}: --heatmap is drawn over colours, not over --picture {}", command,
         row_of(quantity).name);
}

void declare_camera_path_option(Options& options, std::optional<std::filesystem::path>& path) {
  options.text("--camera-path", "FILE", path,
               "views along the spline through the cameras of FILE, such as a path of the window",
               {"cameras.json"});
}

void declare_plan_options(Options& options, ViewPlan& plan, const std::string& place) {
  options.integer("--frames", "N", 1, 100000, plan.frames,
                  fmt::format("measured frames per mode and {} (default: {})", place, plan.frames));
  options.integer("--warmup", "N", 0, 100000, plan.warmup,
                  fmt::format("warm-up frames per mode and {} (default: {})", place, plan.warmup));
}

void declare_window_options(Options& options, ViewOptions& view) {
  view.settings = preferences_file();
  options.value(
      "--settings", "FILE",
      "file of the window's settings (default: ~/.config/quadsplat/viewer.json); - = none",
      {"-", "settings.json"},
      [&view](const std::string& text) { view.settings = text == "-" ? "" : text; });
  options.text("--input", "FILE", view.script,
               "plays an input script in the window, see docs/viewer.md", {"missing.txt"});
}

void declare_exact_color_option(Options& options, bool& exact_color, const std::string& what) {
  options.flag("--exact-color", exact_color,
               what +
                   " has the colours of the scene's network, which only models of Compact-3DGS "
                   "have, instead of spherical harmonics");
}

void declare_occlusion_option(Options& options, FrameOptions& frame) {
  options.choice(
      "--occlusion", {"on", "off"},
      [&frame](int chosen) { frame.settings.occlusion = chosen == 0; },
      "on: in views of many millions of Gaussians a GPU leaves out those that others hide; the "
      "picture is the same (default: off)");
}

void declare_level_options(Options& options, LevelOptions& levels, bool in_window) {
  levels.streams_large = true;
  options.integer(
      "--budget", "N", 1, 2'000'000'000, levels.budget,
      "draws at most N nodes of the tree of a .rad file, the best ones for each view, "
      "and reads only these (default: 1,000,000 if the scene does not fit into memory)");
  options.real("--lod-error", "X", 0, 1e12, levels.error,
               "draws no coarser node than one with this estimated error, see docs/lod.md; 0: all "
               "leaves");
  if (in_window)
    options.real("--budget-ms", "MS", 1, 10000, levels.budget_ms,
                 "moves the budget so that a frame takes this time");
}

glm::ivec2 parse_pixel(const std::string& name, const std::string& text) {
  const std::vector<std::string> words = separated(text);
  if (words.size() != 2) fail(ErrorKind::usage, "{}: '{}' is not X,Y", name, text);
  return {parse_integer(name, words[0], 0, 1'000'000), parse_integer(name, words[1], 0, 1'000'000)};
}

PixelRect parse_part(const std::string& text, const char* problem) {
  const std::vector<std::string> words = separated(text);
  if (words.size() != 4) fail(ErrorKind::usage, "--part: '{}' is {}", text, problem);
  int numbers[4];
  for (int i = 0; i < 4; ++i)
    numbers[i] =
        parse_integer("--part", words[static_cast<std::size_t>(i)], i < 2 ? 0 : 1, 1'000'000);
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

void require_part_inside(const PixelRect& part, const Camera& camera) {
  const int right = part.x + part.width, bottom = part.y + part.height;
  if (right <= camera.width && bottom <= camera.height) return;
  fail(ErrorKind::usage, "--part: it ends at {},{}, but the picture is {} x {}", right, bottom,
       camera.width, camera.height);
}

}  // namespace qs
