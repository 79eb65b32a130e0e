// SPDX-License-Identifier: MIT
//
// Detects scenes that are seen best from inside: a room, a street, a place among trees.
#pragma once

#include <optional>

#include "app/framing/candidate_views.h"

namespace qs {

/// The height, along the ground's up, of an eye inside the subject: above its floor, with its
/// border all around. Empty for objects, which have no such place.
std::optional<double> eye_height_inside(CandidateViews& views);

}  // namespace qs
