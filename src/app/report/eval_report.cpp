// SPDX-License-Identifier: MIT
#include "app/report/eval_report.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include <fmt/format.h>

#include "app/report/environment.h"
#include "base/fail.h"
#include "base/json_of.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/bytes/replace_file.h"
#include "io/camera/cameras.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

bool has_lpips(const EvalReport& report) {
  return !report.rows.empty() && report.rows.front().lpips.has_value();
}

bool has_lens(const EvalReport& report) {
  return std::ranges::any_of(report.rows, [](const auto& row) { return row.in_lens.has_value(); });
}

void add_lens(const std::optional<LensQuality>& in_lens, ordered_json& entry) {
  if (!in_lens) return;
  entry["lens_psnr"] = finite_or_null(in_lens->psnr);
  entry["lens_ssim"] = in_lens->ssim;
  entry["lens_shown"] = in_lens->shown;
}

double finite_or_infinity(const ordered_json& value) {
  return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

void add_lpips(const std::optional<LpipsValues>& lpips, ordered_json& entry) {
  if (!lpips) return;
  entry["lpips_paper"] = lpips->paper;
  entry["lpips"] = lpips->symmetric;
}

std::string altered_text(const ordered_json& scene) {
  return scene.contains("altered") ? scene["altered"].value("text", "") : "";
}

nlohmann::ordered_json quality_json(const PictureQuality& q) {
  return {{"view", q.view}, {"psnr", finite_or_null(q.psnr)}, {"ssim", q.ssim}, {"flip", q.flip}};
}

}  // namespace

std::string ssim_method(SsimBorder border) {
  return fmt::format(
      "Gaussian window 11 x 11, sigma 1.5, {}, K 0.01 and 0.03, per channel",
      border == SsimBorder::zeros ? "zeros outside" : "without the 5 pixels at the border");
}

std::vector<MeanQuality> mean_qualities(const std::vector<EvaluatedView>& rows) {
  std::vector<MeanQuality> means;
  for (const EvaluatedView& row : rows) {
    auto mean = std::ranges::find(means, row.mode, &MeanQuality::mode);
    if (mean == means.end()) mean = means.insert(means.end(), {row.mode, 0, 0, 0, LpipsValues{}});
    if (row.in_lens) {
      LensQuality& sum = mean->in_lens ? *mean->in_lens : mean->in_lens.emplace();
      sum.psnr += row.in_lens->psnr;
      sum.ssim += row.in_lens->ssim;
      sum.shown += row.in_lens->shown;
      mean->photographs += 1;
    }
    mean->views += 1;
    mean->psnr += row.psnr;
    mean->ssim += row.ssim;
    if (!row.lpips) mean->lpips.reset();
    if (!mean->lpips) continue;
    mean->lpips->paper += row.lpips->paper;
    mean->lpips->symmetric += row.lpips->symmetric;
  }
  for (MeanQuality& mean : means) {
    mean.psnr /= static_cast<double>(mean.views);
    mean.ssim /= static_cast<double>(mean.views);
    if (mean.in_lens)
      for (double* value : {&mean.in_lens->psnr, &mean.in_lens->ssim, &mean.in_lens->shown})
        *value /= static_cast<double>(mean.photographs);
    if (!mean.lpips) continue;
    mean.lpips->paper /= static_cast<double>(mean.views);
    mean.lpips->symmetric /= static_cast<double>(mean.views);
  }
  return means;
}

std::string format_eval_table(const EvalReport& report) {
  const std::vector<MeanQuality> means = mean_qualities(report.rows);
  const auto mean_title = [](const MeanQuality& mean) {
    return fmt::format("mean of {}", mean.views);
  };
  std::size_t width = 4;
  for (const MeanQuality& mean : means) width = std::max(width, mean_title(mean).size());
  for (const EvaluatedView& row : report.rows) width = std::max(width, row.camera.name.size());
  std::string text =
      fmt::format("{:{}}  {:13}  {:>7}  {:>6}{}{}\n", "view", width, "mode", "PSNR dB", "SSIM",
                  has_lpips(report) ? "  LPIPS (paper)   LPIPS" : "",
                  has_lens(report) ? "  in the lens: PSNR    SSIM  shown" : "");
  const auto line = [&](const std::string& name, const auto& row) {
    text += fmt::format("{:{}}  {:13}  {:>7}  {:6.4f}", name, width, mode_name(row.mode),
                        decibels(row.psnr), row.ssim);
    if (row.lpips)
      text += fmt::format("  {:13.4f}  {:6.4f}", row.lpips->paper, row.lpips->symmetric);
    if (row.in_lens)
      text += fmt::format("  {:>17}  {:6.4f}  {:3.0f} %", decibels(row.in_lens->psnr),
                          row.in_lens->ssim, 100 * row.in_lens->shown);
    text += '\n';
  };
  for (const EvaluatedView& row : report.rows) line(row.camera.name, row);
  for (const MeanQuality& mean : means) line(mean_title(mean), mean);
  const std::string altered = altered_text(report.scene);
  return altered.empty() ? text : text + "The scene is altered: " + altered + "\n";
}

std::string format_eval_csv(const EvalReport& report) {
  const std::filesystem::path scene = report.scene.at("file").get<std::string>();
  std::string text =
      "scene,camera,mode,backend,gaussians,width,height,compared_width,"
      "compared_height,psnr,ssim";
  text += has_lpips(report) ? ",lpips_paper,lpips" : "";
  const bool in_lens = has_lens(report);
  text += in_lens ? ",lens_psnr,lens_ssim,lens_shown" : "";
  const std::string altered = altered_text(report.scene);
  text += altered.empty() ? "\n" : ",altered\n";
  for (const EvaluatedView& row : report.rows) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{:.6f},{:.8f}",
                        csv_field(scene.filename().string()), csv_field(row.camera.name),
                        mode_name(row.mode), report.environment.at("backend").get<std::string>(),
                        report.scene.at("gaussians").get<std::uint64_t>(), row.camera.width,
                        row.camera.height, row.width, row.height, row.psnr, row.ssim);
    if (row.lpips) text += fmt::format(",{:.8f},{:.8f}", row.lpips->paper, row.lpips->symmetric);
    if (row.in_lens)
      text += fmt::format(",{:.6f},{:.8f},{:.6f}", row.in_lens->psnr, row.in_lens->ssim,
                          row.in_lens->shown);
    else if (in_lens)
      text += ",,,";
    text += altered.empty() ? "\n" : "," + csv_field(altered) + "\n";
  }
  return text;
}

std::string format_eval_json(const EvalReport& report) {
  ordered_json means = ordered_json::array(), views = ordered_json::array();
  for (const MeanQuality& mean : mean_qualities(report.rows)) {
    means.push_back({{"mode", mode_name(mean.mode)},
                     {"views", mean.views},
                     {"psnr", finite_or_null(mean.psnr)},
                     {"ssim", mean.ssim}});
    add_lpips(mean.lpips, means.back());
    if (mean.in_lens) means.back()["photographs"] = mean.photographs;
    add_lens(mean.in_lens, means.back());
  }
  for (const EvaluatedView& row : report.rows) {
    views.push_back({{"view", row.view},
                     {"name", row.camera.name},
                     {"photograph", row.photograph.string()},
                     {"mode", mode_name(row.mode)},
                     {"compared_width", row.width},
                     {"compared_height", row.height},
                     {"psnr", finite_or_null(row.psnr)},
                     {"ssim", row.ssim},
                     {"camera", camera_json(row.camera)}});
    add_lpips(row.lpips, views.back());
    add_lens(row.in_lens, views.back());
  }
  const ordered_json json = {
      {"environment", report.environment}, {"scene", report.scene}, {"method", report.method},
      {"view_count", report.view_count},   {"means", means},        {"views", views}};
  return json_file_text(json);
}

EvalReport parse_eval_report(const ordered_json& json) {
  EvalReport report{json.at("environment"),
                    json.at("scene"),
                    json.at("method"),
                    json_value<std::size_t>(json.at("view_count")),
                    {}};
  for (const ordered_json& view : json.at("views")) {
    EvaluatedView& row = report.rows.emplace_back();
    row.camera = camera_of(view.at("camera"), "eval.json");
    row.photograph = view.at("photograph").get<std::string>();
    json_value(view.at("compared_width"), row.width);
    json_value(view.at("compared_height"), row.height);
    row.mode = find_culler(view.at("mode").get<std::string>());
    if (row.mode < 0) fail("eval.json: there is no mode {}", json_line(view["mode"]));
    row.psnr = finite_or_infinity(view.at("psnr"));
    view.at("ssim").get_to(row.ssim);
    json_value(view.at("view"), row.view);
    if (view.contains("lpips"))
      row.lpips = {view.at("lpips_paper").get<double>(), view["lpips"].get<double>()};
    if (view.contains("lens_ssim"))
      row.in_lens = {finite_or_infinity(view.at("lens_psnr")), view["lens_ssim"].get<double>(),
                     view.at("lens_shown").get<double>()};
  }
  return report;
}

void write_eval_report(const EvalReport& report, const std::filesystem::path& folder) {
  replace_folder(folder, [&](const std::filesystem::path& hidden) {
    write_text(hidden / "eval.csv", format_eval_csv(report));
    write_text(hidden / "eval.json", format_eval_json(report));
  });
}

void sort_worst_first(std::vector<PictureQuality>& views) {
  std::ranges::sort(views, {}, [](const PictureQuality& q) { return std::tie(q.psnr, q.view); });
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
  for (const PictureQuality& q : judgement.views)
    text += fmt::format("{},{},{},{},{},{:.6f},{:.8f},{:.8f}\n", csv_field(judgement.truth),
                        csv_field(judgement.judged), csv_field(q.view), q.width, q.height, q.psnr,
                        q.ssim, q.flip);
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
