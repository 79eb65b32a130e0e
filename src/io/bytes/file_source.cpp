// SPDX-License-Identifier: MIT
#include "io/bytes/file_source.h"

#include <algorithm>
#include <system_error>

#include "base/fail.h"
#include "io/bytes/mapped_file.h"

namespace qs {
namespace {

class FolderFiles : public FileSource {
 public:
  explicit FolderFiles(std::filesystem::path scene_file) : scene_file_(std::move(scene_file)) {}

  Array<std::byte> read(const std::string& name, std::uint64_t max_bytes) override {
    const std::filesystem::path path =
        scene_file_.parent_path() / checked_file_name(name, scene_file_.string());
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
      fail("{}: the file {} that it names is missing", scene_file_.string(), name);
    }
    const MappedFile file(path);
    if (file.content().size() > max_bytes) {
      fail("{}: the file {} has {} bytes, more than the {} that make sense", scene_file_.string(),
           name, file.content().size(), max_bytes);
    }
    return {file.content().begin(), file.content().end()};
  }

  bool has(const std::string& name) const override {
    std::error_code error;
    return std::filesystem::is_regular_file(scene_file_.parent_path() / name, error);
  }

  std::uint64_t stored_bytes(const std::string& name) const override {
    return std::filesystem::file_size(scene_file_.parent_path() / name);
  }

  bool is_folder() const override { return true; }

 private:
  std::filesystem::path scene_file_;
};

}  // namespace

std::unique_ptr<FileSource> files_beside(const std::filesystem::path& scene_file) {
  return std::make_unique<FolderFiles>(scene_file);
}

std::string checked_file_name(std::string_view name, std::string_view source) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < ' '; };
  bool safe = !name.empty() && name.find_first_of("\\:") == std::string_view::npos &&
              std::none_of(name.begin(), name.end(), is_control);
  const std::filesystem::path path(name);
  safe = safe && !path.is_absolute() && path.has_filename() &&
         std::none_of(path.begin(), path.end(), [](const auto& part) { return part == ".."; });
  if (safe) return path.lexically_normal().string();
  std::string shown(name.substr(0, 80));
  std::replace_if(shown.begin(), shown.end(), is_control, '?');
  fail("{}: unsafe file name '{}': only files in its own folder are read", source, shown);
}

}  // namespace qs
