// SPDX-License-Identifier: MIT
#include "app/report/study_page.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "app/framing/scene_box.h"
#include "app/picture/palette.h"
#include "app/report/html_page.h"
#include "base/temporaries.h"
#include "base/text.h"

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
  for (std::size_t mode = 0; mode < kCullerCount; ++mode)
    if (take(mode))
      curves.push_back(fmt::format("${} using {}:xtic(1) {}", block, mode + 2,
                                   mode_options(name_of(mode), name_of(mode))));
  return plot_command(curves);
}

Plot count_plot(const GaussianQuantity& quantity, const BinnedPairs& binned,
                const std::string& caption) {
  std::vector<std::string> lines;
  for (std::size_t bin = 0; bin < kBins; ++bin)
    lines.push_back(fmt::format("{} {}", quoted(bin_label(quantity, bin)),
                                static_cast<double>(binned.gaussians[bin]) / 1e3));
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
    for (const auto& pairs : binned.pairs)
      line += fmt::format(" {}", millions(binned.pairs[k3dgs - 1][bin]) - millions(pairs[bin]));
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

using Row = std::vector<std::string>;

constexpr std::size_t index_of(CullMode mode) { return static_cast<std::size_t>(mode - 1); }

/// A share in percent; "-" if the whole is 0.
template <class Count>
std::string ratio(Count part, Count whole, const char* format = "{:.2f}", double factor = 1) {
  if (whole == 0) return "-";
  return fmt::format(fmt::runtime(format),
                     factor * static_cast<double>(part) / static_cast<double>(whole));
}

template <class Count>
std::string percent(Count part, Count whole) {
  return ratio(part, whole, "{:.1f} %", 100);
}

class Writer {
 public:
  /// `plots`: the folder of the drawn plots; empty without any.
  Writer(const StudyPage& page, std::filesystem::path plots)
      : page_(page),
        study_(page.study),
        plots_(std::move(plots)),
        html_(page.scene + ": what its frames cost") {}

  std::string text(const std::string& problem) {
    opening(problem);
    false_positives();
    example();
    savings();
    loads();
    sizes();
    html_.heading("How this page was made");
    html_.paragraph(page_.made_with);
    return html_.text();
  }

 private:
  const ModeStudy& mode(CullMode which) const { return study_.modes[kUsualSize][index_of(which)]; }

  void plot(const std::string& name, const std::string& caption, bool half = false) {
    if (!plots_.empty()) html_.drawing(plots_ / (name + ".svg"), caption, half);
  }

  /// A row per mode: its name and `cells(mode)`.
  template <class Cells>
  void mode_table(Row head, const Cells& cells) {
    head.insert(head.begin(), "mode");
    std::vector<Row> rows = {std::move(head)};
    for (CullMode which = 1; which <= kCullerCount; ++which) {
      rows.push_back(cells(which));
      rows.back().insert(rows.back().begin(), mode_name(which));
    }
    html_.table(rows);
  }

  void opening(const std::string& problem) {
    html_.paragraph(fmt::format(
        "The scene has {} Gaussians: soft ellipsoids whose projections are blended into an image. "
        "A renderer divides the image into tiles of 16 x 16 pixels and lists for each tile the "
        "Gaussians that may touch it. One entry of a list is a pair. Every pair has to be created, "
        "sorted and blended, so the number of pairs determines the cost of a frame. The culling "
        "modes below differ in how tightly they bound the tiles of a Gaussian. This page shows {}.",
        grouped(study_.gaussians), page_.views));
    if (study_.huge > 0)
      html_.paragraph(huge_text(study_.huge) +
                      ". They are usually remains of a training that failed; the option "
                      "--skip-huge leaves them out.");
    if (!problem.empty()) html_.paragraph("This page has tables only, no plots: " + problem + ".");
    mode_table({"what it lists", "pairs", "3dgs = 1", "per visible Gaussian", "false positives",
                "ms per frame", "3dgs = 1"},
               [&](CullMode which) {
                 const ModeStudy& row = mode(which);
                 const double ms = study_.frame_ms[index_of(which)];
                 return Row{row_of(which).summary,
                            grouped(row.pairs),
                            ratio(row.pairs, mode(k3dgs).pairs),
                            ratio(row.pairs, study_.visible),
                            percent(row.uses.false_positives(), row.pairs),
                            fmt::format("{:.2f}", ms),
                            ratio(ms, study_.frame_ms[index_of(k3dgs)])};
               });
    html_.paragraph(fmt::format(
        "Times are means over the views of the median of {} frames of the CPU backend, with the "
        "modes in turns. The command 'bench' measures more carefully, and on a GPU.",
        kStudyFrames));
    for (const CaptionedImage& picture : page_.pictures)
      html_.picture(picture.image, picture.caption, true);
  }

  void false_positives() {
    html_.heading("Pairs that no pixel uses");
    html_.paragraph(
        "A pair is used if at least one pixel of the tile blends the Gaussian: the Gaussian's "
        "alpha "
        "reaches 1/255 there, and the pixel has not stopped before it. A pixel stops when the "
        "Gaussians in front let less than one part in ten thousand of the light through. All other "
        "pairs are false positives, of two kinds. An empty pair reaches 1/255 at no pixel of the "
        "tile; a tighter bound avoids it. A hidden pair reaches 1/255 only at pixels that have "
        "stopped before it.");
    const PairUses& exact = mode(kExact).uses;
    html_.paragraph(fmt::format(
        "Mode exact lists the fewest pairs of all lossless modes, and still {} of its pairs are "
        "false positives: {} are hidden, which no bound can detect before blending, and {} are "
        "empty. Empty ones remain because the bound has a safety margin of 0.05 %, and because "
        "some ellipses pass between pixel centres.",
        percent(exact.false_positives(), exact.pairs()), grouped(exact.hidden),
        grouped(exact.empty)));
    mode_table({"pairs", "used", "hidden", "empty", "false positives"}, [&](CullMode which) {
      const PairUses& uses = mode(which).uses;
      return Row{grouped(uses.pairs()), grouped(uses.used), grouped(uses.hidden),
                 grouped(uses.empty), percent(uses.false_positives(), uses.pairs())};
    });
    plot("uses", "All lossless modes use the same pairs. They differ in their false positives.");
  }

  void example() {
    if (page_.example.empty()) return;
    html_.heading("One Gaussian as an example");
    const SceneStudy::Example& example = study_.example;
    const auto pairs = [&](CullMode which) { return grouped(example.pairs[index_of(which)]); };
    html_.paragraph(fmt::format(
        "Gaussian {} has {} pairs in mode {}, {} in {}, {} in {} and {} in {}. Of all Gaussians "
        "that are completely inside the image, it is the one on which {} saves most compared with "
        "{}.",
        grouped(example.gaussian), pairs(k3dgs), mode_name(k3dgs), pairs(kAdr), mode_name(kAdr),
        pairs(kQuad), mode_name(kQuad), pairs(kExact), mode_name(kExact), mode_name(kQuad),
        mode_name(kAdr)));
    for (const CaptionedImage& picture : page_.example)
      html_.picture(picture.image, picture.caption);
  }

  void savings() {
    html_.heading("Which Gaussians the savings come from");
    html_.paragraph(fmt::format(
        "{} Gaussians are visible in mode 3dgs, summed over the views. The plots group them by "
        "four properties and show how many there are, and how many pairs each mode saves on them "
        "compared with 3dgs. A bar below zero means that the mode lists more pairs than 3dgs. That "
        "happens for Gaussians of high opacity, which are visible beyond three standard "
        "deviations.",
        grouped(study_.visible)));
    for (std::size_t q = 0; q < study_.binned.size(); ++q) {
      const GaussianQuantity& quantity = quantities()[q];
      std::string title = quantity.name;
      title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
      html_.paragraph(fmt::format("{}. {} {}", title, quantity.means, most_saving(q)));
      plot(fmt::format("count_{}", quantity.key), "The number of Gaussians.", true);
      plot(fmt::format("saved_{}", quantity.key), "The pairs that each mode saves.", true);
      if (plots_.empty()) bins_table(q);
    }
  }

  std::string most_saving(std::size_t q) const {
    const auto &square = study_.binned[q].pairs[index_of(k3dgs)],
               &quad = study_.binned[q].pairs[index_of(kQuad)];
    std::array<std::int64_t, kBins> saved{};
    std::int64_t all = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      saved[bin] = static_cast<std::int64_t>(square[bin]) - static_cast<std::int64_t>(quad[bin]);
      all += saved[bin];
    }
    const auto most = std::ranges::max_element(saved);
    if (all <= 0 || *most <= 0) return "";
    return fmt::format("Quadbox saves most in the range {}: {} of all pairs that it saves.",
                       bin_label(quantities()[q], static_cast<std::size_t>(most - saved.begin())),
                       percent(*most, all));
  }

  void bins_table(std::size_t q) {
    std::vector<Row> rows = {{quantities()[q].name, "Gaussians"}};
    for (CullMode which = 1; which <= kCullerCount; ++which) rows[0].push_back(mode_name(which));
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      Row& row = rows.emplace_back();
      row = {bin_label(quantities()[q], bin), grouped(study_.binned[q].gaussians[bin])};
      for (const auto& pairs : study_.binned[q].pairs) row.push_back(grouped(pairs[bin]));
    }
    html_.table(rows);
  }

  void loads() {
    html_.heading("How evenly the pairs are distributed over the tiles");
    html_.paragraph(
        "A tile with a long list takes long to blend, and a GPU that blends many tiles in parallel "
        "has to wait for the last one. The closer the longest list is to the mean, the better.");
    mode_table({"mean", "median", "99 % of tiles", "longest", "longest over mean"},
               [&](CullMode which) {
                 const std::vector<std::uint32_t>& loads = mode(which).loads;
                 if (loads.empty()) return Row(5, "-");
                 const double mean =
                     static_cast<double>(mode(which).pairs) / static_cast<double>(loads.size());
                 return Row{fmt::format("{:.1f}", mean), grouped(loads[loads.size() / 2]),
                            grouped(loads[(loads.size() - 1) * 99 / 100]), grouped(loads.back()),
                            ratio<double>(loads.back(), mean, "{:.1f}")};
               });
    plot("loads", "The tiles, sorted by the lengths of their lists.");
  }

  void sizes() {
    html_.heading("Other tile sizes");
    html_.paragraph(
        "Smaller tiles follow an ellipse more closely, so the modes differ more; larger tiles hide "
        "the difference. But small tiles also need more pairs in total.");
    Row head;
    for (const int size : kTileSizes) {
      head.push_back(fmt::format("{0} x {0}: pairs", size));
      head.insert(head.end(), {"3dgs = 1", "false positives"});
    }
    mode_table(std::move(head), [&](CullMode which) {
      Row row;
      for (const auto& size : study_.modes) {
        const ModeStudy& cell = size[index_of(which)];
        row.insert(row.end(), {grouped(cell.pairs), ratio(cell.pairs, size[index_of(k3dgs)].pairs),
                               percent(cell.uses.false_positives(), cell.pairs)});
      }
      return row;
    });
    plot("sizes", "The pairs of each mode, relative to those of 3dgs at the same tile size.");
  }

  const StudyPage& page_;
  const SceneStudy& study_;
  std::filesystem::path plots_;
  HtmlPage html_;
};

}  // namespace

std::string bin_label(const GaussianQuantity& quantity, std::size_t bin) {
  const double low = quantity.edges[bin], high = quantity.edges[bin + 1];
  if (high >= 1e9) return fmt::format("{:.3g}+", low);
  return bin == 0 ? fmt::format("<{:.3g}", high) : fmt::format("{:.3g}-{:.3g}", low, high);
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

std::string format_study_page(const StudyPage& page, std::string& problem) {
  const WorkFolder folder;
  const std::string drawn = draw_plots(folder.path(), study_plots(page.study, page.plots));
  // Leaves out the instructions for drawing the plots, because the scripts are deleted with the
  // folder.
  problem = drawn.substr(0, drawn.find(';'));
  return Writer(page, problem.empty() ? folder.path() : "").text(problem);
}

}  // namespace qs
