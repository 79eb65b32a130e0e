// SPDX-License-Identifier: MIT
//
// Zip archives as the files in them, to change archives in tests.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <zip.h>

namespace qs::test {

/// Names and contents, in the order of the archive.
using ZipEntries = std::vector<std::pair<std::string, std::string>>;

inline ZipEntries zip_entries(const std::filesystem::path& path) {
  zip_t* const archive = zip_open(path.c_str(), ZIP_RDONLY, nullptr);
  if (archive == nullptr) throw std::runtime_error("cannot open " + path.string());
  ZipEntries entries;
  for (zip_int64_t i = 0; i < zip_get_num_entries(archive, 0); ++i) {
    zip_stat_t stat;
    zip_stat_index(archive, static_cast<zip_uint64_t>(i), 0, &stat);
    std::string content(stat.size, '\0');
    zip_file_t* const file = zip_fopen_index(archive, static_cast<zip_uint64_t>(i), 0);
    zip_fread(file, content.data(), content.size());
    zip_fclose(file);
    entries.emplace_back(stat.name, std::move(content));
  }
  zip_discard(archive);
  return entries;
}

inline std::string& entry(ZipEntries& entries, const std::string& name) {
  for (auto& [found, content] : entries)
    if (found == name) return content;
  throw std::runtime_error("no entry " + name);
}

/// Writes the archive, stored or deflated.
inline void write_zip(const std::filesystem::path& path, const ZipEntries& entries,
                      bool deflated = false) {
  zip_t* const archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  if (archive == nullptr) throw std::runtime_error("cannot write " + path.string());
  for (const auto& [name, content] : entries) {
    zip_source_t* const source = zip_source_buffer(archive, content.data(), content.size(), 0);
    const zip_int64_t index = zip_file_add(archive, name.c_str(), source, ZIP_FL_OVERWRITE);
    zip_set_file_compression(archive, static_cast<zip_uint64_t>(index),
                             deflated ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0);
  }
  if (zip_close(archive) != 0) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace qs::test
