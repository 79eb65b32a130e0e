// SPDX-License-Identifier: MIT
//
// Memory in use, for the performance panel.
#pragma once

#include <cstdint>

namespace qs {

/// Resident bytes of this process; 0 if the system does not report them.
std::uint64_t process_bytes();

/// Bytes in use on a GPU by all programs; 0 if there is no such GPU.
std::uint64_t gpu_bytes(int device);

}  // namespace qs
