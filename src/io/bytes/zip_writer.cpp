// SPDX-License-Identifier: MIT
#include "io/bytes/zip_writer.h"

#include <memory>
#include <utility>

#include <zip.h>

#include "io/bytes/replace_file.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

struct DiscardArchive {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};

void write_archive(const std::filesystem::path& file, const std::vector<ZipEntry>& entries,
                   bool deflated) {
  constexpr zip_uint16_t kDate = 1 << 5 | 1;  // 1980-01-01
  int code = 0;
  std::unique_ptr<zip_t, DiscardArchive> archive(
      zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code));
  if (!archive) fail_to_write(file, file);
  for (const ZipEntry& entry : entries) {
    zip_source_t* const source =
        zip_source_buffer(archive.get(), entry.content.data(), entry.content.size(), 0);
    if (source == nullptr) throw std::bad_alloc();
    const zip_int64_t added =
        zip_file_add(archive.get(), entry.name.c_str(), source, ZIP_FL_ENC_UTF_8);
    if (added < 0) {
      zip_source_free(source);
      fail("{}: {}: {}", file.string(), entry.name, zip_strerror(archive.get()));
    }
    const auto index = static_cast<zip_uint64_t>(added);
    zip_set_file_compression(archive.get(), index, deflated ? ZIP_CM_DEFLATE : ZIP_CM_STORE, 0);
    zip_file_set_dostime(archive.get(), index, 0, kDate, 0);
  }
  if (zip_close(archive.get()) != 0)
    fail("{}: cannot be written: {}", file.string(), zip_strerror(archive.get()));
  std::ignore = archive.release();  // closed
}

}  // namespace

void write_zip(const std::filesystem::path& path, const std::vector<ZipEntry>& entries,
               bool deflated) {
  replace_file(path,
               [&](const std::filesystem::path& file) { write_archive(file, entries, deflated); });
}

}  // namespace qs
