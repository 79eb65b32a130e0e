// SPDX-License-Identifier: MIT
//
// "Did you mean ...?" for mistyped words of a command line.
#pragma once

#include <span>
#include <string>

namespace qs {

/// "; did you mean 'WORD'?" with the candidate nearest to `typed`, or "" if no candidate is near:
/// at most two letters are missing, extra, wrong or exchanged, and fewer in short words. Small and
/// large letters are equal, and some words of other programs have a meaning here.
std::string suggestion(const std::string& typed, std::span<const std::string> candidates);

}  // namespace qs
