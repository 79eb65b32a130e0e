// SPDX-License-Identifier: MIT
//
// The only file that includes CLI11, which takes seconds to compile. CLI11 splits the command line.
// Values are converted and checked by Option::accept, because CLI::Range accepts nan and reads 010
// as 8.
#include "app/cli/options.h"

#include <algorithm>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "app/cli/suggestion.h"
#include "raster/base/fail.h"

namespace qs {

std::string Option::short_name() const { return name == "--output" ? "-o" : ""; }

std::string Option::shown() const {
  const std::string names = short_name().empty() ? name : short_name() + ", " + name;
  return placeholder.empty() ? names : names + " " + placeholder;
}

Options::Options(std::string command, std::string summary)
    : command_(std::move(command)), summary_(std::move(summary)) {}

void Options::positional(const std::string& name, std::filesystem::path& target,
                         const std::string& help, Samples samples) {
  const auto accept = [&target, name](const auto& values) {
    require_text(name, "a file or folder", values.back());
    target = values.back();
  };
  options_.push_back({name, "", help, 1, 1, accept, std::move(samples), true});
}

void Options::positionals(const std::string& name, std::vector<std::filesystem::path>& target,
                          int least, const std::string& help, Samples samples) {
  const auto accept = [&target, name](const auto& values) {
    for (const std::string& given : values) require_text(name, "a file or folder", given);
    target.assign(values.begin(), values.end());
  };
  options_.push_back({name, "", help, least, -1, accept, std::move(samples), least > 0});
}

void Options::flag(const std::string& name, bool& target, const std::string& help) {
  options_.push_back({name, "", help, 0, 0, [&target](const auto&) { target = true; }});
}

void Options::value(const std::string& name, const std::string& placeholder,
                    const std::string& help, Samples samples,
                    std::function<void(const std::string& text)> accept) {
  options_.push_back({name, placeholder, help, 1, 1,
                      [accept = std::move(accept)](const auto& values) { accept(values.back()); },
                      std::move(samples)});
}

void Options::choice(const std::string& name, const std::vector<std::string>& names,
                     const std::function<void(int index)>& chosen, const std::string& help) {
  value(name, joined(names, "|"), help, names, [=](const std::string& given) {
    const auto found = std::find(names.begin(), names.end(), given);
    if (found == names.end())
      fail(ErrorKind::usage, "{}: '{}' is none of {}{}", name, given, joined(names, ", "),
           suggestion(given, names));
    chosen(static_cast<int>(found - names.begin()));
  });
  offers(names);
}

void Options::common(const std::function<void()>& declare) {
  const std::size_t before = options_.size();
  declare();
  for (std::size_t i = before; i < options_.size(); ++i) options_[i].common = true;
}

void Options::overwrite(bool* target) {
  writes_ = true;
  options_.push_back({"--overwrite", "", "replaces existing files, but never an input", 0, 0,
                      [target, overwrites = overwrites_](const auto&) {
                        *overwrites = true;
                        if (target != nullptr) *target = true;
                      }});
}

void Options::example(std::string command_line, std::string what) {
  examples_.push_back({std::move(command_line), std::move(what)});
}

bool Options::parse(std::span<const std::string> arguments) const try {
  check_dashes(arguments);
  CLI::App parser;
  parser.set_help_flag("-h,--help");
  parser.allow_extras();
  std::vector<std::pair<CLI::Option*, const Option*>> added;
  for (const Option& option : options_) {
    const std::string short_name = option.short_name();
    const std::string names = short_name.empty() ? option.name : short_name + "," + option.name;
    CLI::Option* row =
        option.most == 0 ? parser.add_flag(names)->take_last() : parser.add_option(names);
    if (option.most < 0) row->expected(option.least, 1 << 20)->allow_extra_args();
    if (option.most == 1) row->expected(1)->take_last();
    added.emplace_back(row, &option);
  }
  parser.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  for (const std::string& word : parser.remaining()) {
    if (word == "--") continue;
    if (word.starts_with('-')) complain_of_option(word);
    complain(fmt::format("unexpected argument '{}'", word));
  }
  // Later than unknown options: a mistyped option may be the missing one.
  for (const auto& [row, option] : added)
    if (option->required && row->count() == 0) complain(option->name + " is required");
  for (const auto& [row, option] : added) {
    if (row->count() == 0 || (option->most == 0 && !row->as<bool>())) continue;
    option->accept(row->results());
  }
  return true;
} catch (const CLI::CallForHelp&) {
  fmt::print("{}", help());
  return false;
} catch (const CLI::ArgumentMismatch&) {  // an option takes any next word as its value
  complain(arguments.back() + " needs a value");
} catch (const CLI::ParseError& error) {
  complain(error.what());
}

// CLI11 would read "-output" as "-o utput".
void Options::check_dashes(std::span<const std::string> arguments) const {
  for (const std::string& word : arguments) {
    const std::string full = "-" + word.substr(0, word.find('='));
    if (word.size() > 2 && std::any_of(options_.begin(), options_.end(),
                                       [&](const Option& option) { return option.name == full; }))
      complain_of_option(word);
  }
}

void Options::require_text(const std::string& name, const std::string& placeholder,
                           const std::string& given) {
  if (given.empty())
    fail(ErrorKind::usage, "{}: an empty text was given instead of {}", name, placeholder);
}

void Options::complain_of_option(const std::string& word) const {
  std::vector<std::string> names = other_words_;
  names.emplace_back("--help");
  for (const Option& option : options_)
    if (!option.positional()) names.push_back(option.name);
  complain(fmt::format("unknown option '{}'{}", word,
                       suggestion(word.substr(0, word.find('=')), names)));
}

void Options::complain(const std::string& what) const {
  fail(ErrorKind::usage, "{}: {} (see 'quadsplat {} --help')", command_, what, command_);
}

std::string Options::usage() const {
  std::string text;
  for (const Option& option : options_) {
    if (option.positional())
      text += option.required ? fmt::format("{}{} ", option.name, option.most < 0 ? "..." : "")
                              : fmt::format("[{}] ", option.name);
  }
  return text + "[options]";
}

std::string Options::help() const {
  std::string text = fmt::format("quadsplat {}: {}\n\nusage: quadsplat {} {}\n\n", command_,
                                 summary_, command_, usage());
  const auto line = [&text](const std::string& left, const std::string& right) {
    text += left.size() <= 28 ? fmt::format("  {:28}  {}\n", left, right)
                              : fmt::format("  {}\n  {:28}  {}\n", left, "", right);
  };
  const auto lines = [&](bool positional, bool common) {
    for (const Option& option : options_) {
      if (option.positional() == positional && option.common == common)
        line(option.shown(), option.help);
    }
  };
  lines(true, false);
  lines(false, false);
  line("--help", "this text");
  if (std::any_of(options_.begin(), options_.end(), [](const Option& o) { return o.common; })) {
    text += "\nscene and rendering:\n";
    lines(false, true);
  }
  if (!examples_.empty()) text += "\nexamples:\n";
  for (const Example& example : examples_)
    text += fmt::format("  {}\n      {}\n", example.command_line, example.what);
  return text;
}

}  // namespace qs
