// SPDX-License-Identifier: MIT
#include "app/plugin/shared_memory.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/fail.h"

namespace qs {
namespace {

[[noreturn]] void refuse(const char* what, std::size_t bytes) {
  fail(ErrorKind::device, "plugin: {} bytes of shared memory: {}: {}", bytes, what,
       std::strerror(errno));
}

}  // namespace

Mapping::Mapping(int descriptor, std::size_t bytes) {
  if (bytes == 0) return;
  void* const data = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (data == MAP_FAILED) refuse("mmap", bytes);
  data_ = {static_cast<std::byte*>(data), Unmap{bytes}};
}

void Mapping::Unmap::operator()(std::byte* data) const { munmap(data, bytes); }

SharedMemory::SharedMemory() : file_(memfd_create("quadsplat plugin", MFD_CLOEXEC)) {
  if (!file_) fail(ErrorKind::device, "plugin: memfd_create: {}", std::strerror(errno));
}

void SharedMemory::resize(std::size_t bytes) {
  if (bytes == mapping_.size()) return;
  mapping_ = {};
  // The pages are allocated here: if the allocation of a page failed later, the process that
  // touches the page would be killed.
  if (ftruncate(file_.get(), 0) != 0) refuse("ftruncate", bytes);
  const int error = bytes == 0 ? 0 : posix_fallocate(file_.get(), 0, static_cast<off_t>(bytes));
  if (error != 0) {
    errno = error;
    refuse("posix_fallocate", bytes);
  }
  mapping_ = Mapping(file_.get(), bytes);
}

}  // namespace qs
