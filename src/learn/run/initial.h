// SPDX-License-Identifier: MIT
//
// The Gaussians that training starts from.
#pragma once

#include <vector>

#include "learn/run/data_set.h"
#include "learn/step/model_state.h"

namespace qs::train {

struct InitialGaussians {
  int sh_degree = kMaxShDegree;
  double opacity = 0.1;
  double scale = 1;  ///< factor on the size
};

/// A round Gaussian of the point's colour at every point, as large as the root of the mean squared
/// distance to the 3 nearest points, at least 1e-7 (Kerbl et al. 2023). `points` is not empty.
Parameters gaussians_at(const std::vector<ScenePoint>& points, const InitialGaussians& initial,
                        ThreadPool& pool);

/// The same Gaussians with masks, see kernel/gradient/mask.h.
Parameters with_masks(Parameters gaussians);

/// `count` gray points. They are uniform in the part of the cameras' bounding box, enlarged 3 times
/// around its middle, that many training pictures show: at least half as many as show the most
/// visible place. For Blender's data sets they are uniform in the cube from -1.3 to 1.3.
std::vector<ScenePoint> random_points(const DataSet& data, std::size_t count, std::uint64_t seed);

}  // namespace qs::train
