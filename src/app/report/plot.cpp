// SPDX-License-Identifier: MIT
#include "app/report/plot.h"

#include <algorithm>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/report/stats_file.h"
#include "raster/kernel/cull/modes.h"

namespace qs {
namespace {

constexpr const char* kScript = R"(# {0}: draw it again with `gnuplot {0}.gp` in this folder
set encoding utf8
set termoption noenhanced
set title {1} . "\n" . {2} font ",19"
set grid back ytics linetype 1 linewidth 0.5 linecolor rgb "#d0d0d0"
set border 3
set tics nomirror out
set style fill solid noborder
set key outside right top spacing 1.2
{3}
)";

// Sizes and fonts that stay readable at half size. `replot` repeats the script's one plot command.
std::string script(const Plot& plot) {
  return fmt::format(
             "set terminal pngcairo size 1400,800 font 'sans,17' linewidth 2 background 'white'\n"
             "set output {}\n",
             quoted(plot.name + ".png")) +
         fmt::format(fmt::runtime(kScript), plot.name, quoted(plot.title), quoted(plot.caption),
                     plot.commands) +
         fmt::format(
             "set terminal svg size 1400,800 font 'sans,17' fontscale 1.3 linewidth 2 "
             "background 'white'\n"
             "set output {}\nreplot\nunset output\n",
             quoted(plot.name + ".svg"));
}

// Exit code of gnuplot run in `folder`, its messages dropped; 127 when it cannot be started.
int run_gnuplot(const std::filesystem::path& folder, const std::string& file) {
  const pid_t child = fork();
  if (child < 0) return 127;
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (chdir(folder.c_str()) != 0 || nowhere < 0) _exit(127);
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    execlp("gnuplot", "gnuplot", file.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 127;
}

}  // namespace

std::string draw_plots(const std::filesystem::path& folder, std::span<const Plot> plots) {
  std::string sentence;
  for (const Plot& plot : plots) {
    const std::string file = plot.name + ".gp";
    write_stats(folder / file, script(plot));
    if (!sentence.empty()) continue;
    const int code = run_gnuplot(folder, file);
    if (code != 0) {
      sentence = fmt::format("{}; draw the plots with 'cd {} && gnuplot *.gp'",
                             code == 127 ? "gnuplot is not installed"
                                         : fmt::format("gnuplot failed on {} ({})", file, code),
                             folder.string());
    }
  }
  return sentence;
}

int mode_marker(const std::string& mode) {
  return 5 + 2 * (std::max(0, find_culler(mode)) % 6);  // 5, 7, .. 15 are six filled shapes
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\' || c == '`') result += '\\';
    result += c == '\n' ? ' ' : c;
  }
  return result + "\"";
}

}  // namespace qs
