// SPDX-License-Identifier: MIT
//
// The splat files for tests of readers: the files of tests/data/corpus and of the larger corpus in
// the shared folder, each with its expected outcome.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace qs::test {

struct CorpusFile {
  std::string name;
  std::filesystem::path path;
  nlohmann::json expected;  ///< its entry in expected.json

  bool valid() const { return expected.at("kind") == "valid"; }
};

std::filesystem::path committed_corpus();

/// The files of a corpus folder, and the subfolders that are one scene.
std::vector<CorpusFile> corpus_files(const std::filesystem::path& folder);

std::vector<std::byte> file_bytes(const std::filesystem::path& path);
void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes);
std::vector<std::byte> to_bytes(std::string_view text);

}  // namespace qs::test
