// SPDX-License-Identifier: MIT
//
// The framing of a turntable: it shows the whole subject from every angle.
#pragma once

#include "app/framing/free_arc.h"
#include "app/framing/scene_box.h"

namespace qs {

/// The box of the scene's subject: the weighted 5th to 95th percentile of its Gaussians.
SceneBox subject_box(const GaussianCloud& cloud);

/// The share of the picture's width and height that a turntable's subject fills at most.
inline constexpr double kWholeShare = 0.9;

/// `framing` turned to the middle of `box`, such that the corners of the box stay in the middle
/// kWholeShare of a picture of `aspect` (width / height) while the eye turns around it through
/// `arc`. The field of view widens up to 75 degrees before the eye moves away, because the eye's
/// distance is one from which the scene was seen. An eye inside the box, as in a room, stays as it
/// is.
Framing whole_subject(const Framing& framing, const SceneBox& box, const Arc& arc, double aspect);

/// True if a Gaussian has an alpha above 0.1 at the point, so that an eye there sees its fog.
bool is_in_fog(const GaussianCloud& cloud, glm::dvec3 point);

/// The part of `arc` around angle 0 in which the eye of `framing` is not in fog, in steps of 2.5
/// degrees. An eye that is in fog at angle 0 keeps the arc.
Arc clear_arc(const Arc& arc, const Framing& framing, const GaussianCloud& cloud);

}  // namespace qs
