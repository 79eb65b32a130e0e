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

#include "base/fail.h"
#include "options/suggestion.h"

namespace qs {

Options::Options(std::string command, std::string summary)
    : command_(std::move(command)), summary_(std::move(summary)) {}

bool Options::parse(std::span<const std::string> arguments) const try {
  check_dashes(arguments);
  CLI::App parser;
  parser.set_help_flag("-h,--help");
  parser.allow_extras();
  std::vector<std::pair<CLI::Option*, const Option*>> added;
  for (const Option& option : table()) {
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
    if (word.size() > 2 && std::ranges::count(table(), full, &Option::name) > 0)
      complain_of_option(word);
  }
}

void Options::complain_of_option(const std::string& word) const {
  std::vector<std::string> names = other_words_;
  names.emplace_back("--help");
  for (const Option& option : table())
    if (!option.positional()) names.push_back(option.name);
  complain(fmt::format("unknown option '{}'{}", word,
                       suggestion(word.substr(0, word.find('=')), names)));
}

void Options::complain(const std::string& what) const {
  fail(ErrorKind::usage, "{}: {} (see 'quadsplat {} --help')", command_, what, command_);
}

void check_rules(const char* command, std::initializer_list<OptionRule> rules) {
  for (const OptionRule& rule : rules)
    if (rule.broken) fail(ErrorKind::usage, "{}: {}", command, rule.sentence);
}

const char* given_option(std::span<const std::string> arguments,
                         std::span<const char* const> names) {
  const auto is_given = [&](const std::string& name) {
    return std::ranges::any_of(arguments, [&](const std::string& word) {
      return word == name || word.starts_with(name + "=");
    });
  };
  const auto found = std::ranges::find_if(names, is_given);
  return found == names.end() ? nullptr : *found;
}

std::string Options::usage() const {
  std::string text;
  for (const Option& option : table())
    if (option.positional())
      text += option.required ? fmt::format("{}{} ", option.name, option.most < 0 ? "..." : "")
                              : fmt::format("[{}] ", option.name);
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
    for (const Option& option : table())
      if (option.positional() == positional && option.common == common)
        line(option.shown(), option.help);
  };
  lines(true, false);
  lines(false, false);
  line("--help", "this text");
  if (std::ranges::any_of(table(), &Option::common)) {
    text += "\nscene and rendering:\n";
    lines(false, true);
  }
  if (!examples().empty()) text += "\nexamples:\n";
  for (const Example& example : examples())
    text += fmt::format("  {}\n      {}\n", example.command_line, example.what);
  return text;
}

}  // namespace qs
