// SPDX-License-Identifier: MIT
// Compiled alone: it has a macro of its own.
//
// Static libraries that were compiled for programs, such as Debian's libpng, address `stderr` in a
// way that a shared library cannot have. The linker gives them this variable instead (--wrap).
#include <cstdio>

#ifdef QUADSPLAT_WRAPS_STDERR
// NOLINTBEGIN(bugprone-reserved-identifier, readability-identifier-naming): the linker's names
extern "C" {
extern std::FILE* __real_stderr;
__attribute__((visibility("hidden"))) std::FILE* __wrap_stderr = nullptr;
}

namespace qs::library {
namespace {

__attribute__((constructor)) void set_stderr() { __wrap_stderr = __real_stderr; }
// NOLINTEND(bugprone-reserved-identifier, readability-identifier-naming)

}  // namespace
}  // namespace qs::library
#endif
