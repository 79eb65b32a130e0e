// SPDX-License-Identifier: MIT
#include "app/report/merge.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <tuple>
#include <vector>

#include "app/report/bench_report.h"
#include "app/report/environment.h"
#include "base/fail.h"
#include "base/list_of.h"
#include "base/text.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"

namespace qs {
namespace {

using nlohmann::ordered_json;

std::string environment_word(const ordered_json& report, const char* key) {
  return report.at("environment").value(key, "");
}

std::string hash_and_edits(const ordered_json& scene) {
  const std::string hash = scene.value("hash", "");
  return scene.contains("altered") ? hash + " " + scene["altered"].value("text", "") : hash;
}

// Scenes are equal if their hashes and alterations are; their paths may differ from machine to
// machine.
std::string scene_words(const ordered_json& report) {
  const ordered_json scenes = report.value("scenes", ordered_json::array());
  std::vector<std::string> words;
  for (const ordered_json& scene : scenes)
    words.push_back(scene.value("name", "") + " " + hash_and_edits(scene));
  if (report.contains("scene")) words.push_back(hash_and_edits(report["scene"]));
  return joined(words, ", ");
}

// A fact that must be equal in all parts. `key`: the entry of the environment in which a mixed
// report lists all values.
struct Fact {
  const char* what;
  std::string (*of)(const ordered_json& report);
  const char* key;
};
constexpr Fact kFacts[] = {
    {"device", [](const ordered_json& r) { return measured_on(r.at("environment")); }, "gpu"},
    {"backend", [](const ordered_json& r) { return environment_word(r, "backend"); }, "backend"},
    {"pipeline", [](const ordered_json& r) { return environment_word(r, "pipeline"); }, "pipeline"},
    {"baseline", [](const ordered_json& r) { return environment_word(r, "baseline"); }, nullptr},
    {"commit", [](const ordered_json& r) { return environment_word(r, "commit"); }, "commit"},
    {"scenes", scene_words, nullptr},
    {"number of views", [](const ordered_json& r) { return json_line(r.at("view_count")); },
     nullptr},
    {"method", [](const ordered_json& r) { return json_line(r.value("method", ordered_json())); },
     nullptr},
};

std::uint64_t view_of(const ordered_json& row) { return json_value<std::uint64_t>(row.at("view")); }

void require_equal(std::span<const ReportPart> parts, const Fact& fact, bool mixed,
                   ordered_json& environment) {
  std::vector<std::string> words;
  for (const ReportPart& part : parts) {
    add_new(words, fact.of(part.report));
    if (words.size() > 1 && !mixed)
      fail("merge: {} and {} differ in their {}, {} and {}: --mixed joins them all the same",
           parts.front().from, part.from, fact.what, words[0], words[1]);
  }
  if (words.size() > 1 && fact.key) environment[fact.key] = joined(words, " + ");
}

// Removes --shard from the flags, because the merged report covers all views.
void forget_shard(ordered_json& environment) {
  if (!environment.contains("flags")) return;
  ordered_json flags = ordered_json::array();
  for (auto word = environment["flags"].begin(); word != environment["flags"].end(); ++word) {
    const auto text = word->get<std::string>();
    if (text == "--shard" && std::next(word) != environment["flags"].end()) ++word;
    if (!text.starts_with("--shard")) flags.push_back(text);
  }
  environment["flags"] = flags;
}

}  // namespace

ReportPart read_report_part(const std::filesystem::path& file, const char* rows) try {
  ordered_json report = parse_own_json(read_text_file(file, kMaxReportBytes));
  for (const ordered_json& row : report.at(rows)) {
    view_of(row);
    row.at("mode").get<std::string>();
  }
  for (const Fact& fact : kFacts) fact.of(report);
  return {file.string(), std::move(report)};
} catch (const nlohmann::json::exception& error) {
  fail("{}: is not a report that can be merged: {}", file.string(), error.what());
}

ordered_json merge_reports(std::span<const ReportPart> parts, const char* rows, bool mixed) {
  ordered_json merged = parts.front().report;
  for (const Fact& fact : kFacts) require_equal(parts, fact, mixed, merged["environment"]);
  forget_shard(merged["environment"]);
  const auto environment_of = [](const ReportPart& part) { return part.report.at("environment"); };
  merge_environments(list_of<ordered_json>(parts, environment_of), merged["environment"]);
  std::vector<ordered_json> all;
  for (const ReportPart& part : parts) {
    const ordered_json& list = part.report.at(rows);
    all.insert(all.end(), list.begin(), list.end());
  }
  std::ranges::stable_sort(all, {}, view_of);
  std::set<std::tuple<std::uint64_t, std::string, std::string>> seen;
  for (const ordered_json& row : all) {
    const std::uint64_t view = view_of(row);
    const auto mode = row["mode"].get<std::string>();
    if (!seen.emplace(view, mode, row.value("pipeline", "")).second)
      fail("merge: view {}, mode {}, is in two of the parts", view, mode);
  }
  merged[rows] = all;
  return merged;
}

std::string missing_views(const ordered_json& report, const char* rows) {
  constexpr std::uint64_t kNamed = 8;
  std::set<std::uint64_t> measured;
  for (const ordered_json& row : report.at(rows)) measured.insert(view_of(row));
  const auto count = json_value<std::uint64_t>(report.at("view_count"));
  if (measured.size() >= count) return "";
  const std::uint64_t missing = count - measured.size();
  std::vector<std::string> names;
  for (std::uint64_t view = 0; names.size() < std::min(missing, kNamed); ++view)
    if (measured.count(view) == 0) names.push_back(fmt::format("{}", view));
  return fmt::format("{} of {} views are missing: {}{}", missing, count, joined(names, ", "),
                     missing > kNamed ? ", .." : "");
}

}  // namespace qs
