// SPDX-License-Identifier: MIT
#include "app/report/judgement.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "base/json_of.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/text_file.h"

namespace qs {
namespace {

nlohmann::ordered_json quality_json(const PictureQuality& q) {
  return {{"view", q.view}, {"psnr", finite_or_null(q.psnr)}, {"ssim", q.ssim}, {"flip", q.flip}};
}

}  // namespace

void sort_worst_first(std::vector<PictureQuality>& views) {
  std::sort(views.begin(), views.end(), [](const PictureQuality& a, const PictureQuality& b) {
    return std::tie(a.psnr, a.view) < std::tie(b.psnr, b.view);
  });
}

std::string format_judgement_table(const Judgement& judgement) {
  const PictureQuality mean = mean_quality(judgement.views);
  std::size_t width = mean.view.size();
  for (const PictureQuality& view : judgement.views) width = std::max(width, view.view.size());
  std::string text =
      fmt::format("{:{}}  {:>7}  {:>6}  {:>6}\n", "view", width, "PSNR dB", "SSIM", "FLIP");
  const auto line = [&](const PictureQuality& q) {
    text += fmt::format("{:{}}  {:>7}  {:6.4f}  {:6.4f}\n", q.view, width, decibels(q.psnr), q.ssim,
                        q.flip);
  };
  for (const PictureQuality& view : judgement.views) line(view);
  line(mean);
  return text;
}

std::string format_judgement_csv(const Judgement& judgement) {
  std::string text = "truth,judged,view,width,height,psnr,ssim,flip\n";
  for (const PictureQuality& q : judgement.views) {
    text += fmt::format("{},{},{},{},{},{:.6f},{:.8f},{:.8f}\n", csv_field(judgement.truth),
                        csv_field(judgement.judged), csv_field(q.view), q.width, q.height, q.psnr,
                        q.ssim, q.flip);
  }
  return text;
}

std::string format_judgement_json(const Judgement& judgement) {
  auto views = nlohmann::ordered_json::array();
  for (const PictureQuality& q : judgement.views) {
    views.push_back(quality_json(q));
    views.back()["width"] = q.width;
    views.back()["height"] = q.height;
  }
  auto mean = quality_json(mean_quality(judgement.views));
  mean.erase("view");
  return json_file_text({{"truth", judgement.truth},
                         {"judged", judgement.judged},
                         {"environment", judgement.environment},
                         {"method", judgement.method},
                         {"mean", mean},
                         {"views", views}});
}

void write_judgement(const Judgement& judgement, const std::filesystem::path& folder) {
  write_text(folder / "judge.csv", format_judgement_csv(judgement));
  write_text(folder / "judge.json", format_judgement_json(judgement));
}

}  // namespace qs
