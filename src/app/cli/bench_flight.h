// SPDX-License-Identifier: MIT
//
// bench --flight: frames along a camera path in real time, as the window draws them: at most 60 a
// second, with the cut of levels of detail that is ready. bench itself measures views at rest.
#pragma once

#include <filesystem>
#include <optional>

#include "app/session/session.h"

namespace qs {

inline constexpr const char* kFlightFiles[] = {"flight.json", "flight.md"};

/// Flies along a path file at its own speed, ten times as fast, and in jumps, and prints a table;
/// writes kFlightFiles into `out_dir`. Each flight opens the scene again, so that none of its pages
/// is in memory. Throws Error and Cancelled.
void bench_flight(const FrameOptions& frame, const std::filesystem::path& path,
                  const std::optional<std::filesystem::path>& out_dir);

}  // namespace qs
