// SPDX-License-Identifier: MIT
//
// The distance from which a subject fills the picture, seen from a given direction.
#pragma once

#include "app/framing/first_view.h"
#include "app/framing/subject.h"

namespace qs {

/// The shape to which a view is fitted.
struct Shape {
  std::vector<glm::dvec3> corners;  ///< the corners of the subject's box
  std::vector<glm::dvec3> points;   ///< some hundred of its Gaussians
  std::vector<float> weights;       ///< the weights of the points
  glm::dvec3 center{0.0};
  double radius = 0;  ///< the radius of the sphere around the box, > 0
};

/// A box smaller than `smallest` gets this half side.
Shape shape_of(const Subject& subject, double smallest);

/// The view from `toward_eye`, a unit vector that is not parallel to `up`, with the shape's box in
/// the middle and 72 % as high as the picture, or less if much of the shape extends beyond the box.
Framing fit_view(const Shape& shape, glm::dvec3 toward_eye, glm::dvec3 up);

}  // namespace qs
