// SPDX-License-Identifier: MIT
//
// The only file that includes CLI11, which takes seconds to compile. CLI11 splits the command line;
// values, help and most sentences are ours.
#include "app/cli/options.h"

#include <algorithm>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "raster/base/fail.h"

namespace qs {

Options::Options(std::string command, std::string summary)
    : command_(std::move(command)), summary_(std::move(summary)) {}

void Options::positional(std::string name, std::filesystem::path& target, std::string help) {
  positionals_.push_back({std::move(name), std::move(help), &target, nullptr});
}

void Options::positionals(std::string name, std::vector<std::filesystem::path>& target,
                          std::string help) {
  positionals_.push_back({std::move(name), std::move(help), nullptr, &target});
}

void Options::optional_positional(std::string name, std::vector<std::filesystem::path>& target,
                                  std::string help) {
  positionals_.push_back({std::move(name), std::move(help), nullptr, &target, false});
}

void Options::flag(std::string name, bool& target, std::string help) {
  options_.push_back({std::move(name), "", std::move(help), &target, {}});
}

void Options::value(std::string name, std::string placeholder, std::string help,
                    std::function<void(const std::string&)> accept) {
  options_.push_back(
      {std::move(name), std::move(placeholder), std::move(help), nullptr, std::move(accept)});
}

void Options::choice(const std::string& name, std::vector<std::string> names,
                     std::function<void(int)> chosen, const std::string& help) {
  const std::string placeholder = joined(names, "|");
  value(name, placeholder, help, [=](const std::string& given) {
    const auto found = std::find(names.begin(), names.end(), given);
    if (found == names.end()) {
      fail(ErrorKind::usage, "{}: '{}' is none of {}", name, given, joined(names, ", "));
    }
    chosen(static_cast<int>(found - names.begin()));
  });
}

void Options::example(std::string command_line, std::string what) {
  examples_.push_back({std::move(command_line), std::move(what)});
}

bool Options::parse(std::span<const std::string> arguments) const {
  CLI::App parser;
  parser.set_help_flag();  // ours, below
  parser.allow_extras();
  bool wants_help = false;
  parser.add_flag("-h,--help", wants_help);

  std::vector<std::string> words;  // positional arguments, in order
  parser.add_option("words", words);
  std::vector<std::pair<CLI::Option*, const Option*>> named;
  for (const Option& option : options_) {
    CLI::Option* added = option.flag ? parser.add_flag(option.name, *option.flag)
                                     : parser.add_option(option.name)->expected(1)->take_last();
    named.emplace_back(added, &option);
  }

  try {
    parser.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ArgumentMismatch& error) {  // "--size: 1 required ... missing"
    const std::string_view sentence = error.what();
    complain(fmt::format("{} needs a value", sentence.substr(0, sentence.find(':'))));
  } catch (const CLI::ParseError& error) {
    complain(error.what());
  }
  if (wants_help) {
    fmt::print("{}", help());
    return false;
  }
  for (const std::string& word : parser.remaining()) {
    if (word != "--") complain(fmt::format("unknown option '{}'", word));
  }
  assign_positionals(words);
  for (const auto& [added, option] : named) {
    if (option->accept && added->count() > 0) option->accept(added->results().back());
  }
  return true;
}

void Options::assign_positionals(std::vector<std::string> words) const {
  if (words.size() < positionals_.size() && positionals_[words.size()].required)
    complain(positionals_[words.size()].name + " is missing");
  for (std::size_t i = 0; i < positionals_.size(); ++i) {
    const Positional& positional = positionals_[i];
    if (positional.one) *positional.one = words[i];
    if (positional.many) {
      positional.many->assign(words.begin() + static_cast<std::ptrdiff_t>(i), words.end());
      return;
    }
  }
  if (words.size() > positionals_.size()) {
    complain(fmt::format("unexpected argument '{}'", words[positionals_.size()]));
  }
}

void Options::complain(const std::string& what) const {
  fail(ErrorKind::usage, "{}: {} (see 'quadsplat {} --help')", command_, what, command_);
}

std::string Options::help() const {
  std::string text =
      fmt::format("quadsplat {}: {}\n\nusage: quadsplat {}", command_, summary_, command_);
  for (const Positional& word : positionals_) {
    text += word.required ? fmt::format(" {}{}", word.name, word.many ? "..." : "")
                          : fmt::format(" [{}]", word.name);
  }
  text += " [options]\n\n";
  const auto line = [&text](const std::string& left, const std::string& right) {
    if (left.size() <= 28) {
      text += fmt::format("  {:28}  {}\n", left, right);
    } else {
      text += fmt::format("  {}\n  {:28}  {}\n", left, "", right);
    }
  };
  for (const Positional& word : positionals_) line(word.name, word.help);
  for (const Option& option : options_) {
    line(option.placeholder.empty() ? option.name : option.name + " " + option.placeholder,
         option.help);
  }
  line("--help", "this text");
  if (!examples_.empty()) text += "\nexamples:\n";
  for (const Example& example : examples_) {
    text += fmt::format("  {}\n      {}\n", example.command_line, example.what);
  }
  return text;
}

}  // namespace qs
