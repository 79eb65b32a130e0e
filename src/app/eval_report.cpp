// SPDX-License-Identifier: MIT
#include "app/eval_report.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/stats_file.h"
#include "app/text.h"
#include "io/cameras.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

const char* mode_name(CullMode mode) { return kCullers[static_cast<std::size_t>(mode)].name; }

ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

// As CSV wants a text: in quotes when it holds a comma, a quote or a line's end.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + '"';
}

}  // namespace

Quality mean_quality(const EvalReport& report, CullMode mode) {
  Quality mean;
  mean.mode = mode;
  int count = 0;
  for (const Quality& row : report.rows) {
    if (row.mode != mode) continue;
    mean.psnr += row.psnr;
    mean.ssim += row.ssim;
    ++count;
  }
  mean.psnr /= count;
  mean.ssim /= count;
  return mean;
}

std::string format_eval_table(const EvalReport& report, const std::vector<CullMode>& modes) {
  const std::string mean_title = fmt::format("mean of {}", report.rows.size() / modes.size());
  std::size_t width = mean_title.size();
  for (const Quality& row : report.rows) width = std::max(width, row.camera.name.size());
  std::string text =
      fmt::format("{:{}}  {:13}  {:>7}  {:>6}\n", "view", width, "mode", "PSNR dB", "SSIM");
  const auto line = [&](const std::string& name, const Quality& row) {
    text += fmt::format("{:{}}  {:13}  {:>7}  {:6.4f}\n", name, width, mode_name(row.mode),
                        decibels(row.psnr), row.ssim);
  };
  for (const Quality& row : report.rows) line(row.camera.name, row);
  for (const CullMode mode : modes) line(mean_title, mean_quality(report, mode));
  return text;
}

std::string format_eval_csv(const EvalReport& report, const Session& session) {
  std::string text =
      "scene,camera,mode,backend,gaussians,width,height,compared_width,"
      "compared_height,psnr,ssim\n";
  for (const Quality& row : report.rows) {
    text +=
        fmt::format("{},{},{},{},{},{},{},{},{},{:.6f},{:.8f}\n",
                    csv_field(session.scene.path.filename().string()), csv_field(row.camera.name),
                    mode_name(row.mode), kBackendNames[static_cast<int>(session.backend)],
                    session.scene.cloud.size(), row.camera.width, row.camera.height, row.width,
                    row.height, row.psnr, row.ssim);
  }
  return text;
}

std::string format_eval_json(const EvalReport& report, const Session& session,
                             const std::vector<CullMode>& modes) {
  ordered_json means = ordered_json::array(), views = ordered_json::array();
  for (const CullMode mode : modes) {
    const Quality mean = mean_quality(report, mode);
    means.push_back({{"mode", mode_name(mode)},
                     {"views", report.rows.size() / modes.size()},
                     {"psnr", finite_or_null(mean.psnr)},
                     {"ssim", mean.ssim}});
  }
  for (const Quality& row : report.rows) {
    views.push_back({{"name", row.camera.name},
                     {"photograph", row.photograph.string()},
                     {"mode", mode_name(row.mode)},
                     {"compared_width", row.width},
                     {"compared_height", row.height},
                     {"psnr", finite_or_null(row.psnr)},
                     {"ssim", row.ssim},
                     {"camera", ordered_json::parse(format_camera(row.camera))}});
  }
  const ordered_json json = {
      {"environment", environment_json(session)},
      {"scene", scene_json(session.scene)},
      {"method",
       {{"cameras", report.cameras.string()},
        {"images", report.images.string()},
        {"holdout", report.holdout},
        {"images_scale", report.images_scale},
        {"views_without_photograph", report.skipped},
        {"psnr", "-10 log10(mean squared error of all RGB values), peak 1, mean over views"},
        {"ssim", "Gaussian window 11 x 11, sigma 1.5, zeros outside, K 0.01 and 0.03, per channel"},
        {"sizes", "rendered at the camera's size, clamped, area-averaged to the photograph's"}}},
      {"means", means},
      {"views", views}};
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace qs
