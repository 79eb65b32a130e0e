// SPDX-License-Identifier: MIT
//
// The clock of the GPU in the environment of reports:
//   "gpu_clock": {"readings": 31, "sm_mhz": {"median": 1980.0, "min": 1980.0, "max": 1980.0},
//                 "sm_mhz_max": 1980.0, "throttled": [], "celsius": {...}, "watts": {...}},
//   "gpu_clock_text": ["NVIDIA H200: SM clock 1,980 MHz, not throttled"]
// Unknown values are null, and so is "gpu_clock" without any reading. A warning is a second line of
// the text. A merged report has a list of the parts' values of "gpu_clock", and every line of their
// texts once. Reports of the CPU backend have neither.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/session/session.h"
#include "raster/clock/gpu_clock.h"

namespace qs {

/// A clock for measurements with this session; without sensors on the CPU backend.
GpuClock clock_of(const Session& session);

/// Adds both members to an environment_json() of the CUDA backend.
void add_clock(nlohmann::ordered_json& environment, const GpuClock& clock);

/// The lines of "gpu_clock_text"; empty without it.
std::vector<std::string> clock_lines(const nlohmann::ordered_json& environment);

/// Sets both members of a merged report from the environments of its parts.
void merge_clocks(const std::vector<nlohmann::ordered_json>& parts,
                  nlohmann::ordered_json& environment);

}  // namespace qs
