// SPDX-License-Identifier: MIT
#include "app/report/study_page.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

#include "app/report/html_page.h"
#include "app/report/study_plots.h"
#include "app/report/work_folder.h"
#include "app/session/text.h"

namespace qs {
namespace {

constexpr CullMode k3dgs = find_culler("3dgs"), kAdr = find_culler("adr"),
                   kExact = find_culler("exact"), kQuad = find_culler("quadbox");

std::string percent(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? "-"
                    : fmt::format("{:.1f} %",
                                  100 * static_cast<double>(part) / static_cast<double>(whole));
}

std::string ratio(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? "-"
                    : fmt::format("{:.2f}", static_cast<double>(part) / static_cast<double>(whole));
}

const char* name_of(std::size_t mode_index) { return kCullers[mode_index + 1].name; }

class Writer {
 public:
  Writer(const StudyPage& page, const std::filesystem::path& plots, bool has_plots)
      : page_(page),
        study_(page.study),
        plots_(plots),
        has_plots_(has_plots),
        html_(fmt::format("{}: where the work is", page.scene)) {}

  std::string text(const std::string& problem) {
    opening(problem);
    false_positives();
    telling();
    savings();
    loads();
    sizes();
    html_.heading("How this was made");
    html_.paragraph(page_.made_with);
    return html_.text();
  }

 private:
  const std::array<ModeStudy, kCullerCount>& modes() const { return study_.modes[kUsualSize]; }
  const ModeStudy& mode(CullMode which) const {
    return modes()[static_cast<std::size_t>(which - 1)];
  }

  void plot(const std::string& name, const std::string& caption, bool half = false) {
    if (has_plots_) html_.picture_file(plots_ / (name + ".png"), caption, half);
  }

  void opening(const std::string& problem) {
    html_.paragraph(fmt::format(
        "The scene is {} Gaussians, soft ellipsoids whose projections are blended into pictures. "
        "To "
        "draw one, a program cuts the picture into tiles of 16 x 16 pixels and lists for every "
        "tile the Gaussians that may touch it. Each entry of a list is a pair: it must be made, "
        "sorted and blended, so pairs are the work. The modes below differ in how tightly they "
        "find a Gaussian's tiles. This page shows {}.",
        grouped(study_.gaussians), page_.views));
    if (!problem.empty()) html_.paragraph("There are tables only, no plots: " + problem + ".");
    std::vector<std::vector<std::string>> rows = {
        {"mode", "what it lists", "pairs", "3dgs = 1", "per visible Gaussian", "false positives"}};
    for (std::size_t i = 0; i < modes().size(); ++i) {
      const ModeStudy& row = modes()[i];
      rows.push_back({name_of(i), kCullers[i + 1].summary, grouped(row.pairs),
                      ratio(row.pairs, mode(k3dgs).pairs), ratio(row.pairs, study_.visible),
                      percent(row.uses.false_positives(), row.pairs)});
    }
    html_.table(rows);
    for (const CaptionedImage& picture : page_.pictures)
      html_.picture(picture.image, picture.caption, true);
  }

  void false_positives() {
    html_.heading("Pairs that nobody needed");
    html_.paragraph(
        "A pair is used when at least one pixel of the tile blends the Gaussian: its alpha there "
        "reaches 1/255, and the pixel has not stopped in front of it. All others are false "
        "positives. They are empty when the Gaussian reaches no pixel centre of the tile, which a "
        "tighter shape avoids, and hidden when it does reach pixels, but all of them had stopped, "
        "because what lies in front lets less than one part in ten thousand through.");
    const PairUses& exact = mode(kExact).uses;
    html_.paragraph(fmt::format(
        "Mode exact lists the fewest pairs that lose nothing, and still {} of its pairs are false "
        "positives: {} are hidden, which no shape can know before the pixels are blended, and {} "
        "are "
        "empty, by its safety margin of 0.05 % on the ellipse's level and by ellipses that pass "
        "between pixel centres.",
        percent(exact.false_positives(), exact.pairs()), grouped(exact.hidden),
        grouped(exact.empty)));
    std::vector<std::vector<std::string>> rows = {
        {"mode", "pairs", "used", "hidden", "empty", "false positives"}};
    for (std::size_t i = 0; i < modes().size(); ++i) {
      const PairUses& uses = modes()[i].uses;
      rows.push_back({name_of(i), grouped(uses.pairs()), grouped(uses.used), grouped(uses.hidden),
                      grouped(uses.empty), percent(uses.false_positives(), uses.pairs())});
    }
    html_.table(rows);
    plot("uses", "Lossless modes use the same pairs; they differ in how many they list in vain.");
  }

  void telling() {
    if (page_.telling.empty()) return;
    html_.heading("One Gaussian that tells");
    const SceneStudy::Telling& telling = study_.telling;
    const auto pairs = [&](CullMode mode) {
      return grouped(telling.pairs[static_cast<std::size_t>(mode - 1)]);
    };
    html_.paragraph(fmt::format(
        "Gaussian {} has {} pairs in mode 3dgs, {} in adr, {} in quadbox and {} in exact. Of all "
        "that lie well inside the picture it is the one on which four boxes save most against one.",
        grouped(telling.gaussian), pairs(k3dgs), pairs(kAdr), pairs(kQuad), pairs(kExact)));
    for (const CaptionedImage& picture : page_.telling)
      html_.picture(picture.image, picture.caption);
  }

  void savings() {
    html_.heading("Which Gaussians bring the savings");
    html_.paragraph(
        fmt::format("{} Gaussians are visible in mode 3dgs, summed over the views. Below they are "
                    "sorted by four "
                    "properties: how many there are, and how many pairs each mode saves on them "
                    "against 3dgs. A "
                    "bar below zero means that the mode lists more than 3dgs does, as where "
                    "opacity is high and "
                    "the visible ellipse is larger than three standard deviations.",
                    grouped(study_.visible)));
    for (std::size_t q = 0; q < study_.binned.size(); ++q) {
      const Quantity& quantity = quantities()[q];
      std::string title = quantity.name;
      title[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(title[0])));
      html_.paragraph(fmt::format("{}. {} {}", title, quantity.means, most_saving(q)));
      plot(fmt::format("many_{}", quantity.key), "How many there are.", true);
      plot(fmt::format("saved_{}", quantity.key), "What each mode saves on them.", true);
      if (!has_plots_) bins_table(q);
    }
  }

  std::string most_saving(std::size_t q) const {
    const BinnedPairs& binned = study_.binned[q];
    std::int64_t best = 0, all = 0;
    std::size_t at = 0;
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      const auto saved = static_cast<std::int64_t>(binned.pairs[k3dgs - 1][bin]) -
                         static_cast<std::int64_t>(binned.pairs[kQuad - 1][bin]);
      all += saved;
      if (saved <= best) continue;
      best = saved;
      at = bin;
    }
    if (all <= 0 || best <= 0) return "";
    return fmt::format("Quadbox saves most where it is {}: {} of all that it saves.",
                       bin_label(quantities()[q], at),
                       percent(static_cast<std::uint64_t>(best), static_cast<std::uint64_t>(all)));
  }

  void bins_table(std::size_t q) {
    std::vector<std::vector<std::string>> rows = {{quantities()[q].name, "Gaussians"}};
    for (std::size_t mode = 0; mode < kCullerCount; ++mode) rows[0].emplace_back(name_of(mode));
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      std::vector<std::string>& row = rows.emplace_back();
      row = {bin_label(quantities()[q], bin), grouped(study_.binned[q].gaussians[bin])};
      for (std::size_t mode = 0; mode < kCullerCount; ++mode)
        row.push_back(grouped(study_.binned[q].pairs[mode][bin]));
    }
    html_.table(rows);
  }

  void loads() {
    html_.heading("How evenly the tiles are loaded");
    html_.paragraph(
        "A tile with a long list takes long, and a machine that draws many tiles at once waits for "
        "the last one. The closer the longest list is to the mean, the better.");
    std::vector<std::vector<std::string>> rows = {
        {"mode", "mean", "median", "99 % of tiles", "longest", "longest over mean"}};
    for (std::size_t i = 0; i < modes().size(); ++i) {
      const std::vector<std::uint32_t>& loads = modes()[i].loads;
      if (loads.empty()) continue;
      const double mean = static_cast<double>(modes()[i].pairs) / static_cast<double>(loads.size());
      rows.push_back({name_of(i), fmt::format("{:.1f}", mean), grouped(loads[loads.size() / 2]),
                      grouped(loads[(loads.size() - 1) * 99 / 100]), grouped(loads.back()),
                      mean > 0 ? fmt::format("{:.1f}", loads.back() / mean) : "-"});
    }
    html_.table(rows);
    plot("loads", "Tiles in the order of their lists' lengths.");
  }

  void sizes() {
    html_.heading("Other tile sizes");
    html_.paragraph(
        "Smaller tiles follow an ellipse more closely, so more of the difference between the "
        "shapes "
        "shows; larger tiles hide it. The price of small tiles is more pairs in all.");
    std::vector<std::vector<std::string>> rows = {{"mode"}};
    for (const int size : kTileSizes) {
      rows[0].push_back(fmt::format("{0} x {0}: pairs", size));
      rows[0].emplace_back("3dgs = 1");
      rows[0].emplace_back("false positives");
    }
    for (std::size_t mode = 0; mode < kCullerCount; ++mode) {
      std::vector<std::string>& row = rows.emplace_back();
      row.emplace_back(name_of(mode));
      for (const auto& size : study_.modes) {
        row.push_back(grouped(size[mode].pairs));
        row.push_back(ratio(size[mode].pairs, size[k3dgs - 1].pairs));
        row.push_back(percent(size[mode].uses.false_positives(), size[mode].pairs));
      }
    }
    html_.table(rows);
    plot("sizes", "Pairs of each mode as a share of those of 3dgs at the same tile size.");
  }

  const StudyPage& page_;
  const SceneStudy& study_;
  const std::filesystem::path& plots_;
  bool has_plots_;
  HtmlPage html_;
};

}  // namespace

std::string format_study_page(const StudyPage& page, std::string& problem) {
  const WorkFolder folder;
  const std::string drawn = draw_plots(folder.path(), study_plots(page.study, page.plots));
  // The folder of the scripts goes, so what to do with it is of no use to the reader.
  problem = drawn.substr(0, drawn.find(';'));
  return Writer(page, folder.path(), problem.empty()).text(problem);
}

}  // namespace qs
