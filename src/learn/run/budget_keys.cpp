// SPDX-License-Identifier: MIT
#include "learn/run/budget_keys.h"

#include <array>
#include <cstdlib>
#include <map>
#include <sstream>

#include "base/fail.h"

namespace qs::train {
namespace {

BudgetKeys parsed_keys(const std::string& text) {
  BudgetKeys keys;
  std::string noise, penalty;
  const std::map<std::string, std::string*> words = {
      {"base", &keys.base},   {"score", &keys.score}, {"child", &keys.child},
      {"decay", &keys.decay}, {"clear", &keys.clear}, {"prune", &keys.prune}};
  const std::map<std::string, double*> numbers = {
      {"mean_end", &keys.mean_end}, {"fall", &keys.fall},       {"rest", &keys.rest},
      {"divisor", &keys.divisor},   {"recover", &keys.recover}, {"half", &keys.half},
      {"guard", &keys.guard},       {"sums", &keys.sums},       {"replace", &keys.replace},
      {"count", &keys.count},       {"release", &keys.release}, {"noise", &keys.noise},
      {"penalty", &keys.penalty}};
  keys.noise = keys.penalty = -1;
  const auto number_of = [](const std::string& item, const std::string& value) {
    char* end = nullptr;
    const double number = std::strtod(value.c_str(), &end);
    if (value.empty() || *end != '\0')
      fail(ErrorKind::usage, "QUADSPLAT_BUDGET: {}: '{}' is no number", item, value);
    return number;
  };
  std::istringstream items(text);
  for (std::string item; std::getline(items, item, ',');) {
    const std::size_t at = item.find('=');
    const std::string name = item.substr(0, at);
    const std::string value = at == std::string::npos ? "" : item.substr(at + 1);
    if (const auto word = words.find(name); word != words.end())
      *word->second = value;
    else if (const auto number = numbers.find(name); number != numbers.end())
      *number->second = number_of(item, value);
    else
      fail(ErrorKind::usage, "QUADSPLAT_BUDGET: {}: there is no such key", item);
  }
  const bool adc = keys.base != "mcmc";
  if (keys.noise < 0) keys.noise = adc ? 0 : 1;
  if (keys.penalty < 0) keys.penalty = adc ? 0 : 1;
  if (keys.score.empty()) keys.score = adc ? "gradient" : "opacity";
  if (keys.child.empty()) keys.child = adc ? "beside" : "relocate";
  if (keys.decay.empty()) keys.decay = adc ? "half" : "none";
  if (const std::size_t at = keys.decay.find(':'); at != std::string::npos) {
    keys.amount = number_of(keys.decay, keys.decay.substr(at + 1));
    keys.decay.resize(at);
  }
  if (keys.clear.empty()) keys.clear = adc && keys.decay == "half" ? "all" : "none";
  const auto require = [](const char* name, const std::string& value,
                          std::initializer_list<const char*> known) {
    for (const char* each : known)
      if (value == each) return;
    fail(ErrorKind::usage, "QUADSPLAT_BUDGET: {}={}: there is no such value", name, value);
  };
  require("base", keys.base, {"mcmc", "adc", "few"});
  require("score", keys.score, {"opacity", "gradient", "flagged", "share"});
  require("child", keys.child, {"relocate", "beside", "long"});
  require("decay", keys.decay, {"none", "half", "mild", "minus", "clamp", "reset"});
  require("clear", keys.clear, {"all", "opacity", "none"});
  require("prune", keys.prune, {"opacity", "unseen"});
  if (keys.count < 0)
    keys.count = keys.base == "few"                                 ? 10
                 : keys.prune == "unseen"                           ? 1e9
                 : keys.score == "flagged" || keys.score == "share" ? 10
                                                                    : 0;
  return keys;
}

std::string keys_text() {
  const char* text = std::getenv("QUADSPLAT_BUDGET");
  return text == nullptr ? "" : text;
}

}  // namespace

const BudgetKeys& budget_keys() {
  static std::string last;
  static BudgetKeys keys = parsed_keys("");
  if (const std::string text = keys_text(); text != last) {
    keys = parsed_keys(text);
    last = text;
  }
  return keys;
}

const Strategy& budget_with_keys(const Strategy& row) {
  static std::map<std::string, Strategy> rows;
  const BudgetKeys& keys = budget_keys();
  const auto [found, is_new] = rows.try_emplace(keys_text(), row);
  if (is_new) {
    Strategy& changed_row = found->second;
    if (keys.base == "few") changed_row.sh_steps = 30;
    if (keys.base != "mcmc") {
      changed_row.initial_opacity = 0.1;
      changed_row.initial_scale = 1;
    }
    changed_row.counted_views = static_cast<int>(keys.count);
    changed_row.has_guard = keys.guard != 0;
  }
  return found->second;
}

}  // namespace qs::train
