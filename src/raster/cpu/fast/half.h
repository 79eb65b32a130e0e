// SPDX-License-Identifier: MIT
//
// Conversion to half precision (IEEE binary16).
#pragma once

#include <cstddef>
#include <cstdint>

namespace qs::cpu::fast {

/// Converts `count` values, a multiple of 16. True if the halves equal all of them (zeros may
/// lose their sign); otherwise the halves must not be used.
bool to_halves(const float* values, std::size_t count, std::uint16_t* halves);

}  // namespace qs::cpu::fast
