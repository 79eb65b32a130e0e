// SPDX-License-Identifier: MIT
#include "app/report/work_folder.h"

#include <system_error>

#include "base/fail.h"

namespace qs {

WorkFolder::WorkFolder() try
    : UnfinishedFolder(std::filesystem::temp_directory_path() / "quadsplat-") {
} catch (const std::filesystem::filesystem_error& error) {
  fail("{}: no temporary folder can be created: {}", error.path1().string(),
       error.code().message());
}

}  // namespace qs
