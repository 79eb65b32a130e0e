// SPDX-License-Identifier: MIT
//
// Texts of messages that are shortened to fit.
#pragma once

#include <string>

namespace qs {

/// The text with at most `most` letters, at least 3: an ellipsis replaces letters in its middle, so
/// that the begin of a path and the name of its file stay. The text is UTF-8.
std::string shortened_middle(const std::string& text, std::size_t most);

/// The letters of a UTF-8 text.
std::size_t letters_of(const std::string& text);

}  // namespace qs
