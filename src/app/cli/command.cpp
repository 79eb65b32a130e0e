// SPDX-License-Identifier: MIT
#include "app/cli/command.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "app/plugin/protocol.h"
#include "base/fail.h"
#include "base/list_of.h"
#include "base/path_kind.h"
#include "base/quit_signals.h"
#include "base/text.h"
#include "io/bytes/file_guard.h"
#include "options/suggestion.h"
#include "raster/api/renderer.h"
#include "version.h"

// One row per command, in the order of the help: NAME_command() is in cmd_NAME.cpp.
#define QS_COMMANDS(ROW)                                                      \
  ROW(view, "opens a scene in a window; the default command")                 \
  ROW(serve, "shows scenes in a browser, also of another machine")            \
  ROW(render, "renders a scene to picture files")                             \
  ROW(film, "films a scene from a moving camera")                             \
  ROW(train, "trains a scene from photographs")                               \
  ROW(eval, "measures PSNR and SSIM against photographs")                     \
  ROW(inspect, "lists the Gaussians of a pixel and the tiles of one of them") \
  ROW(measure, "measures distances and angles between points of a picture")   \
  ROW(compare, "draws crops and differences of culling modes side by side")   \
  ROW(judge, "measures PSNR, SSIM and FLIP of pictures against true ones")    \
  ROW(report, "writes a page that explains what a scene costs to render")     \
  ROW(bench, "measures the culling modes on scenes and views")                \
  ROW(zoom, "measures the culling modes while the camera approaches a point") \
  ROW(merge, "joins the reports of bench, eval and render that used --shard") \
  ROW(paper, "makes the paper's tables: trains and measures data sets")       \
  ROW(conformance, "writes scenes that test renderers, and judges them")      \
  ROW(info, "prints format, size and value ranges of scene files")            \
  ROW(convert, "writes a scene in another format")                            \
  ROW(lod, "writes huge scenes as a tree of levels of detail")

namespace qs {

#define QS_DECLARE(name, summary) CommandAction name##_command(Options& options);
QS_COMMANDS(QS_DECLARE)
#undef QS_DECLARE

namespace {

#define QS_ROW(name, summary) Command{#name, summary, name##_command},
constexpr Command kCommands[] = {QS_COMMANDS(QS_ROW)};
#undef QS_ROW

// Options of the program that a mistyped word may mean.
constexpr std::array kProgramOptions = {"--help", "--version", "--list-gpus", "--list-formats",
                                        "--man-page"};

std::string program_help() {
  std::string text =
      "quadsplat: real-time viewer and laboratory for 3D Gaussian Splatting tile culling\n\n"
      "usage: quadsplat [view] SCENE [options]\n"
      "       quadsplat COMMAND [options]\n\ncommands:\n";
  for (const Command& command : kCommands)
    text += fmt::format("  {:13}{}\n", command.name, command.summary);
  text +=
      "\n  quadsplat COMMAND --help   options and examples of a command\n"
      "  quadsplat --list-gpus      the GPUs that can render, or why none can\n"
      "  quadsplat --list-formats   scene formats that are read and written\n"
      "  quadsplat --version        version, commit and build\n"
      "  quadsplat --man-page       the manual page, and --bash-completion: for packages\n\n"
      "SCENE is a splat file or the folder of a trained model.\n"
      "Exit codes: 0 success, 1 wrong command line, 2 bad input, 3 no device or memory, 4 "
      "comparison failed, 130 interrupted.\n";
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

// Throws Error(usage) for a mistyped command, which would otherwise be read as a scene.
void check_first_word(const std::string& word) {
  if (word.starts_with('-') || is_there(word)) return;
  std::vector<std::string> names = list_of<std::string>(kCommands, &Command::name);
  names.insert(names.end(), kProgramOptions.begin(), kProgramOptions.end());
  const std::string meant = suggestion(word, names);
  if (!meant.empty()) fail(ErrorKind::usage, "'{}' is neither a command nor a file{}", word, meant);
}

// Throws Error(usage) if the command follows its options or its scene, which would be read as those
// of view.
void check_order(Arguments arguments, const Options& options) {
  const auto takes_value = [&](const std::string& word) {
    return std::ranges::any_of(options.table(), [&](const Option& option) {
      return option.most > 0 && (word == option.name || word == option.short_name());
    });
  };
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    const bool is_command = std::ranges::count(kCommands, word, &Command::name) > 0;
    if (!is_command || is_there(word) || takes_value(arguments[i - 1])) continue;
    fail(ErrorKind::usage, "the command comes before its {}: 'quadsplat {} {} ...'",
         arguments.front().starts_with('-') ? "options" : "scene", word, arguments.front());
  }
}

std::string interruption_sentence() {
  const WrittenFiles files = written_files();
  if (files.count == 0) return "interrupted: nothing was written";
  const std::string last = files.last.string();
  return files.count == 1 ? fmt::format("interrupted: {} is finished and kept", last)
                          : fmt::format("interrupted: {} finished files are kept, the last is {}",
                                        files.count, last);
}

// Runs a command whose options were parsed. The window gives its files new names and needs no
// guard.
int run_action(const CommandAction& action, const Options& options, Arguments arguments) {
  std::optional<FileGuard> guard;
  if (options.writes()) guard.emplace(options.overwrites());
  const EndAtSignal end(interruption_sentence);
  try {
    const int code = action(arguments);
    if (const std::size_t replaced = guard ? guard->replaced() : 0; replaced > 0)
      fmt::print(stderr, "replaced {} file{} of an earlier run\n", replaced,
                 replaced == 1 ? "" : "s");
    return code;
  } catch (const Cancelled&) {
    fmt::print(stderr, "quadsplat: {}\n", interruption_sentence());
    return kExitInterrupted;
  }
}

}  // namespace

std::span<const Command> commands() { return kCommands; }

int run_program(Arguments arguments) {
  static const std::string kView = kCommands[0].name;
  const bool has_display = std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
  if (arguments.empty() && has_display) arguments = {&kView, 1};
  if (arguments.empty()) {
    fmt::print(stderr, "{}", program_help());
    return kExitUsage;
  }
  const std::string& first = arguments.front();
  constexpr std::pair<const char*, std::string (*)()> kTexts[] = {
      {"--help", program_help},
      {"-h", program_help},
      {"--list-gpus", gpu_list},
      {"--man-page", man_page},
      {"--bash-completion", bash_completion},
      {"--list-formats", format_list},
      {"--version", version_text}};
  for (const auto& [name, text] : kTexts) {
    if (first != name) continue;
    fmt::print("{}", text());
    return kExitOk;
  }
  // bench --plugin starts this program with this command; users do not call it.
  if (first == kPluginHostCommand && arguments.size() == 2) return run_plugin_host(arguments[1]);
  const Command* command = std::ranges::find(kCommands, first, &Command::name);
  const bool named = command != std::end(kCommands);
  if (named) {
    arguments = arguments.subspan(1);
  } else {
    check_first_word(first);
    command = kCommands;  // view
  }
  Options options(command->name, command->summary);
  const CommandAction action = command->declare(options);
  if (!named) {
    check_order(arguments, options);
    options.may_mean({kProgramOptions.begin(), kProgramOptions.end()});
  }
  return options.parse(arguments) ? run_action(action, options, arguments) : int{kExitOk};
}

}  // namespace qs
