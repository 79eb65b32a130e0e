// SPDX-License-Identifier: MIT
//
// Names of the files that commands write.
#pragma once

#include <filesystem>
#include <string>

#include "app/viewer/state/viewer.h"

namespace qs {

/// FOLDER/STEM_0001ENDING with the first number whose file does not exist yet.
std::filesystem::path free_name(const std::filesystem::path& folder, const std::string& stem,
                                const std::string& ending);

/// "camera3" at a camera of the data set, else "view".
std::string camera_name(const Viewer& viewer);

}  // namespace qs
