// SPDX-License-Identifier: MIT
//
// The direction and the target that the cameras of a data set share: the world's up direction, and
// the point that they look at.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "app/framing/first_view.h"

namespace qs {

/// The axis that is perpendicular to the cameras' x axes in the sense of least squares, on the side
/// of the mean of their -y axes. If the x axes do not determine the axis (all parallel, or no axis
/// is perpendicular to them), the mean itself; if the mean vanishes too, `otherwise`.
glm::dvec3 cameras_up(const std::vector<Camera>& cameras, glm::dvec3 otherwise);

/// The point nearest to the cameras' optical axes in the sense of least squares. Empty if the axes
/// are nearly parallel, or if the point is in front of fewer than half of the cameras.
std::optional<glm::dvec3> cameras_target(const std::vector<Camera>& cameras);

/// A view from one of the cameras toward their common target: the camera that looks straightest at
/// it from about the usual distance. Without a common target: the view of the camera nearest to the
/// middle of all cameras. Empty without cameras, or if all look along `up`.
std::optional<Framing> framing_of(const std::vector<Camera>& cameras, glm::dvec3 up);

/// The view of the scene's subject: framing_of() its cameras, or else the result of choose(), which
/// finds a view from the Gaussians. `up` is the declared up direction; unset: cameras_up().
Framing subject_framing(const std::vector<Camera>& cameras, const std::optional<glm::dvec3>& up,
                        const std::function<Framing()>& choose);

}  // namespace qs
