// SPDX-License-Identifier: MIT
#include "io/bytes/replace_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include <unistd.h>

#include "raster/base/fail.h"

namespace qs {
namespace {

// Removes the temporary file unless it was moved away.
struct Temporary {
  std::filesystem::path path;
  ~Temporary() {
    std::error_code ignored;
    if (!path.empty()) std::filesystem::remove(path, ignored);
  }
};

}  // namespace

void replace_file(const std::filesystem::path& path,
                  const std::function<void(const std::filesystem::path& temporary)>& write) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && std::filesystem::is_other(status)) return write(path);
  if (std::filesystem::is_symlink(path, error) && std::filesystem::is_regular_file(status))
    return replace_file(std::filesystem::canonical(path), write);
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, error)) {
    fail("{}: cannot be written: the folder {} does not exist", path.string(), folder.string());
  }
  if (std::filesystem::is_directory(path, error)) {
    fail("{}: cannot be written: it is a folder", path.string());
  }
  Temporary temporary{folder / fmt::format(".{}.{}.tmp{}", path.stem().string(), getpid(),
                                           path.extension().string())};
  write(temporary.path);
  std::filesystem::rename(temporary.path, path, error);
  if (error) fail("{}: cannot be written: {}", path.string(), error.message());
  temporary.path.clear();
}

void write_file(const std::filesystem::path& path,
                const std::function<void(std::ostream& stream)>& write) {
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
  if (reason == ENOSPC || reason == EDQUOT)
    fail("{}: cannot be written: the disk is full{}", path.string(), after);
  fail("{}: cannot be written: {}{}", path.string(),
       reason == 0 ? "the file system refuses it" : std::strerror(reason), after);
}

}  // namespace qs
