// SPDX-License-Identifier: MIT
//
// files_in_zip() through libzip. The number of entries, the size of each and the sum of all are
// limited before anything is unpacked; checksums are verified by reading to the end.
#include <algorithm>
#include <memory>

#include <zip.h>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/file_source.h"
#include "raster/base/fail.h"

namespace qs {
namespace {

constexpr std::int64_t kMaxEntries = 65536;
// Most entries are compressed pictures, so unpacked entries are little larger than the archive,
// except for the description.
constexpr std::uint64_t kMaxInflation = 16, kAlwaysAllowed = 8u << 20;

struct Discard {
  void operator()(zip_t* archive) const { zip_discard(archive); }
};
struct Close {
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

class ZipFiles : public FileSource {
 public:
  ZipFiles(std::span<const std::byte> content, std::string path, std::string_view root)
      : path_(std::move(path)), allowed_(kMaxInflation * content.size() + kAlwaysAllowed) {
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* const source =
        zip_source_buffer_create(content.data(), content.size(), 0, &error);
    if (source != nullptr) {
      archive_.reset(zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error));
      if (!archive_) zip_source_free(source);
    }
    const std::string problem = zip_error_strerror(&error);
    zip_error_fini(&error);
    if (!archive_) fail("{}: not a sound zip archive ({})", path_, problem);
    find_root(root);
  }

  Array<std::byte> read(const std::string& name, std::uint64_t max_bytes) override {
    const std::string full = prefix_ + checked_file_name(name, path_);
    const zip_int64_t index = zip_name_locate(archive_.get(), full.c_str(), 0);
    if (index < 0) fail("{}: the archive has no file {}", path_, full);
    const auto entry = static_cast<zip_uint64_t>(index);
    zip_stat_t stat;
    zip_stat_init(&stat);
    if (zip_stat_index(archive_.get(), entry, 0, &stat) != 0 || (stat.valid & ZIP_STAT_SIZE) == 0) {
      fail("{}: the size of {} in the archive is unknown", path_, full);
    }
    if (stat.size > max_bytes) {
      fail("{}: {} has {} bytes unpacked, more than the {} that make sense", path_, full, stat.size,
           max_bytes);
    }
    if (stat.size > allowed_) {
      fail("{}: its files have more bytes unpacked than make sense in such a small archive", path_);
    }
    allowed_ -= stat.size;
    const std::unique_ptr<zip_file_t, Close> file(zip_fopen_index(archive_.get(), entry, 0));
    if (!file) fail("{}: {}: {}", path_, full, zip_strerror(archive_.get()));
    // Reading one byte more than announced detects a wrong size, and reaching the end verifies the
    // checksum.
    Array<std::byte> bytes(stat.size + 1);
    std::uint64_t filled = 0;
    while (filled < bytes.size()) {
      const zip_int64_t got = zip_fread(file.get(), bytes.data() + filled, bytes.size() - filled);
      if (got < 0) fail("{}: {} is damaged ({})", path_, full, zip_file_strerror(file.get()));
      if (got == 0) break;
      filled += static_cast<std::uint64_t>(got);
    }
    if (filled != stat.size) {
      fail("{}: {} does not have the {} bytes that the archive announces", path_, full, stat.size);
    }
    bytes.pop_back();
    return bytes;
  }

  bool has(const std::string& name) const override {
    return zip_name_locate(archive_.get(), (prefix_ + name).c_str(), 0) >= 0;
  }

  std::uint64_t stored_bytes(const std::string& name) const override {
    zip_stat_t stat;
    zip_stat_init(&stat);
    const bool known = zip_stat(archive_.get(), (prefix_ + name).c_str(), 0, &stat) == 0 &&
                       (stat.valid & ZIP_STAT_COMP_SIZE) != 0;
    return known ? stat.comp_size : 0;
  }

  bool is_folder() const override { return false; }

 private:
  void find_root(std::string_view root) {
    if (zip_name_locate(archive_.get(), std::string(root).c_str(), 0) >= 0) return;
    const zip_int64_t entries = zip_get_num_entries(archive_.get(), 0);
    if (entries > kMaxEntries) fail("{}: an archive of {} files", path_, entries);
    int found = 0;
    for (zip_int64_t i = 0; i < entries; ++i) {
      const char* const text = zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), 0);
      const std::string_view name = text != nullptr ? text : "";
      if (name.size() <= root.size() || !name.ends_with(root) ||
          name[name.size() - root.size() - 1] != '/')
        continue;
      prefix_ = name.substr(0, name.size() - root.size());
      ++found;
    }
    if (found == 0) fail("{}: a zip archive without {}", path_, root);
    if (found > 1) fail("{}: a zip archive with {} files {}", path_, found, root);
  }

  std::string path_;
  std::string prefix_;
  std::uint64_t allowed_;  // bytes that may still be unpacked
  std::unique_ptr<zip_t, Discard> archive_;
};

}  // namespace

std::unique_ptr<FileSource> files_in_zip(std::span<const std::byte> content,
                                         const std::filesystem::path& path, std::string_view root) {
  return std::make_unique<ZipFiles>(content, path.string(), root);
}

bool is_zip(std::span<const std::byte> content) {
  const std::string_view text(reinterpret_cast<const char*>(content.data()), content.size());
  constexpr std::string_view kEntry = "PK\x03\x04", kEmpty = "PK\x05\x06";
  return text.starts_with(kEntry) || text.starts_with(kEmpty);
}

std::string_view first_name_in_zip(std::span<const std::byte> content) {
  constexpr std::size_t kLength = 26, kName = 30;  // of the header
  if (!is_zip(content) || content.size() < kName) return {};
  const std::size_t length = load<std::uint16_t>(content.data() + kLength);
  return {reinterpret_cast<const char*>(content.data()) + kName,
          std::min(length, content.size() - kName)};
}

bool is_npz(std::span<const std::byte> content) {
  return first_name_in_zip(content).ends_with(".npy");
}

bool is_torch_archive(std::span<const std::byte> content) {
  return first_name_in_zip(content).ends_with("/data.pkl");
}

}  // namespace qs
