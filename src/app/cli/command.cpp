// SPDX-License-Identifier: MIT
#include "app/cli/command.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include <fmt/format.h>

#include "app/cli/format_list.h"
#include "app/session/text.h"
#include "raster/renderer.h"
#include "version.h"

namespace qs {
namespace {

constexpr std::array kCommands = {
    Command{"view", "opens a scene in a window; the command when none is named", run_view},
    Command{"render", "renders a scene to picture files", run_render},
    Command{"eval", "measures PSNR and SSIM against photographs", run_eval},
    Command{"inspect", "shows a pixel's Gaussians and how the modes cover one", run_inspect},
    Command{"compare", "draws crops and differences of modes side by side", run_compare},
    Command{"report", "writes a page that explains a scene's costs", run_report},
    Command{"bench", "measures the culling modes on scenes and views", run_bench},
    Command{"zoom", "measures the culling modes while zooming in", run_zoom},
    Command{"merge", "joins the reports of bench, eval and render --shard", run_merge},
    Command{"info", "tells what is in scene files", run_info},
    Command{"convert", "writes a scene in another format", run_convert},
};

std::string program_help() {
  std::string text =
      "quadsplat: real-time viewer and laboratory for 3D Gaussian Splatting tile culling\n\n"
      "usage: quadsplat [view] SCENE [options]\n"
      "       quadsplat COMMAND [options]\n\ncommands:\n";
  for (const Command& command : kCommands)
    text += fmt::format("  {:10}{}\n", command.name, command.summary);
  text +=
      "\n  quadsplat COMMAND --help   options and examples of a command\n"
      "  quadsplat --list-gpus      GPUs that can render, or why none can\n"
      "  quadsplat --list-formats   scene formats that are read and written\n"
      "  quadsplat --version        version, commit and build\n\n"
      "SCENE is a splat file or the folder of a trained model.\n"
      "Exit codes: 0 good, 1 wrong command line, 2 bad input, 3 no device or memory, 4 comparison "
      "failed.\n";
  return text;
}

std::string version_text() {
  return fmt::format("quadsplat {} (commit {}, {}{}{}{}{})\n", kVersion, kCommit, kBuildType,
                     *kSanitizers ? ", sanitizers " : "", kSanitizers,
                     *kCudaToolkit ? ", CUDA " : ", without CUDA", kCudaToolkit);
}

std::string gpu_list() {
  const GpuReport report = gpu_report();
  std::string text;
  for (std::size_t i = 0; i < report.gpus.size(); ++i) {
    const Gpu& gpu = report.gpus[i];
    text += fmt::format("{}: {}, compute capability {}.{}, {} of {} free{}{}\n", i, gpu.name,
                        gpu.major, gpu.minor, bytes_text(gpu.free_bytes),
                        bytes_text(gpu.total_bytes), gpu.problem.empty() ? "" : ": ", gpu.problem);
  }
  if (!report.problem.empty()) text += fmt::format("no GPU can be used: {}\n", report.problem);
  text += fmt::format("driver: {}; this program: {}\n",
                      report.driver.empty() ? "none" : "for CUDA up to " + report.driver,
                      report.runtime.empty() ? "without CUDA" : "CUDA runtime " + report.runtime);
  return text;
}

}  // namespace

std::span<const Command> commands() { return kCommands; }

int run_program(Arguments arguments) {
  if (arguments.empty()) {
    fmt::print(stderr, "{}", program_help());
    return kExitUsage;
  }
  const std::string& first = arguments.front();
  if (first == "--help" || first == "-h") {
    fmt::print("{}", program_help());
    return kExitOk;
  }
  if (first == "--list-gpus") {
    fmt::print("{}", gpu_list());
    return kExitOk;
  }
  if (first == "--list-formats") {
    fmt::print("{}", format_list());
    return kExitOk;
  }
  if (first == "--version") {
    fmt::print("{}", version_text());
    return kExitOk;
  }
  const auto command = std::find_if(kCommands.begin(), kCommands.end(),
                                    [&](const Command& row) { return first == row.name; });
  return command == kCommands.end() ? run_view(arguments) : command->run(arguments.subspan(1));
}

}  // namespace qs
