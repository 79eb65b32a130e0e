// SPDX-License-Identifier: MIT
//
// A colour field in double precision, one Gaussian at a time: the reference of FieldEvaluator and
// of FieldGradient.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "raster/field/color_field.h"

namespace qs::test {

/// The features of a position in the world, levels * kGridFeatures values.
std::vector<double> grid_features(const ColorField& field, const glm::dvec3& mean);

/// The three outputs for grid_features() and a unit vector from the camera to the Gaussian. They
/// are SH coefficients of degree 0: the colour is max(0, kSh0 * output + 0.5).
glm::dvec3 network_output(const ColorField& field, const std::vector<double>& features,
                          const glm::dvec3& direction);

}  // namespace qs::test
