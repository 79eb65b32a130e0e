// SPDX-License-Identifier: MIT
//
// The angles around the subject from which a camera has a free view of it: the sides that were
// photographed.
#pragma once

#include <vector>

#include "app/framing/first_view.h"

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

}  // namespace qs
