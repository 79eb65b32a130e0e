// SPDX-License-Identifier: MIT
#include "learn/diff/gaussians.h"

#include <limits>

#include "base/fail.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::diff {

template <class Real>
void GaussianInputs<Real>::check(const char* who) const {
  const auto require = [who](bool holds, const char* what) {
    if (!holds) fail(ErrorKind::usage, "{}: {}", who, what);
  };
  require(count <= static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()),
          "there are more than 2^31 - 1 Gaussians");
  require(channel_count >= 1 && channel_count <= kMostChannels,
          "the number of channels must be 1 to 32");
  require(sh_degree >= 0 && sh_degree <= kMaxShDegree,
          "the degree of the coefficients of colour must be 0 to 3");
  if (count == 0) return;
  require(means && opacities, "means and opacities are missing");
  require(covariances ? !scales && !rotations : scales && rotations,
          "either covariances or both scales and rotations must be given");
  require(static_cast<bool>(sh) != static_cast<bool>(channels),
          "either coefficients of colour or channels must be given");
  require(!sh || sh_degree == 0 || sh.rest, "the coefficients of colour beyond DC are missing");
  require(!sh || channel_count == 3, "coefficients of colour give 3 channels");
}

template <class Real>
void GaussianInputs<Real>::check_frame(const char* who, std::size_t of_frame) const {
  if (of_frame == count) return;
  fail(ErrorKind::usage, "{}: the frame has {} Gaussians, the inputs have {}", who, of_frame,
       count);
}

template struct GaussianInputs<float>;
template struct GaussianInputs<double>;

}  // namespace qs::diff
