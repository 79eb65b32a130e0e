// SPDX-License-Identifier: MIT
#include "options/suggestion.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace qs {
namespace {

// Words that users know from other programs, and the word that they mean here.
constexpr std::pair<std::string_view, std::string_view> kOtherWords[] = {{"gpu", "cuda"},
                                                                         {"help", "--help"}};

std::string lower_word(std::string word) {
  std::ranges::transform(word, word.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return word;
}

// The smallest number of letters to insert, delete, replace or exchange with their neighbour
// (Damerau's distance in the restricted form: no letter is edited twice).
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> edits(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        edits[i][j] = i + j;
        continue;
      }
      const std::size_t differs = a[i - 1] == b[j - 1] ? 0 : 1;
      edits[i][j] =
          std::min({edits[i - 1][j] + 1, edits[i][j - 1] + 1, edits[i - 1][j - 1] + differs});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        edits[i][j] = std::min(edits[i][j], edits[i - 2][j - 2] + 1);
    }
  }
  return edits.back().back();
}

}  // namespace

std::string suggestion(const std::string& typed, std::span<const std::string> candidates) {
  const std::string* nearest = nullptr;
  for (const auto& [word, meant] : kOtherWords)
    if (typed == word && std::ranges::find(candidates, meant) != candidates.end())
      return fmt::format("; did you mean '{}'?", meant);
  std::size_t least = std::min<std::size_t>(2, typed.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t edits = distance(lower_word(typed), lower_word(candidate));
    if (edits < least) least = edits, nearest = &candidate;
  }
  return nearest == nullptr ? "" : fmt::format("; did you mean '{}'?", *nearest);
}

}  // namespace qs
