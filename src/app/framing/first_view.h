// SPDX-License-Identifier: MIT
//
// The first view of a scene without cameras: a few dozen views of its subject are drawn at the size
// of a thumbnail, and the best one is taken. The choice depends on the cloud alone, not on threads
// or chance.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/framing/subject.h"
#include "base/parallel.h"
#include "raster/scene/camera.h"

namespace qs {

/// A view in world coordinates, for pictures of any size.
struct Framing {
  glm::dvec3 eye{0, 0, -1}, target{0.0}, up{0, -1, 0};
  double vertical_fov = 1;
  double aspect = 0;  ///< width / height from which on a picture shows the subject's whole width
  /// Farthest distance of the eye, for narrower pictures, as a factor on its distance.
  double farthest = 1;
  double near_depth = 0.2;
  bool upside_down = false;    ///< UpEstimate::upside_down, where `up` was only estimated
  bool up_is_assumed = false;  ///< `up` was neither given nor seen: UpEstimate::has_floor is false
};

/// The camera of a framing. Pictures narrower than `aspect` are taken from farther away, up to
/// `farthest`, and pictures higher than wide from still farther away, as far as they need.
Camera framed_camera(const Framing& framing, int width, int height);

inline constexpr std::size_t kMostCandidates = 4;  ///< the default of choose_framings()

/// The best view of a cloud: the opacity-weighted 5th to 95th percentile of the subject fills 45 to
/// 90 % of the picture's height, its centre is within 10 % of the picture's, and little is in front
/// of it. Rooms, streets and gardens are seen from inside. `up`: a unit vector; unset:
/// estimate_up() with -y as the convention.
Framing choose_framing(const GaussianCloud& cloud, const std::optional<glm::dvec3>& up,
                       ThreadPool& pool);

/// Views to choose from, at most `most` > 0 and at least one: the view of choose_framing(), then a
/// view from the other side, then other views by their quality. The directions of any two differ by
/// at least 30 degrees, and no eye but perhaps the first is inside a Gaussian.
std::vector<Framing> choose_framings(const GaussianCloud& cloud,
                                     const std::optional<glm::dvec3>& up, ThreadPool& pool,
                                     std::size_t most = kMostCandidates);

/// Chooses the views from a sample that was taken with Sampling's default of `most`.
std::vector<Framing> choose_framings(const CloudSample& sample, const std::optional<glm::dvec3>& up,
                                     ThreadPool& pool, std::size_t most = kMostCandidates);
/// The up axis that the user or else the file declares. `given` is the user's; unset: none.
std::optional<glm::dvec3> declared_up(const std::optional<glm::dvec3>& given,
                                      const std::string& vertical_axis);

// The direction and the target that the cameras of a data set share: the world's up direction, and
// the point that they look at.

/// The axis that is perpendicular to the cameras' x axes in the sense of least squares, on the side
/// of the mean of their -y axes. If the x axes do not determine the axis (all parallel, or no axis
/// is perpendicular to them), the mean itself; if the mean vanishes too, `otherwise`.
glm::dvec3 cameras_up(const std::vector<Camera>& cameras, glm::dvec3 otherwise);

/// The point nearest to the cameras' optical axes in the sense of least squares. Empty if the axes
/// are nearly parallel, or if the point is in front of fewer than half of the cameras.
std::optional<glm::dvec3> cameras_target(const std::vector<Camera>& cameras);

/// A view from one of the cameras toward their common target: the camera that looks straightest at
/// it from about the usual distance. Without a common target: the view of the camera nearest to the
/// middle of all cameras. outliers() do not count. Empty without cameras, or if all look along
/// `up`.
std::optional<Framing> framing_of(const std::vector<Camera>& cameras, glm::dvec3 up);

/// The view of the scene's subject: framing_of() its cameras, or else the result of choose(), which
/// finds a view from the Gaussians. `up` is the declared up direction; unset: cameras_up().
Framing subject_framing(const std::vector<Camera>& cameras, const std::optional<glm::dvec3>& up,
                        const std::function<Framing()>& choose);

}  // namespace qs
