// SPDX-License-Identifier: MIT
#include "options/option_table.h"

#include <algorithm>

#include <fmt/format.h>

#include "base/fail.h"
#include "options/suggestion.h"

namespace qs {

std::string Option::short_name() const { return name == "--output" ? "-o" : ""; }

std::string Option::shown() const {
  const std::string names = short_name().empty() ? name : short_name() + ", " + name;
  return placeholder.empty() ? names : names + " " + placeholder;
}

void OptionTable::positional(const std::string& name, std::filesystem::path& target,
                             const std::string& help, Samples samples) {
  const auto accept = [&target, name](const auto& values) {
    require_text(name, "a file or folder", values.back());
    target = values.back();
  };
  options_.push_back({name, "", help, 1, 1, accept, std::move(samples), true});
}

void OptionTable::positionals(const std::string& name, std::vector<std::filesystem::path>& target,
                              int least, const std::string& help, Samples samples) {
  const auto accept = [&target, name](const auto& values) {
    for (const std::string& given : values) require_text(name, "a file or folder", given);
    target.assign(values.begin(), values.end());
  };
  options_.push_back({name, "", help, least, -1, accept, std::move(samples), least > 0});
}

void OptionTable::flag(const std::string& name, bool& target, const std::string& help) {
  options_.push_back({name, "", help, 0, 0, [&target](const auto&) { target = true; }});
}

void OptionTable::value(const std::string& name, const std::string& placeholder,
                        const std::string& help, Samples samples,
                        std::function<void(const std::string& text)> accept) {
  options_.push_back({name, placeholder, help, 1, 1,
                      [accept = std::move(accept)](const auto& values) { accept(values.back()); },
                      std::move(samples)});
}

void OptionTable::values(const std::string& name, const std::string& placeholder,
                         const std::string& help, Samples samples,
                         std::function<void(const std::vector<std::string>& texts)> accept) {
  options_.push_back(
      {name, placeholder + " ...", help, 1, -1, std::move(accept), std::move(samples)});
}

void OptionTable::choice(const std::string& name, const std::vector<std::string>& names,
                         const std::function<void(int index)>& chosen, const std::string& help) {
  value(name, joined(names, "|"), help, names, [=](const std::string& given) {
    const auto found = std::ranges::find(names, given);
    if (found == names.end())
      fail(ErrorKind::usage, "{}: '{}' is none of {}{}", name, given, joined(names, ", "),
           suggestion(given, names));
    chosen(static_cast<int>(found - names.begin()));
  });
  offers(names);
}

void OptionTable::named(const std::string& name, const std::vector<std::string>& names,
                        std::string& target, const std::string& help) {
  const auto chosen = [&target, names](int i) { target = names[static_cast<std::size_t>(i)]; };
  choice(name, names, chosen, help);
}

void OptionTable::common(const std::function<void()>& declare) {
  const std::size_t before = options_.size();
  declare();
  for (std::size_t i = before; i < options_.size(); ++i) options_[i].common = true;
}

void OptionTable::overwrite(bool* target) {
  writes_ = true;
  options_.push_back({"--overwrite", "", "replaces existing files, but never an input", 0, 0,
                      [target, overwrites = overwrites_](const auto&) {
                        *overwrites = true;
                        if (target != nullptr) *target = true;
                      }});
}

void OptionTable::example(std::string command_line, std::string what) {
  examples_.push_back({std::move(command_line), std::move(what)});
}

void OptionTable::require_text(const std::string& name, const std::string& placeholder,
                               const std::string& given) {
  if (given.empty())
    fail(ErrorKind::usage, "{}: an empty text was given instead of {}", name, placeholder);
}

}  // namespace qs
