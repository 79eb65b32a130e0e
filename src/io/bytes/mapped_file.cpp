// SPDX-License-Identifier: MIT
#include "io/bytes/mapped_file.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/descriptor.h"
#include "base/fail.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/lfs_pointer.h"

namespace qs {
namespace {

std::atomic<bool> copies_files = false;

void read_bytes(int file, const std::filesystem::path& path, std::span<std::byte> bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count =
        pread(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
    if (count == 0)
      fail("{}: another program truncated it during reading: {} of {} bytes are left",
           path.string(), done, bytes.size());
    done += static_cast<std::size_t>(count);
  }
}

}  // namespace

void MappedFile::copy_files(bool copies) { copies_files = copies; }

MappedFile::MappedFile(const std::filesystem::path& path) {
  // O_NONBLOCK: opening a named pipe must not block until it has a writer.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!file) fail("{}: cannot be opened: {}", path.string(), std::strerror(errno));
  struct stat status = {};
  if (fstat(file.get(), &status) != 0 || !S_ISREG(status.st_mode))
    fail("{}: is not a regular file", path.string());
  note_input(path);
  std::array<char, 64> start{};
  if (pread(file.get(), start.data(), start.size(), 0) > 0)
    refuse_lfs_pointer({start.data(), start.size()}, path);
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return;
  if (copies_files) {
    copy_ = std::make_unique_for_overwrite<std::byte[]>(size);
    read_bytes(file.get(), path, {copy_.get(), size});
    content_ = {copy_.get(), size};
    return;
  }
  void* const memory = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
  if (memory == MAP_FAILED) fail("{}: cannot be read: {}", path.string(), std::strerror(errno));
  content_ = {static_cast<const std::byte*>(memory), size};
  madvise(memory, size, MADV_WILLNEED);  // only a hint: starts reading ahead
}

MappedFile::~MappedFile() {
  if (!content_.empty() && !copy_) munmap(const_cast<std::byte*>(content_.data()), content_.size());
}

}  // namespace qs
