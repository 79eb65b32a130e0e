// SPDX-License-Identifier: MIT
#include "app/report/work_folder.h"

#include <stdlib.h>

#include "raster/base/fail.h"

namespace qs {

WorkFolder::WorkFolder() {
  std::error_code error;
  const std::filesystem::path all = std::filesystem::temp_directory_path(error);
  std::string name = (all / "quadsplat-XXXXXX").string();
  if (error || !mkdtemp(name.data()))
    fail("{}: a temporary folder cannot be created in it", all.string());
  folder_ = std::make_unique<TemporaryPath>(name);
}

}  // namespace qs
