// SPDX-License-Identifier: MIT
//
// Where the running program lies, so that an installed tree can be moved anywhere.
#pragma once

#include <filesystem>

namespace qs {

/// Folder of the executable; empty when the system does not tell.
std::filesystem::path program_folder();

}  // namespace qs
