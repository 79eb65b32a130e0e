// SPDX-License-Identifier: MIT
//
// Finds the folder of the running program, so that an installed tree can be moved.
#pragma once

#include <filesystem>

namespace qs {

/// Folder of the executable; empty if the system does not report it.
std::filesystem::path program_folder();

}  // namespace qs
