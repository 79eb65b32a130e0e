// SPDX-License-Identifier: MIT
// Compiled alone: it depends on where the source tree is.
#include "support/paths.h"

#include "test_paths.h"

namespace qs::test {

std::filesystem::path source_path(const std::string& relative) {
  return std::filesystem::path(QUADSPLAT_SOURCE_DIR) / relative;
}

std::filesystem::path shared_folder() { return QUADSPLAT_SHARED_DIR; }

std::string quadsplat_program() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "quadsplat";
}

}  // namespace qs::test
