// SPDX-License-Identifier: MIT
//
// An inspection for people and for programs.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "app/inspect/inspection.h"

namespace qs {

struct InspectedFact {
  std::string label, value;
};

/// The picked Gaussian's numbers with their units, in an order for reading.
std::vector<InspectedFact> gaussian_facts(const GaussianReport& gaussian);

/// "quadbox: 12 tiles, 9 used, 2 hidden, 1 empty" without the name.
std::string mode_sentence(const PairUses& uses);

/// Tables of the pixel's Gaussians and of the picked one. UTF-8, ends with a line's end.
std::string format_inspection(const Inspection& inspection);

/// Everything, in full precision; pixel coordinates, radians.
nlohmann::ordered_json inspection_json(const Inspection& inspection);

}  // namespace qs
