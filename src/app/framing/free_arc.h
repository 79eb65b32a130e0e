// SPDX-License-Identifier: MIT
//
// How far a camera can go round what a scene is of, before it sees a side that was not
// photographed.
#pragma once

#include <vector>

#include "app/framing/first_view.h"

namespace qs {

/// Angles round what a framing shows, in radians. 0 is the framing's own eye; positive angles are
/// to its left.
struct Arc {
  double low = 0, high = 0;  ///< low <= 0 <= high
  bool whole() const;        ///< all the way round
};

/// `degrees` around the framing's eye; all the way round from 360.
Arc arc_of(double degrees);

/// The angles from which cameras saw what the framing shows, from about as far away. All the way
/// round if they leave no gap of more than 90 degrees.
Arc seen_arc(const std::vector<Camera>& cameras, const Framing& framing);

/// The angles from which nothing near the eye hides what the framing shows. For scenes without
/// cameras.
Arc open_arc(const GaussianCloud& cloud, const Framing& framing, ThreadPool& pool);

/// seen_arc() if there are cameras, else open_arc().
Arc free_arc(const std::vector<Camera>& cameras, const GaussianCloud& cloud, const Framing& framing,
             ThreadPool& pool);

}  // namespace qs
