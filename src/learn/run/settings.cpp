// SPDX-License-Identifier: MIT
#include "learn/run/settings.h"

#include <array>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/json_value.h"

namespace qs::train {

using nlohmann::ordered_json;

namespace {

// One function that names the members of a struct both writes them to a JSON object and reads them
// from it.
struct JsonFields {
  ordered_json* to;          ///< null: reads
  const ordered_json* from;  ///< null: writes

  template <class T>
  void operator()(const char* name, T& value) {
    if (to != nullptr) (*to)[name] = value;
    if (from != nullptr) json_value(from->at(name), value);
  }
  /// A member that is one of two words; the second one stands for true.
  void choice(const char* name, const char* no, const char* yes, bool& value) {
    std::string word = value ? yes : no;
    (*this)(name, word);
    value = word == yes;
  }
};

void visit(JsonFields fields, TrainSettings& s) {
  std::string mode = mode_name(s.mode);
  std::array background = {s.background.x, s.background.y, s.background.z};
  bool counts_by_mode = s.count_views == CountViews::mode;
  fields("iterations", s.iterations);
  fields("strategy", s.strategy);
  fields("cull", mode);
  fields("seed", s.seed);
  fields("sh_degree", s.sh_degree);
  fields("antialiased", s.antialiased);
  fields("background", background);
  fields("random_background", s.random_background);
  fields("max_gaussians", s.max_gaussians);
  fields.choice("gaussians", "few", "many", s.many_gaussians);
  fields("absolute_gradients", s.absolute_gradients);
  fields("sum_gradients", s.sum_gradients);
  fields("final_prunes", s.final_prunes);
  fields.choice("resolution_schedule", "full", "dash", s.reduced_photographs);
  fields("color_field", s.color_field);
  fields.choice("dash_variant", "current", "2025-06", s.dash_of_paper);
  fields("random_points", s.random_points);
  fields.choice("count_views", kCountViewsNames[0], kCountViewsNames[1], counts_by_mode);
  fields("step_before_densify", s.step_before_densify);
  fields("opacity_rate", s.opacity_rate);
  if (fields.from != nullptr ? fields.from->contains("seconds") : s.seconds > 0)
    fields("seconds", s.seconds);
  if (fields.from != nullptr ? fields.from->contains("guard") : s.guard) fields("guard", s.guard);
  if (fields.to != nullptr && !s.pace.empty()) (*fields.to)["pace"] = pace_json(s.pace);
  if (fields.from != nullptr && fields.from->contains("pace"))
    s.pace = pace_of(fields.from->at("pace"));
  // Older runs do not name it, and had the published one.
  if (fields.from != nullptr && !fields.from->contains("extent"))
    s.published_extent = true;
  else
    fields.choice("extent", "robust", "published", s.published_extent);
  s.mode = find_culler(mode);
  s.background = {background[0], background[1], background[2]};
  s.count_views = counts_by_mode ? CountViews::mode : CountViews::exact;
}

}  // namespace

ordered_json settings_json(TrainSettings settings) {
  ordered_json json;
  visit({&json, nullptr}, settings);
  return json;
}

TrainSettings settings_of(const ordered_json& json) {
  TrainSettings settings;
  visit({nullptr, &json}, settings);
  return settings;
}

ordered_json pace_json(const std::vector<Pace::Row>& rows) {
  ordered_json json = ordered_json::array();
  for (const Pace::Row& row : rows) json.push_back({row.from, row.iterations});
  return json;
}

std::vector<Pace::Row> pace_of(const ordered_json& json) {
  std::vector<Pace::Row> rows;
  for (const ordered_json& pair : json) {
    rows.push_back({json_value<int>(pair.at(0)), json_value<int>(pair.at(1))});
    const bool ascends =
        rows.size() == 1 ? rows[0].from == 0 : rows.back().from > rows[rows.size() - 2].from;
    if (!ascends || rows.back().iterations < 1) fail("pace: {}: is no pace", pair.dump());
  }
  if (rows.empty()) fail("pace: has no rows");
  return rows;
}

std::string differences_of(const TrainSettings& a, const TrainSettings& b) {
  const ordered_json left = settings_json(a), right = settings_json(b);
  std::vector<std::string> names;
  for (const auto& [name, value] : (left.size() > right.size() ? left : right).items()) {
    const bool may_differ = (name == "iterations" && !a.depends_on_end() && !b.depends_on_end()) ||
                            (name == "max_gaussians" && a.strategy != "paced");
    const bool both = left.contains(name) && right.contains(name);
    if (!may_differ && (!both || left.at(name) != right.at(name))) names.push_back(name);
  }
  return joined(names, ", ");
}

}  // namespace qs::train
