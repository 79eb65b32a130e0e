// SPDX-License-Identifier: MIT
#include "learn/run/settings.h"

#include <vector>

#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/json_value.h"

namespace qs::train {

using nlohmann::ordered_json;

ordered_json settings_json(const TrainSettings& s) {
  return {{"iterations", s.iterations},
          {"strategy", s.strategy},
          {"cull", mode_name(s.mode)},
          {"seed", s.seed},
          {"sh_degree", s.sh_degree},
          {"antialiased", s.antialiased},
          {"background", {s.background.x, s.background.y, s.background.z}},
          {"random_background", s.random_background},
          {"max_gaussians", s.max_gaussians},
          {"gaussians", s.many_gaussians ? "many" : "few"},
          {"absolute_gradients", s.absolute_gradients},
          {"sum_gradients", s.sum_gradients},
          {"final_prunes", s.final_prunes},
          {"resolution_schedule", s.reduced_photographs ? "dash" : "full"},
          {"color_field", s.color_field},
          {"dash_variant", s.dash_of_paper ? "2025-06" : "current"},
          {"random_points", s.random_points},
          {"count_views", kCountViewsNames[static_cast<int>(s.count_views)]},
          {"step_before_densify", s.step_before_densify},
          {"opacity_rate", s.opacity_rate}};
}

TrainSettings settings_of(const ordered_json& json) {
  TrainSettings s;
  json_value(json.at("iterations"), s.iterations);
  json_value(json.at("strategy"), s.strategy);
  s.mode = find_culler(json.at("cull").get<std::string>());
  json_value(json.at("seed"), s.seed);
  json_value(json.at("sh_degree"), s.sh_degree);
  json_value(json.at("antialiased"), s.antialiased);
  for (int c = 0; c < 3; ++c)
    json_value(json.at("background").at(static_cast<std::size_t>(c)), s.background[c]);
  json_value(json.at("random_background"), s.random_background);
  json_value(json.at("max_gaussians"), s.max_gaussians);
  s.many_gaussians = json.at("gaussians").get<std::string>() == "many";
  json_value(json.at("absolute_gradients"), s.absolute_gradients);
  json_value(json.at("sum_gradients"), s.sum_gradients);
  json_value(json.at("final_prunes"), s.final_prunes);
  s.reduced_photographs = json.at("resolution_schedule").get<std::string>() == "dash";
  json_value(json.at("color_field"), s.color_field);
  s.dash_of_paper = json.at("dash_variant").get<std::string>() == "2025-06";
  json_value(json.at("random_points"), s.random_points);
  s.count_views =
      json.at("count_views") == kCountViewsNames[1] ? CountViews::mode : CountViews::exact;
  json_value(json.at("step_before_densify"), s.step_before_densify);
  json_value(json.at("opacity_rate"), s.opacity_rate);
  return s;
}

std::string differences_of(const TrainSettings& a, const TrainSettings& b) {
  const ordered_json left = settings_json(a), right = settings_json(b);
  std::vector<std::string> names;
  for (const auto& [name, value] : left.items()) {
    const bool may_differ = (name == "iterations" && !a.depends_on_end() && !b.depends_on_end()) ||
                            name == "max_gaussians";
    if (!may_differ && value != right.at(name)) names.push_back(name);
  }
  return joined(names, ", ");
}

}  // namespace qs::train
