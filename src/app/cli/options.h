// SPDX-License-Identifier: MIT
//
// How a command says which options it takes: each is bound to a variable of the command, which
// keeps its value when the option is not given. parse() fills them, and prints the help made of the
// same list.
//   Options options("convert", "writes a scene in another format");
//   options.positional("IN", input, "scene to read");
//   options.integer("--sh-degree", "N", 0, 3, degree, "highest degree to keep");
//   if (!options.parse(arguments)) return 0;  // --help
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/session/text.h"

namespace qs {

class Options {
 public:
  Options(std::string command, std::string summary);

  /// Positional arguments come in the order they are declared and are all required.
  void positional(std::string name, std::filesystem::path& target, std::string help);
  /// The last positional may take one or more.
  void positionals(std::string name, std::vector<std::filesystem::path>& target, std::string help);

  /// The last positional may take none or more.
  void optional_positional(std::string name, std::vector<std::filesystem::path>& target,
                           std::string help);

  void flag(std::string name, bool& target, std::string help);

  /// The general form: accept(text) converts and throws Error(usage).
  void value(std::string name, std::string placeholder, std::string help,
             std::function<void(const std::string& text)> accept);

  /// Targets of text() and integer() may be a plain variable or a std::optional.
  template <class T>
  void text(const std::string& name, const std::string& placeholder, T& target,
            const std::string& help) {
    value(name, placeholder, help, [&target](const std::string& given) { target = given; });
  }
  template <class T>
  void integer(const std::string& name, const std::string& placeholder, int low, int high,
               T& target, const std::string& help) {
    value(name, placeholder, help, [=, &target](const std::string& given) {
      target = parse_integer(name, given, low, high);
    });
  }
  template <class T>
  void real(const std::string& name, const std::string& placeholder, double low, double high,
            T& target, const std::string& help) {
    value(name, placeholder, help, [=, &target](const std::string& given) {
      target = static_cast<T>(parse_real(name, given, low, high));
    });
  }
  /// One of `names`; `chosen` gets its index.
  void choice(const std::string& name, std::vector<std::string> names,
              std::function<void(int)> chosen, const std::string& help);

  /// Shown at the end of the help.
  void example(std::string command_line, std::string what);

  /// False when --help was given and printed to stdout. Throws Error(usage) naming what is wrong.
  bool parse(std::span<const std::string> arguments) const;

  std::string help() const;

 private:
  struct Positional {
    std::string name, help;
    std::filesystem::path* one;
    std::vector<std::filesystem::path>* many;
    bool required = true;
  };
  struct Option {
    std::string name, placeholder, help;
    bool* flag;
    std::function<void(const std::string&)> accept;
  };
  struct Example {
    std::string command_line, what;
  };

  void assign_positionals(std::vector<std::string> words) const;
  [[noreturn]] void complain(const std::string& what) const;

  std::string command_, summary_;
  std::vector<Positional> positionals_;
  std::vector<Option> options_;
  std::vector<Example> examples_;
};

}  // namespace qs
