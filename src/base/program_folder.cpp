// SPDX-License-Identifier: MIT
#include "base/program_folder.h"

#include <system_error>

namespace qs {

std::filesystem::path program_folder() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace qs
