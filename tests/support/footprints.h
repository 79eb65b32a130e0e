// SPDX-License-Identifier: MIT
//
// Difficult footprints for property tests of the culling modes.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "raster/kernel/footprint.h"
#include "raster/kernel/tile_grid.h"

namespace qs::test {

/// An ellipse with standard deviations `major` >= `minor` in pixels and its major axis at `angle`
/// radians, dilated as in project(). `opacity` is in (1/255, 1].
Footprint make_footprint(glm::vec2 mean_px, double major, double minor, double angle,
                         double opacity);

struct FootprintKind {
  const char* name;
  Footprint (*draw)(std::mt19937& random, int width, int height);
};

/// round, needle (aspect to 3000:1), huge, tiny, off-screen, border (means and sides on tile
/// borders), faint.
const std::vector<FootprintKind>& footprint_kinds();

/// Alpha of the Gaussian at a pixel in fp32, as the backends compute it.
float alpha_at(const Footprint& footprint, float opacity, int x, int y);

/// The opacity that gives the footprint's gamma.
float opacity_of(const Footprint& footprint);

}  // namespace qs::test
