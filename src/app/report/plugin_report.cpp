// SPDX-License-Identifier: MIT
#include "app/report/plugin_report.h"

#include <algorithm>

#include <fmt/format.h>

namespace qs {
namespace {

using nlohmann::ordered_json;

constexpr const char* kKeys[] = {"plugins", "plugin_problems"};

}  // namespace

std::string plugin_line(const PluginFacts& facts) {
  const std::string how =
      facts.measures_itself
          ? fmt::format(
                "its times are measured by the plugin, and its calls on {} took {:.2f} "
                "times as long by the host's clock",
                facts.scene, facts.call_factor)
          : "its times are those of its calls by the host's clock";
  return fmt::format("`{}`: {}{}{}; scene and image in {} memory; {}", facts.name,
                     facts.description, facts.description.empty() ? "" : "; ", facts.file,
                     facts.on_device ? "CUDA" : "host", how);
}

void add_line(ordered_json& environment, const char* key, const std::string& line) {
  ordered_json& list = environment[key];
  if (list.is_null()) list = ordered_json::array();
  if (std::find(list.begin(), list.end(), line) == list.end()) list.push_back(line);
}

std::string plugin_markdown(const ordered_json& environment) {
  const auto lines = [&](const char* key) { return environment.value(key, ordered_json::array()); };
  std::string text;
  for (const ordered_json& line : lines("plugins"))
    text += fmt::format("- {}\n", line.get<std::string>());
  if (!text.empty()) text = fmt::format("\n{}.\n\n{}", kTimingScope, text);
  const ordered_json problems = lines("plugin_problems");
  if (!problems.empty()) text += "\n## Plugins that failed\n\n";
  for (const ordered_json& line : problems) text += fmt::format("- {}\n", line.get<std::string>());
  return text;
}

void merge_plugins(const std::vector<ordered_json>& parts, ordered_json& environment) {
  for (const char* key : kKeys) {
    for (const ordered_json& part : parts) {
      for (const ordered_json& line : part.value(key, ordered_json::array()))
        add_line(environment, key, line.get<std::string>());
    }
  }
}

}  // namespace qs
