// SPDX-License-Identifier: MIT
#include "app/viewer/panels/file_chooser.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <system_error>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "base/error.h"
#include "base/path_kind.h"
#include "base/text.h"
#include "io/scene/reader.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

bool readable(const fs::path& path) {
  const std::string ending = path.extension().string();
  return ending == ".json" || reads_ending(ending);
}

std::string date_of(const fs::path& path) {
  std::error_code unreachable;
  const fs::file_time_type time = fs::last_write_time(path, unreachable);
  if (unreachable) return "";
  const auto system = std::chrono::time_point_cast<std::chrono::system_clock::duration>(
      std::chrono::file_clock::to_sys(time));
  return fmt::format("{:%Y-%m-%d}", fmt::localtime(std::chrono::system_clock::to_time_t(system)));
}

FileEntry entry_of(const fs::path& path) {
  FileEntry entry{path, path.filename().string(), is_folder(path), "", date_of(path)};
  if (entry.folder) {
    entry.name += "/";
    return entry;
  }
  std::error_code unreachable;
  const std::uintmax_t bytes = fs::file_size(path, unreachable);
  if (!unreachable) entry.size = bytes_text(bytes);
  return entry;
}

}  // namespace

void FileChooser::start(const fs::path& folder, bool chooses_folder) {
  std::error_code error;
  chooses_folder_ = chooses_folder;
  go_to(fs::absolute(folder, error));
}

void FileChooser::go_to(const fs::path& folder) {
  // Removes the last, empty part of a path, so that "/a/" becomes "/a".
  folder_ = folder.has_filename() ? folder.lexically_normal() : folder.parent_path();
  list(folder_);
  ++moves_;
  type("");
}

void FileChooser::list(const fs::path& folder) {
  listed_ = folder;
  entries_.clear();
  std::error_code error;
  for (const auto& entry :
       fs::directory_iterator(folder, fs::directory_options::skip_permission_denied, error)) {
    if (entry.path().filename().string().starts_with('.')) continue;
    if (is_folder(entry.path()) || (!chooses_folder_ && readable(entry.path())))
      entries_.push_back(entry_of(entry.path()));
  }
  std::ranges::sort(entries_, {},
                    [](const FileEntry& entry) { return std::pair(!entry.folder, entry.path); });
  if (folder.has_parent_path() && folder.parent_path() != folder)
    entries_.insert(entries_.begin(), FileEntry{folder.parent_path(), "../", true, "", ""});
}

void FileChooser::type(const std::string& text) {
  typed_ = text;
  problem_.clear();
  const fs::path named = text.find('/') == std::string::npos ? folder_ : typed_path().parent_path();
  if (named != listed_ && is_folder(named)) list(named);
  filter();
}

void FileChooser::filter() {
  const std::string part = typed_.substr(typed_.rfind('/') + 1);
  const auto lower = [](unsigned char c) { return std::tolower(c); };
  rows_.clear();
  std::ranges::copy_if(entries_, std::back_inserter(rows_), [&](const FileEntry& entry) {
    return std::ranges::search(entry.name, part, {}, lower, lower).begin() != entry.name.end();
  });
  moved_ = false;
  selected_ = part.empty() || rows_.empty() ? -1 : 0;
}

fs::path FileChooser::typed_path() const {
  const char* home = std::getenv("HOME");
  if (typed_.starts_with("~/") && home != nullptr) return fs::path(home) / typed_.substr(2);
  return folder_ / typed_;
}

void FileChooser::select(int by) {
  const int last = static_cast<int>(rows_.size()) - 1;
  selected_ = last < 0 ? -1 : std::clamp(selected_ + by, 0, last);
  moved_ = selected_ >= 0;
}

std::optional<fs::path> FileChooser::choose(const FileEntry& entry) {
  if (!entry.folder) return entry.path;
  go_to(fs::path(entry.path));
  return std::nullopt;
}

std::optional<fs::path> FileChooser::enter() {
  const fs::path path = typed_path();
  // The first row is selected while a name is typed; a whole name means its file or folder.
  const bool is_whole = !typed_.empty() && !moved_ && is_there(path);
  if (selected_ >= 0 && !is_whole)
    return choose(FileEntry(rows_[static_cast<std::size_t>(selected_)]));
  if (typed_.empty()) return chooses_folder_ ? std::optional(listed_) : std::nullopt;
  if (!is_whole) {
    problem_ = fmt::format("{} does not exist", path.string());
    return std::nullopt;
  }
  if (chooses_folder_) {
    if (is_folder(path)) return path.has_filename() ? path : path.parent_path();
    problem_ = fmt::format("{} is a file: choose the folder of the photographs", path.string());
    return std::nullopt;
  }
  if (!is_folder(path) || holds_scene(path)) return path;
  go_to(path);
  return std::nullopt;
}

}  // namespace qs
