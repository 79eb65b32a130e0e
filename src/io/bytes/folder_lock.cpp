// SPDX-License-Identifier: MIT
#include "io/bytes/folder_lock.h"

#include <cerrno>

#include <fcntl.h>
#include <sys/file.h>

#include "base/fail.h"

namespace qs {

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

}  // namespace qs
