// SPDX-License-Identifier: MIT
#include "io/bytes/mapped_file.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "base/descriptor.h"
#include "base/fail.h"
#include "io/bytes/file_guard.h"

namespace qs {

MappedFile::MappedFile(const std::filesystem::path& path) {
  // O_NONBLOCK: opening a named pipe must not block until it has a writer.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) fail("{}: cannot be opened: {}", path.string(), std::strerror(errno));
  struct stat status = {};
  if (fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode)) {
    fail("{}: is not a regular file", path.string());
  }
  note_input(path);
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return;
  void* const memory = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (memory == MAP_FAILED) fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
  content_ = {static_cast<const std::byte*>(memory), size};
  madvise(memory, size, MADV_WILLNEED);  // only a hint: starts reading ahead
}

MappedFile::~MappedFile() {
  if (!content_.empty()) {
    munmap(const_cast<std::byte*>(content_.data()), content_.size());
  }
}

}  // namespace qs
