// SPDX-License-Identifier: MIT
//
// Whether a scene is seen best from inside: a room, a street, a place among trees.
#pragma once

#include <optional>

#include "app/framing/candidate_views.h"

namespace qs {

/// The height, along the ground's up, of an eye that what is at the subject's border surrounds,
/// over a floor. Empty for objects.
std::optional<double> eye_height_inside(const GaussianCloud& sample, const Ground& ground,
                                        CandidateViews& views);

}  // namespace qs
