// SPDX-License-Identifier: MIT
//
// Everything that reads files of unknown origin, as functions of one file's bytes. Rows come from
// the tables of formats, so a new scene, camera or picture format is fuzzed without a change here.
// Shared by the libFuzzer program (fuzz.cpp) and by io_tests, which runs the seeds.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace qs::test {

struct FuzzTarget {
  std::string name;  ///< without blanks
  std::string
      ending;  ///< seeds are the files below tests/data whose paths end with one of these words
  /// Reads the bytes. Throws std::logic_error when the reader breaks a promise: its result must be
  /// sound, or it must throw an Error with one sentence that names the file.
  std::function<void(std::span<const std::byte> content)> run;
};

std::vector<FuzzTarget> fuzz_targets();

}  // namespace qs::test
