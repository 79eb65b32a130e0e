// SPDX-License-Identifier: MIT
#include "app/report/study_plots.h"

#include <algorithm>

#include <fmt/format.h>

#include "app/picture/palette.h"

namespace qs {
namespace {

std::string name_of(std::size_t mode_index) { return kCullers[mode_index + 1].name; }

double millions(std::uint64_t count) { return static_cast<double>(count) / 1e6; }

constexpr const char* kBars =
    "set style data histograms\nset style histogram clustered gap 1\nset yrange [0:*]\n";

std::string axis_of(const GaussianQuantity& quantity) {
  return *quantity.unit ? fmt::format("{} ({})", quantity.name, quantity.unit) : quantity.name;
}

/// One set of bars per mode, from column mode_index + 2 of the block, for the modes that `take`.
template <class Take>
std::string bars_per_mode(const char* block, const Take& take) {
  std::vector<std::string> curves;
  for (std::size_t mode = 0; mode < kCullerCount; ++mode) {
    if (take(mode))
      curves.push_back(fmt::format("${} using {}:xtic(1) {}", block, mode + 2,
                                   mode_options(name_of(mode), name_of(mode))));
  }
  return plot_command(curves);
}

Plot count_plot(const GaussianQuantity& quantity, const BinnedPairs& binned,
                const std::string& caption) {
  std::vector<std::string> lines;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    lines.push_back(fmt::format("{} {}", quoted(bin_label(quantity, bin)),
                                static_cast<double>(binned.gaussians[bin]) / 1e3));
  }
  return {fmt::format("count_{}", quantity.key),
          fmt::format("Visible Gaussians by {}", quantity.name), caption,
          data_block("bins", lines) + kBars +
              fmt::format("set xtics rotate by -35\nset boxwidth 0.9\nset xlabel {}\n"
                          "set ylabel \"visible Gaussians (thousands)\"\n",
                          quoted(axis_of(quantity))) +
              plot_command({"$bins using 2:xtic(1) " + color_option(kBlue) + " notitle"})};
}

Plot saved_plot(const GaussianQuantity& quantity, const BinnedPairs& binned,
                const std::string& caption) {
  std::vector<std::string> lines;
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    std::string& line = lines.emplace_back(quoted(bin_label(quantity, bin)));
    const double square = millions(binned.pairs[k3dgs - 1][bin]);
    for (const auto& pairs : binned.pairs)
      line += fmt::format(" {}", square - millions(pairs[bin]));
  }
  return {fmt::format("saved_{}", quantity.key),
          fmt::format("Pairs saved, by {} of the Gaussian", quantity.name), caption,
          data_block("bins", lines) + kBars +
              fmt::format("set xtics rotate by -35\nset yrange [*<0:*]\nset xlabel {}\n"
                          "set ylabel \"pairs saved against 3dgs (millions)\"\n",
                          quoted(axis_of(quantity))) +
              bars_per_mode("bins", [](std::size_t mode) {
                return static_cast<CullMode>(mode + 1) != k3dgs && name_of(mode) != "quadbox-naive";
              })};
}

Plot uses_plot(const SceneStudy& study, const std::string& caption) {
  std::vector<std::string> lines;
  for (std::size_t mode = 0; mode < kCullerCount; ++mode) {
    const PairUses& uses = study.modes[kUsualSize][mode].uses;
    lines.push_back(fmt::format("{} {} {} {}", quoted(name_of(mode)), millions(uses.used),
                                millions(uses.hidden), millions(uses.empty)));
  }
  return {"uses", "Used and unused pairs of each mode", caption,
          data_block("modes", lines) +
              "set style data histograms\nset style histogram rowstacked\nset boxwidth 0.7\n"
              "set yrange [0:*]\nset xtics rotate by -20\nset key invert\n"
              "set ylabel \"tile pairs (millions)\"\n" +
              plot_command(
                  {"$modes using 2:xtic(1) " + color_option(kBlue) + " title \"used by a pixel\"",
                   "$modes using 3 " + color_option(kOrange) + " title \"hidden\"",
                   "$modes using 4 " + color_option(kLightGray) + " title \"empty\""})};
}

Plot sizes_plot(const SceneStudy& study, const std::string& caption) {
  std::vector<std::string> lines;
  for (std::size_t size = 0; size < kTileSizes.size(); ++size) {
    std::string& line = lines.emplace_back(quoted(fmt::format("{0} x {0}", kTileSizes[size])));
    const double square = millions(study.modes[size][k3dgs - 1].pairs);
    for (const ModeStudy& mode : study.modes[size])
      line += fmt::format(" {}", millions(mode.pairs) / std::max(square, 1e-9));
  }
  return {"sizes", "Smaller tiles widen the gaps between the modes", caption,
          data_block("sizes", lines) + kBars +
              "set xrange [-0.6:2.6]\nset xlabel \"tile (pixels)\"\n"
              "set ylabel \"pairs, 3dgs = 1\"\n" +
              bars_per_mode("sizes", [](std::size_t) { return true; })};
}

Plot loads_plot(const SceneStudy& study, const std::string& caption) {
  constexpr int kPoints = 200;
  std::string text;
  std::vector<std::string> curves;
  for (std::size_t mode = 0; mode < kCullerCount; ++mode) {
    const std::vector<std::uint32_t>& loads = study.modes[kUsualSize][mode].loads;
    if (loads.empty()) continue;
    std::vector<std::string> lines;
    for (int i = 0; i <= kPoints; ++i) {
      const std::size_t at = (loads.size() - 1) * static_cast<std::size_t>(i) / kPoints;
      lines.push_back(fmt::format("{} {}", 100.0 * i / kPoints, loads[at]));
    }
    text += data_block(fmt::format("mode{}", mode), lines);
    curves.push_back(fmt::format("$mode{} using 1:2 with lines linewidth 2 {}", mode,
                                 mode_options(name_of(mode), name_of(mode))));
  }
  return {"loads", "Distribution of the pairs over the tiles", caption,
          text +
              "set xrange [0:100]\nset yrange [0:*]\nset xlabel \"share of the tiles (%)\"\n"
              "set ylabel \"pairs in a tile, at most\"\n" +
              plot_command(curves)};
}

}  // namespace

std::string bin_label(const GaussianQuantity& quantity, std::size_t bin) {
  const double low = quantity.edges[bin], high = quantity.edges[bin + 1];
  if (high >= 1e9) return fmt::format("{:.3g}+", low);
  if (bin == 0) return fmt::format("<{:.3g}", high);
  return fmt::format("{:.3g}-{:.3g}", low, high);
}

std::vector<Plot> study_plots(const SceneStudy& study, const std::string& caption) {
  std::vector<Plot> plots = {uses_plot(study, caption), sizes_plot(study, caption),
                             loads_plot(study, caption)};
  for (std::size_t q = 0; q < study.binned.size(); ++q) {
    plots.push_back(count_plot(quantities()[q], study.binned[q], caption));
    plots.push_back(saved_plot(quantities()[q], study.binned[q], caption));
  }
  return plots;
}

}  // namespace qs
