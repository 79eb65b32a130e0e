// SPDX-License-Identifier: MIT
#include "app/viewer/state/message_text.h"

#include <algorithm>
#include <vector>

namespace qs {
namespace {

// Where each letter begins, and the end of the text.
std::vector<std::size_t> begins_of(const std::string& text) {
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool continues = (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80;
    if (!continues) begins.push_back(i);
  }
  begins.push_back(text.size());
  return begins;
}

}  // namespace

std::size_t letters_of(const std::string& text) { return begins_of(text).size() - 1; }

std::string shortened_middle(const std::string& text, std::size_t most) {
  const std::vector<std::size_t> begins = begins_of(text);
  const std::size_t letters = begins.size() - 1;
  most = std::max<std::size_t>(most, 3);
  if (letters <= most) return text;
  const std::size_t head = (most - 1) / 3, tail = most - 1 - head;
  return text.substr(0, begins[head]) + "\u2026" + text.substr(begins[letters - tail]);
}

}  // namespace qs
