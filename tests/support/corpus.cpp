// SPDX-License-Identifier: MIT
#include "support/corpus.h"

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "support/shared.h"

namespace qs::test {

std::filesystem::path committed_corpus() { return source_path("tests/data/corpus"); }

std::vector<CorpusFile> corpus_files(const std::filesystem::path& folder) {
  std::ifstream stream(folder / "expected.json");
  const nlohmann::json table = nlohmann::json::parse(stream);
  std::vector<CorpusFile> files;
  for (const auto& [name, expected] : table.items()) {
    files.push_back({name, folder / expected.at("kind").get<std::string>() / name, expected});
  }
  return files;
}

std::vector<std::byte> file_bytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw std::runtime_error("cannot open " + path.string());
  const std::string text((std::istreambuf_iterator<char>(stream)), {});
  return to_bytes(text);
}

void write_bytes(const std::filesystem::path& path, const std::vector<std::byte>& bytes) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
}

std::vector<std::byte> to_bytes(std::string_view text) {
  const auto* const begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

}  // namespace qs::test
