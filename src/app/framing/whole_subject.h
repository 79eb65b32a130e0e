// SPDX-License-Identifier: MIT
//
// A turntable: the angles around the subject from which a camera has a free view of it, which are
// the sides that were photographed, and the framing that shows the whole subject from all of them.
#pragma once

#include <vector>

#include "app/framing/first_view.h"
#include "app/framing/scene_box.h"

namespace qs {

/// Angles around a framing's target, in radians. 0 is the framing's own eye; positive angles are to
/// its left.
struct Arc {
  double low = 0, high = 0;  ///< low <= 0 <= high
  bool whole() const;        ///< true if it is a full circle
};

/// `degrees` around the framing's eye; a full circle from 360.
Arc arc_of(double degrees);

/// The angles from which cameras saw the framing's target from about the framing's distance. A full
/// circle if they leave no gap of more than 90 degrees.
Arc seen_arc(const std::vector<Camera>& cameras, const Framing& framing);

/// The angles from which nothing near the eye hides the framing's target. For scenes without
/// cameras.
Arc open_arc(const GaussianCloud& cloud, const Framing& framing, ThreadPool& pool);

/// seen_arc() if there are cameras, else open_arc().
Arc free_arc(const std::vector<Camera>& cameras, const GaussianCloud& cloud, const Framing& framing,
             ThreadPool& pool);

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
