// SPDX-License-Identifier: MIT
//
// Measures heap use: malloc and its relatives are replaced by functions that count and call
// glibc's. Sanitizers replace malloc themselves and offer hooks instead.
#include <atomic>
#include <cerrno>

#include <malloc.h>

#include "io/support/limits.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define QS_SANITIZED 1
// As in <sanitizer/allocator_interface.h>, which Debian's GCC does not include.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));
extern "C" std::size_t __sanitizer_get_allocated_size(const volatile void*);
#else
#define QS_SANITIZED 0
#endif

namespace {

// Constant-initialised: malloc is called before any constructor.
constinit std::atomic<long> g_alive{0}, g_peak{0};

void add(std::size_t bytes) {
  const long alive = g_alive.fetch_add(static_cast<long>(bytes)) + static_cast<long>(bytes);
  long peak = g_peak.load();
  while (alive > peak && !g_peak.compare_exchange_weak(peak, alive)) {
  }
}
void remove(std::size_t bytes) { g_alive.fetch_sub(static_cast<long>(bytes)); }

#if QS_SANITIZED

const int g_installed = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t bytes) { add(bytes); },
    [](const volatile void* memory) { remove(__sanitizer_get_allocated_size(memory)); });

#else

void* counted(void* memory) {
  if (memory != nullptr) add(malloc_usable_size(memory));
  return memory;
}

#endif

}  // namespace

#if !QS_SANITIZED
extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t bytes) { return counted(__libc_malloc(bytes)); }
void* calloc(std::size_t count, std::size_t bytes) { return counted(__libc_calloc(count, bytes)); }
void* memalign(std::size_t alignment, std::size_t bytes) {
  return counted(__libc_memalign(alignment, bytes));
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) { return memalign(alignment, bytes); }
int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) {
  void* const made = memalign(alignment, bytes);
  if (made == nullptr) return ENOMEM;
  *memory = made;
  return 0;
}
void free(void* memory) {
  remove(malloc_usable_size(memory));  // 0 of a null pointer
  __libc_free(memory);
}
void* realloc(void* memory, std::size_t bytes) {
  const std::size_t before = malloc_usable_size(memory);
  void* const moved = __libc_realloc(memory, bytes);
  if (moved == nullptr && bytes > 0) return nullptr;  // `memory` is still valid
  remove(before);
  return counted(moved);
}

}  // extern "C"
#endif

namespace qs::test {

HeapPeak::HeapPeak() : before_(g_alive) { g_peak = before_; }

std::size_t HeapPeak::bytes() const { return static_cast<std::size_t>(g_peak - before_); }

}  // namespace qs::test
