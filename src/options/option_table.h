// SPDX-License-Identifier: MIT
//
// The table of a command's options. Each row binds an option to a variable of the command, which
// keeps its value if the option is not given. Options (app/cli/options.h) reads the command line
// and prints the help by the table, libquadsplat takes options by name, and the sweep test combines
// the rows' samples.
//   options.positional("IN", input, "scene to read", {"scene.ply"});
//   options.integer("--sh-degree", "N", 0, 3, degree, "highest degree to keep");
#pragma once

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"

namespace qs {

/// One option. The name of a positional argument has no dashes.
struct Option {
  std::string name, placeholder, help;
  int least = 1, most = 1;  ///< values: a flag takes 0, most < 0 means any number
  std::function<void(const std::vector<std::string>& values)> accept;  ///< throws Error(usage)
  std::vector<std::string> samples = {};  ///< valid values; files are relative to a folder
  bool required = false;
  /// all valid values, or the values to complete; may be empty
  std::vector<std::string> choices = {};
  bool common = false;  ///< see OptionTable::common()

  bool positional() const { return !name.starts_with('-'); }
  /// "-o" if the option has a short form, else "".
  std::string short_name() const;
  /// "-o, --output FILE": the text for the help.
  std::string shown() const;
};

class OptionTable {
 public:
  using Samples = std::vector<std::string>;

  /// Positional arguments come in the order of declaration. Only the last may take several values.
  void positional(const std::string& name, std::filesystem::path& target, const std::string& help,
                  Samples samples);
  /// `least`: 0 or 1.
  void positionals(const std::string& name, std::vector<std::filesystem::path>& target, int least,
                   const std::string& help, Samples samples);

  void flag(const std::string& name, bool& target, const std::string& help);

  /// The general form. accept(text) converts the text and throws Error(usage) if it is invalid.
  void value(const std::string& name, const std::string& placeholder, const std::string& help,
             Samples samples, std::function<void(const std::string& text)> accept);

  /// An option with one or more values.
  void values(const std::string& name, const std::string& placeholder, const std::string& help,
              Samples samples, std::function<void(const std::vector<std::string>& texts)> accept);

  /// The target of text(), integer() and real() is a variable or a std::optional. An empty text is
  /// an error.
  template <class T>
  void text(const std::string& name, const std::string& placeholder, T& target,
            const std::string& help, const Samples& samples) {
    value(name, placeholder, help, samples, [=, &target](const std::string& given) {
      require_text(name, placeholder, given);
      target = given;
    });
  }
  template <class T>
  void integer(const std::string& name, const std::string& placeholder, int low, int high,
               T& target, const std::string& help) {
    const Samples samples = {std::to_string(low), std::to_string(std::min(low + 1, high))};
    value(name, placeholder, help, samples, [=, &target](const std::string& given) {
      target = parse_integer(name, given, low, high);
    });
  }
  template <class T>
  void real(const std::string& name, const std::string& placeholder, double low, double high,
            T& target, const std::string& help, Samples samples = {}) {
    if (samples.empty()) samples = {std::to_string(low), std::to_string(high)};
    value(name, placeholder, help, samples, [=, &target](const std::string& given) {
      target = static_cast<T>(parse_real(name, given, low, high));
    });
  }
  /// The form for other types. convert(name, text) returns the target's value, or throws.
  template <class T, class Convert>
  void converted(const std::string& name, const std::string& placeholder, T& target,
                 const Convert& convert, const std::string& help, const Samples& samples) {
    value(name, placeholder, help, samples,
          [=, &target](const std::string& given) { target = convert(name, given); });
  }
  /// Values separated by commas; convert(word, text) returns the value of a word, or throws.
  template <class T, class Convert>
  void list(const std::string& name, const std::string& placeholder, std::vector<T>& target,
            const Convert& convert, const std::string& help, const Samples& samples) {
    value(name, placeholder, help, samples, [=, &target](const std::string& given) {
      target.clear();
      for (const std::string& word : separated(given)) target.push_back(convert(word, given));
    });
  }
  /// One of `names`; chosen(index) gets its index.
  void choice(const std::string& name, const std::vector<std::string>& names,
              const std::function<void(int index)>& chosen, const std::string& help);
  /// One of `names`, as a text.
  void named(const std::string& name, const std::vector<std::string>& names, std::string& target,
             const std::string& help);
  /// One of `names`, which are in the order of the enumeration `T`.
  template <class T, class Names>
  void enumerated(const std::string& name, const Names& names, T& target, const std::string& help) {
    choice(
        name, {std::begin(names), std::end(names)},
        [&target](int chosen) { set_enumerator(target, chosen); }, help);
  }

  /// Completion offers these values of the option declared last.
  void offers(std::vector<std::string> values) { options_.back().choices = std::move(values); }

  /// declare() declares options that many commands share: the help lists them after all other
  /// options.
  void common(const std::function<void()>& declare);

  /// The option declared last must be given.
  void required() { options_.back().required = true; }

  /// Declares --overwrite, for commands that write files. `target`, if there is one, is also set.
  void overwrite(bool* target = nullptr);
  /// True if --overwrite was declared.
  bool writes() const { return writes_; }
  /// True if --overwrite was given.
  bool overwrites() const { return *overwrites_; }

  /// Printed at the end of the help.
  void example(std::string command_line, std::string what);

  const std::vector<Option>& table() const { return options_; }

  struct Example {
    std::string command_line, what;
  };
  const std::vector<Example>& examples() const { return examples_; }

 private:
  template <class T>
  static void set_enumerator(T& target, int chosen) {
    target = static_cast<T>(chosen);
  }
  template <class T>
  static void set_enumerator(std::optional<T>& target, int chosen) {
    target = static_cast<T>(chosen);
  }
  static void require_text(const std::string& name, const std::string& placeholder,
                           const std::string& given);

  std::vector<Option> options_;
  std::vector<Example> examples_;
  bool writes_ = false;
  std::shared_ptr<bool> overwrites_ = std::make_shared<bool>(false);  // options_ refers to it
};

}  // namespace qs
