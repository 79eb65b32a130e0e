// SPDX-License-Identifier: MIT
#include "app/report/plot.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/picture/palette.h"
#include "base/child_process.h"
#include "base/error.h"
#include "base/text.h"
#include "io/bytes/replace_file.h"
#include "raster/kernel/cull/mode.h"

namespace qs {
namespace {

constexpr const char* kScript = R"(# {0}: draw it again with `gnuplot {0}.gp` in this folder
set encoding utf8
set termoption noenhanced
set title {1} . "\n" . {2}{5} font ",19"
set grid back ytics linetype 1 linewidth 0.5 linecolor rgb "{4}"
set border 3
set tics nomirror out
set style fill solid noborder
set key outside right top spacing 1.2
{3}
)";

// Sizes and fonts are readable at half size. `replot` repeats the script's plot command.
std::string script(const Plot& plot) {
  return fmt::format(
             "set terminal pngcairo size 1400,800 font 'sans,17' linewidth 2 background 'white'\n"
             "set output {}\n",
             quoted(plot.name + ".png")) +
         fmt::format(fmt::runtime(kScript), plot.name, quoted(plot.title), quoted(plot.caption),
                     plot.commands, hex_text(on_white::kLine),
                     plot.altered.empty() ? "" : " . \"\\n\" . " + quoted(plot.altered)) +
         fmt::format(
             "set terminal svg size 1400,800 font 'sans,17' fontscale 1.3 linewidth 2 "
             "background 'white'\n"
             "set output {}\nreplot\nunset output\n",
             quoted(plot.name + ".svg"));
}

// Runs gnuplot in `folder` with its messages dropped. Returns "" or the problem.
std::string run_gnuplot(const std::filesystem::path& folder, const std::string& file) {
  constexpr int kNotFound = 127;  // a shell's exit code for a missing program
  ChildEnd end{kNotFound};
  try {
    end = ChildProcess({.words = {"gnuplot", file}, .folder = folder}).wait();
  } catch (const Error&) {
  }
  if (end.good()) return "";
  if (end.exit_code == kNotFound) return "gnuplot is not installed";
  return fmt::format("gnuplot failed on {} ({})", file,
                     end.signal != 0 ? end.text() : fmt::format("{}", end.exit_code));
}

}  // namespace

std::string draw_plots(const std::filesystem::path& folder, std::span<const Plot> plots,
                       const std::filesystem::path& shown) {
  std::string sentence;
  for (const Plot& plot : plots) {
    const std::string file = plot.name + ".gp";
    write_text(folder / file, script(plot));
    if (!sentence.empty()) continue;
    const std::string problem = run_gnuplot(folder, file);
    if (!problem.empty())
      sentence = fmt::format("{}; draw the plots with 'cd {} && gnuplot *.gp'", problem,
                             (shown.empty() ? folder : shown).string());
  }
  return sentence;
}

std::string quoted(const std::string& text) {
  return '"' + escaped(text, {{'"', "\\\""}, {'\\', "\\\\"}, {'`', "\\`"}, {'\n', " "}}) + '"';
}

std::string data_block(const std::string& name, const std::vector<std::string>& lines) {
  std::string text = fmt::format("${} << END\n", name);
  for (const std::string& line : lines) text += line + "\n";
  return text + "END\n";
}

std::string plot_command(const std::vector<std::string>& curves) {
  return "plot " + joined(curves, ", \\\n  ");
}

std::string color_option(glm::vec3 color) { return "linecolor rgb " + quoted(hex_text(color)); }

std::string mode_color_option(const std::string& mode) {
  return color_option(mode_color(find_culler(mode)));
}

std::string mode_options(const std::string& mode, const std::string& title) {
  return fmt::format("{} title {}", mode_color_option(mode), quoted(title));
}

int mode_marker(const std::string& mode) {
  // 5, 7, .. 15 are six filled shapes, 4, 6, .. 14 their outlines.
  const CullMode culler = std::max(0, find_culler(mode));
  return culler <= culler_count() ? 5 + 2 * (culler % 6) : 4 + 2 * ((culler - culler_count()) % 6);
}

std::string plugin_options(std::size_t number, const std::string& title) {
  return fmt::format("{} title {}", color_option(plugin_color(number)), quoted(title));
}

int plugin_marker(std::size_t number) {
  return 4 + 2 * static_cast<int>(number % 6);  // 4, 6, .. 14 are six outlined shapes
}

}  // namespace qs
