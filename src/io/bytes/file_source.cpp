// SPDX-License-Identifier: MIT
#include "io/bytes/file_source.h"

#include <algorithm>
#include <functional>
#include <map>
#include <system_error>

#include "base/fail.h"
#include "base/path_kind.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/mapped_file.h"
#include "io/bytes/zip.h"

namespace qs {

namespace {

class FolderFiles : public FileSource {
 public:
  explicit FolderFiles(std::filesystem::path scene_file) : scene_file_(std::move(scene_file)) {}

  Array<std::byte> read(const std::string& name, std::uint64_t max_bytes) override {
    const std::filesystem::path path =
        scene_file_.parent_path() / checked_file_name(name, scene_file_.string());
    if (!is_file(path))
      fail("{}: the file {} that it names is missing", scene_file_.string(), name);
    const MappedFile file(path);
    if (file.content().size() > max_bytes)
      fail("{}: the file {} has {} bytes, more than the {} that make sense", scene_file_.string(),
           name, file.content().size(), max_bytes);
    return {file.content().begin(), file.content().end()};
  }

  bool has(const std::string& name) const override {
    return is_file(scene_file_.parent_path() / name);
  }

  std::uint64_t stored_bytes(const std::string& name) const override {
    return std::filesystem::file_size(scene_file_.parent_path() / name);
  }

 private:
  std::filesystem::path scene_file_;
};

// Most entries are compressed pictures, so unpacked entries are little larger than the archive,
// except for the description.
constexpr std::uint64_t kMaxRatio = 16, kAlwaysAllowed = 8u << 20;

// The size of each file and the sum of all are limited before anything is unpacked.
class ZipFiles : public FileSource {
 public:
  ZipFiles(ByteSpan content, std::string path, std::string_view root)
      : path_(std::move(path)), allowed_(kMaxRatio * content.size() + kAlwaysAllowed) {
    for (ZippedFile& file : zip_directory(content, path_)) {
      std::string name = file.name;
      files_.emplace(std::move(name), std::move(file));  // the first of a name counts
    }
    find_root(root);
  }

  Array<std::byte> read(const std::string& name, std::uint64_t max_bytes) override {
    const std::string full = prefix_ + checked_file_name(name, path_);
    const auto found = files_.find(full);
    if (found == files_.end()) fail("{}: the archive has no file {}", path_, full);
    const ZippedFile& file = found->second;
    if (file.bytes > max_bytes)
      fail("{}: {} has {} bytes unpacked, more than the {} that make sense", path_, full,
           file.bytes, max_bytes);
    if (file.bytes > allowed_)
      fail("{}: its files have more bytes unpacked than make sense in such a small archive", path_);
    allowed_ -= file.bytes;
    return unzipped(file, path_);
  }

  bool has(const std::string& name) const override { return files_.count(prefix_ + name) > 0; }

  std::uint64_t stored_bytes(const std::string& name) const override {
    const auto found = files_.find(prefix_ + name);
    return found == files_.end() ? 0 : found->second.stored.size();
  }

 private:
  void find_root(std::string_view root) {
    if (files_.find(root) != files_.end()) return;
    int found = 0;
    for (const auto& [name, file] : files_) {
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
  std::map<std::string, ZippedFile, std::less<>> files_;
};

}  // namespace

std::unique_ptr<FileSource> files_beside(const std::filesystem::path& scene_file) {
  return std::make_unique<FolderFiles>(scene_file);
}

std::string checked_file_name(std::string_view name, std::string_view source) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
  bool safe = !name.empty() && name.find_first_of("\\:") == std::string_view::npos &&
              std::ranges::none_of(name, is_control);
  const std::filesystem::path path(name);
  safe = safe && !path.is_absolute() && path.has_filename() &&
         std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
  if (safe) return path.lexically_normal().string();
  std::string shown(name.substr(0, 80));
  std::ranges::replace_if(shown, is_control, '?');
  fail("{}: unsafe file name '{}': only files in its own folder are read", source, shown);
}

std::unique_ptr<FileSource> files_in_zip(ByteSpan content, const std::filesystem::path& path,
                                         std::string_view root) {
  return std::make_unique<ZipFiles>(content, path.string(), root);
}

bool is_zip(ByteSpan content) {
  constexpr std::string_view kEntry = "PK\x03\x04", kEmpty = "PK\x05\x06";
  return text_of(content).starts_with(kEntry) || text_of(content).starts_with(kEmpty);
}

std::optional<std::string> ply_in_zip(ByteSpan content) try {
  std::optional<std::string> found;
  for (const ZippedFile& file : zip_directory(content, "")) {
    const std::filesystem::path name(file.name);
    if (name.filename() == "meta.json") return {};
    // macOS adds files for itself whose names begin with "._".
    const bool is_ply = lower_case(name.extension().string()) == ".ply" &&
                        !name.filename().string().starts_with("._");
    if (is_ply) found = found ? "" : file.name;
  }
  return found;
} catch (const Error&) {
  return {};
}

std::string_view first_name_in_zip(ByteSpan content) {
  constexpr std::size_t kLength = 26, kName = 30;  // places in the header
  if (!is_zip(content) || content.size() < kName) return {};
  const std::size_t length = load<std::uint16_t>(content.data() + kLength);
  return text_of(content).substr(kName, length);
}

bool is_npz(ByteSpan content) { return first_name_in_zip(content).ends_with(".npy"); }

bool is_torch_archive(ByteSpan content) {
  return first_name_in_zip(content).ends_with("/data.pkl");
}

bool is_usdz(ByteSpan content) {
  const std::string_view name = first_name_in_zip(content);
  return name.ends_with(".usda") || name.ends_with(".usdc") || name.ends_with(".usd");
}

}  // namespace qs
