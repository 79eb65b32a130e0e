// SPDX-License-Identifier: MIT
//
// Folders that tests use. One small file knows where the source tree is, so that a compiler cache has
// the objects of all others for every clone.
#pragma once

#include <filesystem>
#include <string>

namespace qs::test {

/// A path inside the source tree.
std::filesystem::path source_path(const std::string& relative);

/// The folder of data outside of the repository, which need not exist.
std::filesystem::path shared_folder();

/// The program quadsplat of the build to which the running test program belongs.
std::string quadsplat_program();

}  // namespace qs::test
