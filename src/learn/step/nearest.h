// SPDX-License-Identifier: MIT
//
// Distances to the nearest neighbours, from which Gaussians get their first size.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "base/parallel.h"

namespace qs::train {

/// For every point the mean of the squared distances to its 3 nearest neighbours, or to all others
/// if there are fewer; 0 for a single point. A point with a coordinate that is not finite has NaN,
/// and is no neighbour of others.
std::vector<double> neighbour_distances2(const std::vector<glm::vec3>& points, ThreadPool& pool);

}  // namespace qs::train
