// SPDX-License-Identifier: MIT
//
// Selects Gaussians by their own values, without a picture. Values that are not numbers are never
// selected.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "raster/scene/gaussian_cloud.h"
#include "raster/scene/gaussian_set.h"

namespace qs {

/// A closed range of values.
struct ValueRange {
  double low = 0, high = 0;
  bool contains(double value) const { return low <= value && value <= high; }
  bool operator==(const ValueRange&) const = default;
};

/// By opacity, 0..1.
GaussianSet gaussians_of_opacity(const GaussianCloud& cloud, ValueRange range, ThreadPool& pool);
/// By the longest standard deviation, world units.
GaussianSet gaussians_of_size(const GaussianCloud& cloud, ValueRange range, ThreadPool& pool);
/// By the distance of their centres, world units: to a point, or with a normal, which is not 0, to
/// the plane through the point, negative behind it. The point counts as the cloud's positions do.
GaussianSet gaussians_at_distance(const GaussianCloud& cloud, glm::dvec3 point,
                                  std::optional<glm::dvec3> normal, ValueRange range,
                                  ThreadPool& pool);

/// The base colour of a Gaussian, without its view-dependent part: in sRGB, where values can be
/// outside of 0..1, and in CIELAB of D65.
glm::dvec3 base_srgb(const GaussianCloud& cloud, std::size_t i);
glm::dvec3 base_lab(const GaussianCloud& cloud, std::size_t i);
/// A colour in sRGB 0..1 in CIELAB of D65 (CIE 15, IEC 61966-2-1); values outside are clamped.
glm::dvec3 lab_of(glm::dvec3 srgb);
/// By the distance of the base colour from a colour in sRGB 0..1, in CIELAB (CIE 1976).
GaussianSet gaussians_of_color(const GaussianCloud& cloud, glm::dvec3 color, double tolerance,
                               ThreadPool& pool);

// By neighbourhood: the cells of a CellGrid around the Gaussians of `among`. A cell is a neighbour
// of the 26 cells around it. Sets are parts of `among`.

/// Adds the Gaussians in the cells and neighbour cells of the set, `steps` times.
GaussianSet grown(const GaussianCloud& cloud, const GaussianSet& set, const GaussianSet& among,
                  int steps, ThreadPool& pool);
/// Takes away the Gaussians in the cells and neighbour cells of others of `among`, `steps` times.
GaussianSet shrunk(const GaussianCloud& cloud, const GaussianSet& set, const GaussianSet& among,
                   int steps, ThreadPool& pool);
/// Grows until nothing is added, through Gaussians with base colours within `tolerance` of the
/// set's mean in CIELAB.
GaussianSet flooded(const GaussianCloud& cloud, const GaussianSet& set, const GaussianSet& among,
                    double tolerance, ThreadPool& pool);

}  // namespace qs
