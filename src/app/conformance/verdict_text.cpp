// SPDX-License-Identifier: MIT
#include "app/conformance/verdict_text.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/json_of.h"
#include "base/text.h"
#include "io/bytes/json_text.h"

namespace qs {
namespace {

using Json = nlohmann::ordered_json;

Json names_json(const std::vector<MistakeSet>& causes) {
  Json sets = Json::array();
  for (const MistakeSet& cause : causes) {
    Json names = Json::array();
    for (const std::size_t mistake : cause) names.push_back(mistakes()[mistake].name);
    sets.push_back(names);
  }
  return sets;
}

std::string alternatives(const std::vector<MistakeSet>& causes) {
  std::string text;
  for (const MistakeSet& cause : causes) text += (text.empty() ? "" : " or ") + names_of(cause);
  return text;
}

}  // namespace

std::string causes_text(const SceneVerdict& verdict) {
  if (!verdict.causes.empty()) return alternatives(verdict.causes);
  std::string text = "no known mistake explains it";
  if (!verdict.closest.empty())
    text += fmt::format("; closest: {}, {} dB", names_of(verdict.closest),
                        decibels(verdict.closest_psnr));
  return text;
}

std::string cause_text(const KitVerdict& judgement) {
  const std::size_t failed = judgement.count(Result::failed);
  if (failed == 0) return "No scene fails.";
  if (judgement.causes.empty()) return "No known mistake explains the scenes that fail.";
  std::string text = fmt::format("Likely cause: {}.", alternatives(judgement.causes));
  for (const std::size_t mistake : judgement.causes.front())
    text +=
        fmt::format(" {}: the renderer {}.", mistakes()[mistake].name, mistakes()[mistake].what);
  text += fmt::format(" This explains {} of {} failed scenes.", judgement.explained, failed);
  return text;
}

std::string format_verdict(const KitVerdict& judgement) {
  std::string text;
  for (std::size_t i = 0; i < judgement.scenes.size(); ++i) {
    const SceneVerdict& verdict = judgement.scenes[i];
    text += fmt::format("{:20}{:9}", kit_scenes()[i].name,
                        kResultNames[static_cast<int>(verdict.result)]);
    if (!verdict.problem.empty()) {
      text += verdict.problem;
    } else if (verdict.result != Result::missing) {
      text += fmt::format("{:>6} dB, largest difference {}", decibels(verdict.fit.psnr),
                          verdict.fit.largest);
      if (verdict.result == Result::failed) text += ": " + causes_text(verdict);
    }
    while (text.back() == ' ') text.pop_back();
    text += "\n";
  }
  return text + fmt::format("{} scenes pass, {} fail, {} are missing\n{}\n",
                            judgement.count(Result::passed), judgement.count(Result::failed),
                            judgement.count(Result::missing), cause_text(judgement));
}

std::string verdict_json(const KitVerdict& judgement) {
  Json scenes = Json::array();
  for (std::size_t i = 0; i < judgement.scenes.size(); ++i) {
    const SceneVerdict& verdict = judgement.scenes[i];
    Json entry = {{"name", kit_scenes()[i].name},
                  {"result", kResultNames[static_cast<int>(verdict.result)]}};
    if (!verdict.problem.empty()) {
      entry["problem"] = verdict.problem;
    } else if (verdict.result != Result::missing) {
      entry["psnr"] = finite_or_null(verdict.fit.psnr);
      entry["largest_difference"] = verdict.fit.largest;
    }
    if (verdict.result == Result::failed) entry["causes"] = names_json(verdict.causes);
    if (!verdict.causes.empty()) entry["explained_psnr"] = finite_or_null(verdict.explained_psnr);
    if (!verdict.closest.empty()) {
      entry["closest"] = names_json({verdict.closest}).front();
      entry["closest_psnr"] = finite_or_null(verdict.closest_psnr);
    }
    scenes.push_back(entry);
  }
  return json_file_text(
      {{"tolerance", {{"largest_difference", kLargestDifference}, {"psnr", kLeastPsnr}}},
       {"passed", judgement.count(Result::passed)},
       {"failed", judgement.count(Result::failed)},
       {"missing", judgement.count(Result::missing)},
       {"causes", names_json(judgement.causes)},
       {"explained", judgement.explained},
       {"scenes", scenes}});
}

}  // namespace qs
