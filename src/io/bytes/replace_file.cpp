// SPDX-License-Identifier: MIT
#include "io/bytes/replace_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <ostream>
#include <set>
#include <string>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "base/fail.h"
#include "base/path_kind.h"
#include "base/temporaries.h"
#include "io/bytes/file_guard.h"

namespace qs {

namespace {

namespace fs = std::filesystem;

std::string reason_of(int error_number) {
  if (error_number == ENOSPC || error_number == EDQUOT) return "the disk is full";
  return error_number == 0 ? "the file system refuses it" : std::strerror(error_number);
}

// A new hidden folder in `folder` for the unfinished content of `shown`.
UnfinishedFolder hidden_folder(const fs::path& folder, const fs::path& shown) try {
  return UnfinishedFolder(folder / ".quadsplat-");
} catch (const fs::filesystem_error& error) {
  fail("{}: cannot be written: {}", shown.string(), reason_of(error.code().value()));
}

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : ".";
}

// Throws Error(input) if no file can have this name.
void require_place(const fs::path& path) {
  const fs::path folder = folder_of(path);
  if (!is_folder(folder))
    fail("{}: cannot be written: the folder {} does not exist", path.string(), folder.string());
  if (is_folder(path)) fail("{}: cannot be written: it is a folder", path.string());
  if (access(folder.c_str(), W_OK) != 0)
    fail("{}: cannot be written: the folder does not allow it", path.string());
}

// A folder with its whole name, and the nearest folder above it that exists.
struct FolderPlace {
  fs::path place, above;
};

FolderPlace place_of(const fs::path& folder) {
  std::error_code error;
  const fs::path target = fs::absolute(folder, error).lexically_normal();
  if (error) fail("'{}': cannot be created: {}", folder.string(), error.message());
  const fs::path place = target.has_filename() ? target : target.parent_path();
  fs::path above = place.parent_path();
  while (!fs::exists(above, error) && above.has_relative_path()) above = above.parent_path();
  return {place, above};
}

// Waits until the content of a file, or the names in a folder, are on the disk. `shown` is the name
// in messages. Some file systems lack this for folders, and a folder may be closed to readers.
void sync(const fs::path& path, const fs::path& shown) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  const int reason = fsync(file) == 0 ? 0 : errno;
  close(file);
  if (reason == EIO || reason == ENOSPC || reason == EDQUOT)
    fail("{}: cannot be written: {}", shown.string(), reason_of(reason));
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
    if (!entry.is_directory()) files.push_back(entry.path().lexically_relative(folder));
  return files;
}

}  // namespace

void naming(const fs::path& shown, const fs::path& hidden, const std::function<void()>& work) try {
  work();
} catch (const Error& error) {
  std::string message = error.what();
  const std::string name = hidden.string();
  for (std::size_t at = 0; (at = message.find(name, at)) != std::string::npos;)
    message.replace(at, name.size(), shown.string());
  throw Error(error.kind(), message);
}

void replace_file(const std::filesystem::path& path, const WriteFiles& write) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && std::filesystem::is_other(status)) return write(path);
  if (std::filesystem::is_symlink(path, error) && std::filesystem::is_regular_file(status))
    return replace_file(std::filesystem::canonical(path), write);
  require_place(path);
  const bool replaces = check_target(path);
  const bool is_part = is_unfinished(path);  // replace_folder() will sync it
  const UnfinishedFolder hidden = hidden_folder(folder_of(path), path);
  const fs::path temporary = hidden.path() / path.filename();
  write(temporary);
  if (!is_part) sync(temporary, path);
  move_undisturbed([&] { fs::rename(temporary, path, error); });
  if (error) fail("{}: cannot be written: {}", path.string(), error.message());
  if (is_part) return;
  sync(folder_of(path), path);
  note_written(path, replaces);
}

void replace_folder(const fs::path& folder, const WriteFiles& write) {
  check_folder(folder);
  const FolderPlace where = place_of(folder);
  const UnfinishedFolder hidden = hidden_folder(where.above, folder);
  std::error_code error;
  naming(folder, hidden.path(), [&] { write(hidden.path()); });
  const std::vector<fs::path> files = files_in(hidden.path());
  std::vector<bool> replaced;
  for (const fs::path& file : files) {
    replaced.push_back(check_target(folder / file));
    sync(hidden.path() / file, folder / file);
  }
  move_undisturbed([&] {
    fs::create_directories(where.place, error);
    for (std::size_t i = 0; i < files.size() && !error; ++i) {
      fs::create_directories((where.place / files[i]).parent_path(), error);
      if (!error) fs::rename(hidden.path() / files[i], where.place / files[i], error);
    }
  });
  if (error) fail("{}: cannot be written: {}", folder.string(), error.message());
  std::set<fs::path> changed = {where.above, where.place};
  for (const fs::path& file : files) changed.insert(folder_of(where.place / file));
  for (const fs::path& place : changed) sync(place, folder);
  for (std::size_t i = 0; i < files.size(); ++i) note_written(folder / files[i], replaced[i]);
}

void check_targets(std::initializer_list<std::optional<fs::path>> files) {
  std::vector<fs::path> names;
  for (const std::optional<fs::path>& file : files) {
    std::error_code error;
    if (!file || *file == "-" || fs::is_other(fs::status(*file, error))) continue;
    require_place(*file);
    check_target(*file);
    names.push_back(fs::weakly_canonical(fs::absolute(*file), error));
    if (std::find(names.begin(), names.end() - 1, names.back()) != names.end() - 1)
      fail(ErrorKind::usage, "{}: two results would have this name: choose another for one of them",
           file->string());
  }
}

void check_folder(const fs::path& folder) {
  const auto [place, above] = place_of(folder);
  if (is_folder(place)) return;
  if (is_there(place)) fail("{}: cannot be created: it is a file", folder.string());
  if (!is_folder(above) || access(above.c_str(), W_OK) != 0)
    fail("{}: cannot be created: the folder {} does not allow it", folder.string(), above.string());
}

void make_folder(const std::filesystem::path& folder) {
  if (folder.empty()) return;  // the current folder
  check_folder(folder);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) fail("{}: cannot be created: {}", folder.string(), error.message());
}

void write_file(const std::filesystem::path& path, const WriteStream& write) {
  replace_file(path, [&](const std::filesystem::path& temporary) {
    std::ofstream file(temporary, std::ios::binary);
    if (!file) fail("{}: cannot be written: the folder does not allow it", path.string());
    errno = 0;
    write(file);
    file.close();
    if (!file) fail_to_write(path, temporary);
  });
}

void fail_to_write(const std::filesystem::path& path, const std::filesystem::path& file) {
  const int reason = errno;
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  const std::string after = error ? "" : fmt::format(" after {} bytes", bytes);
  fail("{}: cannot be written: {}{}", path.string(), reason_of(reason), after);
}

FolderLock::FolderLock(const std::filesystem::path& folder, const char* who)
    : folder_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (!folder_) return;
  int result = 0;
  do {
    result = flock(folder_.get(), LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  if (result == 0) return;
  if (errno == EWOULDBLOCK) fail(ErrorKind::usage, "{}: {}", folder.string(), who);
  folder_.reset();
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  if (path == "-") {
    fmt::print("{}", text);
    return;
  }
  write_file(path, [&](std::ostream& file) { file << text; });
}

}  // namespace qs
