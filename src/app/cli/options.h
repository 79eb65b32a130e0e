// SPDX-License-Identifier: MIT
//
// The options of a command, read from the command line: parse() fills the variables of the table,
// help() prints it.
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "options/option_table.h"

namespace qs {

class Options : public OptionTable {
 public:
  Options(std::string command, std::string summary);

  /// Options that are none of this command's, but that a mistyped option may mean.
  void may_mean(std::vector<std::string> words) { other_words_ = std::move(words); }

  /// Returns false after printing the help to stdout for --help. Throws Error(usage) naming the
  /// command and the option.
  bool parse(std::span<const std::string> arguments) const;

  std::string help() const;

  /// "SCENE [MORE...] [options]": the text after the command's name.
  std::string usage() const;

  /// Throws Error(usage): "COMMAND: WHAT".
  [[noreturn]] void complain(const std::string& what) const;

 private:
  [[noreturn]] void complain_of_option(const std::string& word) const;
  void check_dashes(std::span<const std::string> arguments) const;

  std::string command_, summary_;
  std::vector<std::string> other_words_;
};

/// A rule about options that exclude or need each other.
struct OptionRule {
  bool broken;
  std::string sentence;  ///< the error, if it is broken
};
/// Throws Error(usage) "COMMAND: SENTENCE" for the first rule that is broken.
void check_rules(const char* command, std::initializer_list<OptionRule> rules);

/// The first of these options that was given: WORD or WORD=VALUE. Null if none was.
const char* given_option(std::span<const std::string> arguments,
                         std::span<const char* const> names);

}  // namespace qs
