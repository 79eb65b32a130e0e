// SPDX-License-Identifier: MIT
//
// Formats an inspection as text and as JSON.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "app/inspect/inspection.h"

namespace qs {

struct InspectedFact {
  std::string label, value;
};

/// The picked Gaussian's numbers with their units.
std::vector<InspectedFact> gaussian_facts(const GaussianReport& gaussian);

/// "12 tiles, 9 used, 2 hidden, 1 empty"
std::string mode_sentence(const PairUses& uses);

/// Tables of the pixel's Gaussians and of the picked Gaussian. UTF-8, ends with a newline.
std::string format_inspection(const Inspection& inspection);

/// Everything in full precision; lengths in pixels, angles in radians.
nlohmann::ordered_json inspection_json(const Inspection& inspection);

}  // namespace qs
