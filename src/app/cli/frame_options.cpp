// SPDX-License-Identifier: MIT
#include "app/cli/frame_options.h"

#include <algorithm>

#include "io/cloud/axes.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

std::vector<std::string> mode_list() {
  std::vector<std::string> names;
  for (const CullerRow& row : kCullers) names.emplace_back(row.name);
  return names;
}

std::string mode_names() { return joined(mode_list(), ", "); }

// Names separated by commas: a mode, "all" (modes 1 to kCullerCount), or "+peers" (the modes of
// other papers). Alone, "+peers" adds to the `usual` modes of a command, or to "all" if these are
// empty because the command chooses them later.
std::vector<CullMode> parse_modes(const std::string& text, const std::vector<CullMode>& usual) {
  std::vector<CullMode> modes;
  const auto add = [&modes](const std::vector<CullMode>& more) {
    for (const CullMode mode : more)
      if (std::find(modes.begin(), modes.end(), mode) == modes.end()) modes.push_back(mode);
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
      fail(ErrorKind::usage, "--cull: '{}' is none of {}, all, +peers", name, mode_names());
    }
  }
  return modes;
}

}  // namespace

void declare_frame_options(Options& options, FrameOptions& frame) {
  options.positional("SCENE", frame.scene, "splat file or model folder", kSceneSamples);
  declare_common_options(options, frame);
}

namespace {

void declare_all(Options& options, FrameOptions& frame) {
  options.integer("--iteration", "N", 0, 1'000'000'000, frame.iteration,
                  "reads point_cloud/iteration_N of a model folder (default: the highest N)");
  declare_axes_option(options, frame.axes);
  options.text(
      "--cameras", "FILE", frame.cameras,
      "cameras.json, transforms.json or a COLMAP folder (default: the one beside the scene)",
      {"cameras.json", "missing.json"});
  options.value(
      "--up", "DIR",
      "direction that is up in the world: x, -x, y, -y, z, -z or X,Y,Z (default: what the "
      "file declares, else the cameras' or an estimate)",
      {"-y", "0,0.5,-1"},
      [&frame](const std::string& text) { frame.up = parse_direction("--up", text); });
  options.value("--size", "WxH",
                "picture size in pixels; keeps the vertical field of view (default: the camera's)",
                {"48x32", "17x33"},
                [&frame](const std::string& text) { frame.size = parse_size("--size", text); });
  options.value("--cull", "NAME",
                fmt::format("tile culling modes, with commas: {}; all = {} to {}, +peers = also "
                            "those of other papers",
                            mode_names(), mode_name(1), mode_name(kCullerCount)),
                {"3dgs", "all", "reference", "quadbox,dualbox", "accutile", "exact", "snugbox"},
                [&frame, usual = frame.modes](const std::string& text) {
                  frame.modes = parse_modes(text, usual);
                });
  options.offers(mode_list());
  options.choice(
      "--backend", {std::begin(kBackendNames), std::end(kBackendNames)},
      [&frame](int chosen) { frame.backend = static_cast<Backend>(chosen); },
      "what renders (default: cuda where it works, else cpu)");
  options.choice(
      "--pipeline", {std::begin(kPipelineNames), std::end(kPipelineNames)},
      [&frame](int chosen) { frame.pipeline = static_cast<Pipeline>(chosen); },
      fmt::format("implementation: classic follows the published 3DGS code, fast is optimised; "
                  "both draw the same images (default: {})",
                  kPipelineNames[static_cast<int>(kDefaultPipeline)]));
  options.integer("--device", "N", 0, 1024, frame.device,
                  "GPU of the CUDA backend, numbered as in quadsplat --list-gpus (default: 0)");
  options.integer("--threads", "N", 1, 1024, frame.threads,
                  "CPU threads (default: one per hardware thread)");
  options.choice(
      "--tile-size", {"8", "16", "32"},
      [&frame](int chosen) { frame.tile_px = kTileSizes[static_cast<std::size_t>(chosen)]; },
      "side of a tile in pixels; 8 and 32 need the CPU backend (default: 16)");
  options.integer("--sh-degree", "N", 0, kMaxShDegree, frame.sh_degree,
                  "highest degree of view-dependent colour (default: the scene's)");
  options.real("--splat-scale", "X", 1e-6, 1e6, frame.splat_scale,
               "factor on the size of every Gaussian (default: 1)");
  options.value("--background", "R,G,B", "each 0..1 (default: the model's background, else black)",
                {"1,0.5,0"}, [&frame](const std::string& text) {
                  frame.background = parse_color("--background", text);
                });
  options.choice(
      "--antialiased", {"on", "off", "auto"},
      [&frame](int chosen) {
        frame.antialiased = chosen == 2 ? std::nullopt : std::optional(chosen == 0);
      },
      "opacity compensation of small Gaussians (default: auto, as the scene was trained)");
  options.flag("--skip-huge", frame.skip_huge,
               "leaves out Gaussians that are larger than the whole scene");
}

}  // namespace

void declare_common_options(Options& options, FrameOptions& frame) {
  options.common([&] { declare_all(options, frame); });
}

void declare_axes_option(Options& options, std::string& axes) {
  options.value(
      "--axes", "XYZ",
      "directions of x, y, z, a letter each: Right/Left, Down/Up, Back/Forward; RFU has z "
      "up (default: what the file declares)",
      {"LDF", "RFU"}, [&axes](const std::string& text) {
        if (!is_axes(text)) {
          fail(ErrorKind::usage,
               "--axes: '{}' is no right-handed frame of three letters, such as RDF (y "
               "down), RUB (y up) or RFU (z up)",
               text);
        }
        axes = text;
      });
}

}  // namespace qs
