// SPDX-License-Identifier: MIT
//
// Motion that takes time: flying with keys, and travelling to another view.
#pragma once

#include "app/viewer/state/action.h"

namespace qs {

/// The speed of flying, world units per second. It is proportional to the distance of the scene in
/// front, times the factor that the wheel sets.
double flying_speed(const Viewer& viewer);

namespace action {

/// Flies until the next turn. `direction`: right, down, forward, each -1..1; `factor` multiplies
/// the speed. The camera accelerates, and slows down when fly() is no longer called.
void fly(Viewer& viewer, glm::dvec3 direction, double factor);

/// The wheel: nearer or farther in orbit mode, faster or slower in fly mode.
void turn_wheel(Viewer& viewer, double notches);

/// Moves to a view of any size within a moment, or immediately if moves are not animated.
/// `dataset_camera`: the index of the camera of the data set with this view, else -1.
void travel_to(Viewer& viewer, const Camera& camera, int dataset_camera = -1);

/// Ends a travel immediately.
void arrive(Viewer& viewer);

/// Advances flight or travel by `seconds`.
void advance_motion(Viewer& viewer, double seconds);

}  // namespace action
}  // namespace qs
