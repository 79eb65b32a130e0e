// SPDX-License-Identifier: MIT
//
// The horizontal plane of a world, and a subject's extents in it.
#pragma once

#include <cmath>

#include <glm/geometric.hpp>

#include "app/framing/subject.h"

namespace qs {

struct Ground {
  /// Unit vectors. `forward` is the usual viewing direction: +z or, if that is vertical, +y. It is
  /// turned by up to 45 degrees if that makes the box below clearly smaller, as in a street.
  glm::dvec3 up, forward, right;
  /// The opacity-weighted 5th to 95th percentile of the subject in these axes.
  Extent height, ahead, aside;

  Ground(const Subject& subject, glm::dvec3 upward);

  /// A horizontal direction; azimuth 0 is `forward`.
  glm::dvec3 direction(double azimuth) const {
    return std::cos(azimuth) * forward + std::sin(azimuth) * right;
  }
  /// From -1 at one border of the subject to 1 at the other, along `right` and `forward`.
  glm::dvec2 place_of(glm::dvec3 position) const {
    return {aside.place_of(glm::dot(position, right)), ahead.place_of(glm::dot(position, forward))};
  }
  glm::dvec3 position_of(glm::dvec2 place, double at_height) const {
    return aside.value_at(place.x) * right + ahead.value_at(place.y) * forward + at_height * up;
  }
};

}  // namespace qs
