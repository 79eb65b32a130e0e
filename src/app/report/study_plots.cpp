// SPDX-License-Identifier: MIT
#include "app/report/study_plots.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/picture/palette.h"

namespace qs {
namespace {

constexpr CullMode k3dgs = find_culler("3dgs");

std::string name_of(std::size_t mode_index) { return kCullers[mode_index + 1].name; }

double millions(std::uint64_t count) { return static_cast<double>(count) / 1e6; }

constexpr const char* kBars =
    "set style data histograms\nset style histogram clustered gap 1\nset yrange [0:*]\n"
    "set xtics rotate by -35\n";

std::string axis_of(const Quantity& quantity) {
  return *quantity.unit ? fmt::format("{} ({})", quantity.name, quantity.unit) : quantity.name;
}

Plot many_plot(const Quantity& quantity, const BinnedPairs& binned, const std::string& caption) {
  std::string text = "$bins << END\n";
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    text += fmt::format("{} {}\n", quoted(bin_label(quantity, bin)),
                        static_cast<double>(binned.gaussians[bin]) / 1e3);
  }
  text += fmt::format(
      "END\n{}set boxwidth 0.9\nset xlabel {}\nset ylabel \"visible Gaussians (thousands)\"\n"
      "plot $bins using 2:xtic(1) linecolor rgb \"#0072B2\" notitle",
      kBars, quoted(axis_of(quantity)));
  return {fmt::format("many_{}", quantity.key),
          fmt::format("How many visible Gaussians have which {}", quantity.name), caption, text};
}

Plot saved_plot(const Quantity& quantity, const BinnedPairs& binned, const std::string& caption) {
  std::string text = "$bins << END\n";
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    text += quoted(bin_label(quantity, bin));
    const double square = millions(binned.pairs[k3dgs - 1][bin]);
    for (std::size_t mode = 0; mode < kCullerCount; ++mode)
      text += fmt::format(" {}", square - millions(binned.pairs[mode][bin]));
    text += "\n";
  }
  text += fmt::format(
      "END\n{}set yrange [*<0:*]\nset xlabel {}\nset ylabel \"pairs saved against 3dgs "
      "(millions)\"\n"
      "plot ",
      kBars, quoted(axis_of(quantity)));
  bool first = true;
  for (std::size_t mode = 0; mode < kCullerCount; ++mode) {
    if (static_cast<CullMode>(mode + 1) == k3dgs || name_of(mode) == "quadbox-naive") continue;
    text +=
        fmt::format("{}$bins using {}:xtic(1) linecolor rgb {} title {}", first ? "" : ", \\\n  ",
                    mode + 2, quoted(mode_color(name_of(mode))), quoted(name_of(mode)));
    first = false;
  }
  return {fmt::format("saved_{}", quantity.key),
          fmt::format("Whose pairs are saved: Gaussians by {}", quantity.name), caption, text};
}

Plot uses_plot(const SceneStudy& study, const std::string& caption) {
  std::string text = "$modes << END\n";
  for (std::size_t mode = 0; mode < kCullerCount; ++mode) {
    const PairUses& uses = study.modes[kUsualSize][mode].uses;
    text += fmt::format("{} {} {} {}\n", quoted(name_of(mode)), millions(uses.used),
                        millions(uses.hidden), millions(uses.empty));
  }
  text +=
      "END\nset style data histograms\nset style histogram rowstacked\nset boxwidth 0.7\n"
      "set yrange [0:*]\nset xtics rotate by -20\nset key invert\nset ylabel \"tile pairs "
      "(millions)\"\n"
      "plot $modes using 2:xtic(1) linecolor rgb \"#0072B2\" title \"used by a pixel\", \\\n"
      "  $modes using 3 linecolor rgb \"#E69F00\" title \"hidden\", \\\n"
      "  $modes using 4 linecolor rgb \"#BBBBBB\" title \"empty\"";
  return {"uses", "What becomes of the pairs that each mode lists", caption, text};
}

Plot sizes_plot(const SceneStudy& study, const std::string& caption) {
  std::string text = "$sizes << END\n";
  for (std::size_t size = 0; size < kTileSizes.size(); ++size) {
    text += quoted(fmt::format("{0} x {0}", kTileSizes[size]));
    const double square = millions(study.modes[size][k3dgs - 1].pairs);
    for (std::size_t mode = 0; mode < kCullerCount; ++mode)
      text += fmt::format(" {}", millions(study.modes[size][mode].pairs) / std::max(square, 1e-9));
    text += "\n";
  }
  text += fmt::format("END\n{}set xlabel \"tile (pixels)\"\nset ylabel \"pairs, 3dgs = 1\"\nplot ",
                      "set style data histograms\nset style histogram clustered gap 1\n"
                      "set yrange [0:*]\nset xrange [-0.6:2.6]\n");
  for (std::size_t mode = 0; mode < kCullerCount; ++mode) {
    text += fmt::format("{}$sizes using {}:xtic(1) linecolor rgb {} title {}",
                        mode == 0 ? "" : ", \\\n  ", mode + 2, quoted(mode_color(name_of(mode))),
                        quoted(name_of(mode)));
  }
  return {"sizes", "Finer tiles widen the gaps between the modes", caption, text};
}

Plot loads_plot(const SceneStudy& study, const std::string& caption) {
  constexpr int kPoints = 200;
  std::string text, plots = "plot ";
  for (std::size_t mode = 0; mode < kCullerCount; ++mode) {
    const std::vector<std::uint32_t>& loads = study.modes[kUsualSize][mode].loads;
    if (loads.empty()) continue;
    text += fmt::format("$mode{} << END\n", mode);
    for (int i = 0; i <= kPoints; ++i) {
      const std::size_t at = (loads.size() - 1) * static_cast<std::size_t>(i) / kPoints;
      text += fmt::format("{} {}\n", 100.0 * i / kPoints, loads[at]);
    }
    text += "END\n";
    plots += fmt::format("{}$mode{} using 1:2 with lines linewidth 2 linecolor rgb {} title {}",
                         mode == 0 ? "" : ", \\\n  ", mode, quoted(mode_color(name_of(mode))),
                         quoted(name_of(mode)));
  }
  text +=
      "set xrange [0:100]\nset yrange [0:*]\nset xlabel \"share of the tiles (%)\"\n"
      "set ylabel \"pairs in a tile, at most\"\n";
  return {"loads", "How evenly the tiles are loaded", caption, text + plots};
}

}  // namespace

std::string bin_label(const Quantity& quantity, std::size_t bin) {
  const double low = quantity.edges[bin], high = quantity.edges[bin + 1];
  if (high >= 1e9) return fmt::format("{:.3g}+", low);
  if (bin == 0) return fmt::format("<{:.2g}", high);
  return fmt::format("{:.3g}-{:.3g}", low, high);
}

std::vector<Plot> study_plots(const SceneStudy& study, const std::string& caption) {
  std::vector<Plot> plots = {uses_plot(study, caption), sizes_plot(study, caption),
                             loads_plot(study, caption)};
  for (std::size_t q = 0; q < study.binned.size(); ++q) {
    plots.push_back(many_plot(quantities()[q], study.binned[q], caption));
    plots.push_back(saved_plot(quantities()[q], study.binned[q], caption));
  }
  return plots;
}

}  // namespace qs
