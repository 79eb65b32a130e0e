// SPDX-License-Identifier: MIT
#include "app/report/scene_report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/framing/scene_box.h"
#include "base/json_of.h"
#include "base/text.h"

namespace qs {
namespace {

double opacity_of(float logit) { return 1 / (1 + std::exp(-static_cast<double>(logit))); }

std::string vector_text(glm::vec3 v) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", v.x, v.y, v.z);
}

std::string box_text(const SceneBox& box) {
  return fmt::format("{} to {}", vector_text(box.low), vector_text(box.high));
}

nlohmann::ordered_json box_json(const SceneBox& box) {
  return {{"low", json_of(box.low)}, {"high", json_of(box.high)}};
}

}  // namespace

SceneReport make_report(const GaussianCloud& cloud) {
  SceneReport report{scene_box(cloud), core_box(cloud), {}, {}, count_huge(cloud)};
  if (cloud.empty()) return report;
  const auto [faint, dense] = std::ranges::minmax_element(cloud.opacity_logits);
  report.opacity = {opacity_of(*faint), opacity_of(*dense)};
  float smallest = std::numeric_limits<float>::infinity(), largest = -smallest;
  for (const glm::vec3& s : cloud.log_scales) {
    smallest = std::min({smallest, s.x, s.y, s.z});
    largest = std::max({largest, s.x, s.y, s.z});
  }
  report.scale = {std::exp(static_cast<double>(smallest)), std::exp(static_cast<double>(largest))};
  return report;
}

std::string report_text(const Scene& scene, const SceneReport& report) {
  std::string text = fmt::format("{}\n", scene.path.string());
  const auto line = [&text](const char* name, const std::string& value) {
    text += fmt::format("  {:15}{}\n", name, value);
  };
  line("format", scene.format);
  line("bytes", fmt::format("{} ({})", grouped(scene.file_bytes), bytes_text(scene.file_bytes)));
  std::uint64_t rest = scene.file_bytes;
  for (const FilePart& part : scene.parts) {
    line("", fmt::format("{:>13}  {}, {}", grouped(part.bytes), part.name, part.content));
    rest -= std::min(rest, part.bytes);
  }
  if (!scene.parts.empty()) line("", fmt::format("{:>13}  names and headers", grouped(rest)));
  line("Gaussians", grouped(scene.cloud.size()));
  line("SH degree", fmt::format("{}", scene.cloud.sh_degree));
  line("axes", scene.axes);
  line("antialiased", scene.cloud.antialiased ? "yes" : "no");
  if (!scene.vertical_axis.empty()) line("vertical axis", scene.vertical_axis);
  line("extents", box_text(report.all));
  line("extents 5-95 %", box_text(report.core));
  line("opacities", fmt::format("{:.4g} to {:.4g}", report.opacity.low, report.opacity.high));
  line("scales", fmt::format("{:.4g} to {:.4g}", report.scale.low, report.scale.high));
  if (scene.network)
    line("SH fit", fmt::format("differs by {:.2g} rms, in 99 % of the Gaussians by at most {:.2g}",
                               scene.network->rms, scene.network->rms_of_99));
  if (report.huge > 0) line("too large", huge_text(report.huge));
  for (const std::string& warning : scene.warnings) line("warning", warning);
  return text;
}

nlohmann::ordered_json report_json(const Scene& scene, const SceneReport& report) {
  nlohmann::ordered_json json = {
      {"file", scene.path.string()},
      {"format", scene.format},
      {"bytes", scene.file_bytes},
      {"gaussians", scene.cloud.size()},
      {"sh_degree", scene.cloud.sh_degree},
      {"axes", scene.axes},
      {"antialiased", scene.cloud.antialiased},
      {"vertical_axis", scene.vertical_axis},
      {"extents", box_json(report.all)},
      {"extents_5_95", box_json(report.core)},
      {"larger_than_the_scene", report.huge},
      {"opacity", {{"low", report.opacity.low}, {"high", report.opacity.high}}},
      {"scale", {{"low", report.scale.low}, {"high", report.scale.high}}},
      {"warnings", scene.warnings}};
  for (const FilePart& part : scene.parts)
    json["parts"].push_back(
        {{"name", part.name}, {"bytes", part.bytes}, {"content", part.content}});
  if (scene.network)
    json["sh_fit"] = {{"rms", scene.network->rms}, {"rms_of_99_percent", scene.network->rms_of_99}};
  return json;
}

}  // namespace qs
