// SPDX-License-Identifier: MIT
// The constants of rendering, against the values of the papers and their published code.
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "raster/api/renderer.h"
#include "raster/kernel/constants.h"
#include "raster/scene/camera.h"

namespace qs {
namespace {

constexpr double kPi = std::numbers::pi;

struct Published {
  const char* name;
  double ours, published;
};

TEST(PublishedConstants, of_compositing_and_projection) {
  const RenderSettings settings;
  const std::vector<Published> rows = {
      {"alpha that is skipped", fp64::kAlphaMin, 1.0 / 255},
      {"alpha that is skipped, fp32", kAlphaMin, 1.0 / 255},
      {"largest alpha", fp64::kAlphaMax, 0.99},
      {"largest alpha, fp32", kAlphaMax, 0.99},
      {"transmittance that stops a pixel", fp64::kTransmittanceMin, 1e-4},
      {"transmittance that stops a pixel, fp32", kTransmittanceMin, 1e-4},
      {"dilation, px^2", kDilation, 0.3},
      {"dilation of a frame", settings.dilation, 0.3},
      {"margin of the field of view", kSlopeMargin, 1.3},
      {"standard deviations of the square", kSigmas, 3},
      {"floor of the eigenvalue's root", kEigenvalueFloor, 0.1},
      {"floor of the compensation, Mip-Splatting", kCompensationFloor, 2.5e-5},
      {"near plane", Camera().near_depth, 0.2},
      {"side of a tile, px", kTileSize, 16},
      {"side of a frame's tile", 1.0 * settings.tile_px, 16},
      {"SH degree", 1.0 * settings.sh_degree, 3},
      {"factor on standard deviations", settings.splat_scale, 1}};
  for (const Published& row : rows)
    EXPECT_NEAR(row.ours, row.published, 1e-6 * row.published) << row.name;
}

TEST(PublishedConstants, of_spherical_harmonics_have_their_closed_forms) {
  const std::vector<Published> rows = {
      {"0", kSh0, std::sqrt(1 / kPi) / 2},      {"1", kSh1, std::sqrt(3 / (4 * kPi))},
      {"2 A", kSh2A, std::sqrt(15 / kPi) / 2},  {"2 B", kSh2B, std::sqrt(5 / kPi) / 4},
      {"2 C", kSh2C, std::sqrt(15 / kPi) / 4},  {"3 A", kSh3A, std::sqrt(35 / (2 * kPi)) / 4},
      {"3 B", kSh3B, std::sqrt(105 / kPi) / 2}, {"3 C", kSh3C, std::sqrt(21 / (2 * kPi)) / 4},
      {"3 D", kSh3D, std::sqrt(7 / kPi) / 4},   {"3 E", kSh3E, std::sqrt(105 / kPi) / 4}};
  for (const Published& row : rows) EXPECT_NEAR(row.ours, row.published, 1e-14) << row.name;
}

}  // namespace
}  // namespace qs
