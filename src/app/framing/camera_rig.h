// SPDX-License-Identifier: MIT
//
// What the cameras of a data set have in common: their up direction and what they look at.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "app/framing/first_view.h"

namespace qs {

/// The axis that is perpendicular to the cameras' x axes in the sense of least squares, on the side
/// of the mean of their -y axes. That mean where the x axes do not determine it (all parallel, or
/// no axis is perpendicular to them); `otherwise` where the mean vanishes too.
glm::dvec3 cameras_up(const std::vector<Camera>& cameras, glm::dvec3 otherwise);

/// The point nearest to the cameras' optical axes in the sense of least squares. Empty if the axes
/// are nearly parallel, or if fewer than half of the cameras have it in front of them.
std::optional<glm::dvec3> cameras_target(const std::vector<Camera>& cameras);

/// What the cameras of a data set look at, from the place of one of them; without a common target
/// what the camera in their middle sees. Empty without cameras, or if all look along `up`.
std::optional<Framing> framing_of(const std::vector<Camera>& cameras, glm::dvec3 up);

/// What a scene is of: framing_of() its cameras, or else what choose() finds in its Gaussians. `up`
/// is the declared up direction, if there is one; else the cameras tell it.
Framing subject_framing(const std::vector<Camera>& cameras, const std::optional<glm::dvec3>& up,
                        const std::function<Framing()>& choose);

}  // namespace qs
