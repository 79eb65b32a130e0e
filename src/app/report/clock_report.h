// SPDX-License-Identifier: MIT
//
// The clock of the GPU in reports, as "gpu_clock" of the environment:
//   {"text": "NVIDIA H200: SM clock 1,980 MHz, not throttled", "readings": 31,
//    "sm_mhz": {"median": 1980.0, "min": 1980.0, "max": 1980.0}, "sm_mhz_max": 1980.0,
//    "throttled": [], "warning": "", "celsius": {...}, "watts": {...}}
// Unknown values are null, and so is the object without any reading. A merged report has a list of
// the parts' values. Reports of the CPU backend have no "gpu_clock".
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/session/session.h"
#include "raster/clock/gpu_clock.h"

namespace qs {

/// A clock for measurements with this session; without sensors on the CPU backend.
GpuClock clock_of(const Session& session);

/// Adds "gpu_clock" to an environment_json() of the CUDA backend.
void add_clock(nlohmann::ordered_json& environment, const GpuClock& clock);

/// One line per GPU and one per warning, without duplicates; empty without "gpu_clock".
std::vector<std::string> clock_lines(const nlohmann::ordered_json& environment);

/// Sets the "gpu_clock" of a merged report from the environments of its parts.
void merge_clocks(const std::vector<nlohmann::ordered_json>& parts,
                  nlohmann::ordered_json& environment);

}  // namespace qs
