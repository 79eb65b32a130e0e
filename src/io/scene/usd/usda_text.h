// SPDX-License-Identifier: MIT
//
// Walks through the text of a .usda file: words, strings, numbers, and values of any kind, which
// are skipped without being stored. It builds no tree, so it stores nothing but the arrays that the
// caller asks for. Source of the grammar: OpenUSD's documentation of the text file format.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/fail.h"
#include "base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

class UsdaText {
 public:
  /// Both must outlive this. `progress` is updated with the part of the text that was read.
  UsdaText(std::string_view text, std::string source, const Progress& progress)
      : text_(text), source_(std::move(source)), progress_(progress) {}

  /// Throws Error(input) "SOURCE: line N: SENTENCE".
  template <class... Args>
  [[noreturn]] void complain(fmt::format_string<Args...> sentence, Args&&... args) const {
    fail("{}: line {}: {}", source_, line(), fmt::format(sentence, std::forward<Args>(args)...));
  }

  /// Moves back to the start of a value that skip_value() returned.
  void move_to(std::string_view value) {
    at_ = static_cast<std::size_t>(value.data() - text_.data());
  }
  /// True behind the last token. Like all functions, skips blanks and comments first.
  bool at_end();
  /// The next character; 0 at the end.
  char peek();
  /// Moves behind `c` if it comes next.
  bool accept(char c);
  /// Moves behind `c`, or throws.
  void expect(char c);

  /// A name with its namespaces and suffixes, such as "xformOp:translate" and "points.timeSamples".
  std::string_view word();
  /// The content of a quoted text, as it is written.
  std::string_view string();
  double number();
  /// `count` numbers of a value whose brackets are closed; one number may stand without brackets.
  std::vector<double> numbers(std::size_t count);
  /// The numbers of a list of tuples of `components` numbers, or of numbers if that is 1.
  Array<float> array(std::size_t components);
  /// The quoted texts of a list.
  std::vector<std::string_view> strings();
  /// Any value: a list, dictionary, tuple, text, asset, path, number or word. Returns its text.
  std::string_view skip_value();

 private:
  std::size_t line() const;
  [[noreturn]] void complain_without(const std::string& what);
  void skip_blanks();
  void skip_brackets();
  void skip_quoted();
  bool starts_with(std::string_view word) const { return text_.substr(at_).starts_with(word); }
  void skip_behind(std::string_view end, const char* what);

  std::string_view text_;
  std::string source_;
  const Progress& progress_;
  std::size_t at_ = 0;
};

}  // namespace qs
