// SPDX-License-Identifier: MIT
#include "io/scene/usd/usda_text.h"

#include <algorithm>
#include <charconv>
#include <system_error>

#include "io/bytes/byte_text.h"

namespace qs {
namespace {

constexpr std::string_view kUsdaBlanks = " \t\r\n";
constexpr std::size_t kDeepest = 64;  // nested brackets
constexpr std::size_t kNumbersPerReport = 65536;

bool is_word_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == ':' || c == '.';
}

// Begins a text, the name of a file or a path.
bool is_quote(char c) { return c == '"' || c == '\'' || c == '@' || c == '<'; }

}  // namespace

std::size_t UsdaText::line() const {
  const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(at_, text_.size()));
  return 1 + static_cast<std::size_t>(std::count(text_.begin(), end, '\n'));
}

void UsdaText::skip_blanks() {
  while (at_ < text_.size()) {
    if (text_[at_] == '#') {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (kUsdaBlanks.find(text_[at_]) == kUsdaBlanks.npos) {
      return;
    } else {
      ++at_;
    }
  }
}

bool UsdaText::at_end() {
  skip_blanks();
  return at_ == text_.size();
}

char UsdaText::peek() { return at_end() ? '\0' : text_[at_]; }

bool UsdaText::accept(char c) {
  if (peek() != c) return false;
  ++at_;
  return true;
}

void UsdaText::complain_without(const std::string& what) {
  if (at_end()) complain("the text ends where {} is expected", what);
  complain("{} is expected, there is '{}'", what, printable(text_.substr(at_, 1)));
}

void UsdaText::expect(char c) {
  if (!accept(c)) complain_without(fmt::format("'{}'", c));
}

std::string_view UsdaText::word() {
  skip_blanks();
  const std::size_t begin = at_;
  while (at_ < text_.size() && is_word_character(text_[at_])) ++at_;
  if (at_ == begin) complain_without("a name");
  return text_.substr(begin, at_ - begin);
}

void UsdaText::skip_behind(std::string_view end, const char* what) {
  std::size_t found = text_.find(end, at_), slashes = 0;
  do {  // a backslash before the end belongs to the text
    if (slashes > 0) found = text_.find(end, found + 1);
    if (found == text_.npos) complain("{} has no end", what);
    const std::string_view inside = text_.substr(at_, found - at_);
    slashes = inside.size() - (inside.find_last_not_of('\\') + 1);
  } while (slashes % 2 == 1);
  at_ = found + end.size();
}

std::string_view UsdaText::string() {
  const char quote = peek();
  if (quote != '"' && quote != '\'') complain("a text in quotes is expected");
  const std::string three(3, quote);
  const std::string end = starts_with(three) ? three : three.substr(2);
  at_ += end.size();
  const std::size_t begin = at_;
  skip_behind(end, "a text in quotes");
  return text_.substr(begin, at_ - end.size() - begin);
}

double UsdaText::number() {
  if (peek() == '+') ++at_;
  double value = 0;
  const char* const begin = text_.data() + at_;
  const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
  if (error == std::errc::invalid_argument) complain_without("a number");
  if (error != std::errc()) complain("a number is out of range");
  at_ += static_cast<std::size_t>(end - begin);
  return value;
}

std::vector<double> UsdaText::numbers(std::size_t count) {
  std::vector<double> values;
  std::size_t depth = 0;
  do {
    if (accept('(')) {
      ++depth;
    } else if (depth > 0 && accept(')')) {
      --depth;
    } else if (depth == 0 || !accept(',')) {
      values.push_back(number());
    }
  } while (depth > 0);
  if (values.size() != count) complain("{} numbers where {} are needed", values.size(), count);
  return values;
}

Array<float> UsdaText::array(std::size_t components) {
  Array<float> values;
  expect('[');
  while (!accept(']')) {
    if (components > 1) expect('(');
    for (std::size_t c = 0; c < components; ++c) {
      if (c > 0) expect(',');
      values.push_back(static_cast<float>(number()));
    }
    if (components > 1) expect(')');
    if (values.size() % kNumbersPerReport < components)
      progress_.update(static_cast<float>(at_) / static_cast<float>(text_.size()));
    if (peek() != ']') expect(',');
  }
  return values;
}

std::vector<std::string_view> UsdaText::strings() {
  std::vector<std::string_view> list;
  expect('[');
  while (!accept(']')) {
    list.push_back(string());
    if (peek() != ']') expect(',');
  }
  return list;
}

void UsdaText::skip_brackets() {
  std::string open;  // the brackets that will close
  do {
    const char c = peek();
    if (c == '(' || c == '[' || c == '{') {
      if (open.size() == kDeepest) complain("more than {} levels of brackets", kDeepest);
      open += c == '(' ? ')' : c == '[' ? ']' : '}';
      ++at_;
    } else if (c == ')' || c == ']' || c == '}' || c == '\0') {
      expect(open.back());
      open.pop_back();
    } else if (is_quote(c)) {
      skip_quoted();
    } else {
      // Most of a file are numbers.
      while (++at_ < text_.size() && (text_[at_] == ' ' || (text_[at_] > ')' && text_[at_] < '<')))
        ;
    }
  } while (!open.empty());
}

void UsdaText::skip_quoted() {
  const char c = peek();
  if (c == '"' || c == '\'') {
    string();
  } else if (c == '<') {
    skip_behind(">", "a path");
  } else {
    const std::string_view end = starts_with("@@@") ? "@@@" : "@";
    at_ += end.size();
    skip_behind(end, "the name of a file");
  }
}

std::string_view UsdaText::skip_value() {
  const char c = peek();
  const std::size_t begin = at_;
  if (c == '(' || c == '[' || c == '{') {
    skip_brackets();
  } else if (is_quote(c)) {
    skip_quoted();
    if (c == '@') {  // a prim in the file, and how its times are moved
      if (peek() == '<') skip_quoted();
      if (peek() == '(') skip_brackets();
    }
  } else {
    while (at_ < text_.size() &&
           (is_word_character(text_[at_]) || text_[at_] == '-' || text_[at_] == '+'))
      ++at_;
    if (at_ == begin) complain("a value is expected");
  }
  return text_.substr(begin, at_ - begin);
}

}  // namespace qs
