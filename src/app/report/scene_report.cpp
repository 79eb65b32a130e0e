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
#include "raster/scene/activated_cloud.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

// Four digits, or as many more as tell the two ends apart.
int digits_for(double low, double high) {
  const double size = high - low, most = std::max(std::abs(low), std::abs(high));
  if (!(size > 0 && std::isfinite(most))) return 4;
  return std::clamp(2 + static_cast<int>(std::ceil(std::log10(most / size))), 4, 17);
}

std::string box_text(const SceneBox& box, const glm::dvec3& origin) {
  const glm::dvec3 low = origin + glm::dvec3(box.low), high = origin + glm::dvec3(box.high);
  const auto text = [&](const glm::dvec3& v) {
    std::string words;
    for (int axis = 0; axis < 3; ++axis)
      words += fmt::format("{}{:.{}g}", axis == 0 ? "" : ", ", v[axis],
                           digits_for(low[axis], high[axis]));
    return words;
  };
  return fmt::format("({}) to ({})", text(low), text(high));
}

nlohmann::ordered_json box_json(const SceneBox& box, const glm::dvec3& origin) {
  if (origin == glm::dvec3(0)) return {{"low", json_of(box.low)}, {"high", json_of(box.high)}};
  const glm::dvec3 low = origin + glm::dvec3(box.low), high = origin + glm::dvec3(box.high);
  return {{"low", {low.x, low.y, low.z}}, {"high", {high.x, high.y, high.z}}};
}

}  // namespace

SceneReport make_report(const GaussianCloud& cloud) {
  SceneReport report{scene_box(cloud), core_box(cloud), {}, {}, count_huge(cloud)};
  if (cloud.empty()) return report;
  const auto [faint, dense] = std::ranges::minmax_element(cloud.opacity_logits);
  report.opacity = {opacity_of_logit(*faint), opacity_of_logit(*dense)};
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
  if (scene.levels)
    line("levels",
         fmt::format("{}, in a tree of {} nodes: {} leaves were read, {} merged Gaussians "
                     "were left out{}",
                     scene.levels->levels, grouped(scene.levels->nodes),
                     grouped(scene.levels->leaves), grouped(scene.levels->merged),
                     scene.levels->has_originals ? "; with original values" : ""));
  line("SH degree", fmt::format("{}", scene.cloud.sh_degree));
  line("axes", scene.axes);
  line("antialiased", scene.cloud.antialiased ? "yes" : "no");
  if (!scene.vertical_axis.empty()) line("vertical axis", scene.vertical_axis);
  const glm::dvec3& origin = scene.cloud.origin;
  if (origin != glm::dvec3(0)) line("counts from", format_origin(origin));
  line("extents", box_text(report.all, origin));
  line("extents 5-95 %", box_text(report.core, origin));
  line("opacities", fmt::format("{:.4g} to {:.4g}", report.opacity.low, report.opacity.high));
  line("scales", fmt::format("{:.4g} to {:.4g}", report.scale.low, report.scale.high));
  if (scene.network)
    line("SH fit", fmt::format("differs by {:.2g} rms, in 99 % of the Gaussians by at most {:.2g}",
                               scene.network->rms, scene.network->rms_of_99));
  if (report.huge > 0) line("too large", huge_text(report.huge));
  if (!report.cameras.empty()) line("cameras", report.cameras);
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
      {"extents", box_json(report.all, scene.cloud.origin)},
      {"extents_5_95", box_json(report.core, scene.cloud.origin)},
      {"larger_than_the_scene", report.huge},
      {"opacity", {{"low", report.opacity.low}, {"high", report.opacity.high}}},
      {"scale", {{"low", report.scale.low}, {"high", report.scale.high}}},
      {"cameras", report.cameras},
      {"warnings", scene.warnings}};
  if (const glm::dvec3& origin = scene.cloud.origin; origin != glm::dvec3(0))
    json["counts_from"] = {origin.x, origin.y, origin.z};
  if (scene.levels)
    json["tree"] = {{"levels", scene.levels->levels},
                    {"nodes", scene.levels->nodes},
                    {"leaves", scene.levels->leaves},
                    {"merged", scene.levels->merged},
                    {"original", scene.levels->has_originals}};
  for (const FilePart& part : scene.parts)
    json["parts"].push_back(
        {{"name", part.name}, {"bytes", part.bytes}, {"content", part.content}});
  if (scene.network)
    json["sh_fit"] = {{"rms", scene.network->rms}, {"rms_of_99_percent", scene.network->rms_of_99}};
  return json;
}

}  // namespace qs
