// SPDX-License-Identifier: MIT
//
// Models whose colours a colour field computes (Compact-3DGS): where their training starts, and
// what files and windows get of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/parallel.h"
#include "learn/step/model_state.h"
#include "raster/field/color_field.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs::train {

/// Values of the grid are uniform in -1e-4..1e-4, weights in +-sqrt(6 / (rows + columns)) of their
/// matrix, as in the published models. They depend on the seed only.
FieldState starting_field(std::uint64_t seed, const GridShape& grid = {}, int width = 64);

/// The learning rate of all values of the field: from 1e-4 in iteration 1 to 0.01 in iteration 101,
/// then a third (0.33) of it after 5,000, 15,000 and 25,000 iterations each.
double field_rate_at(int iteration);

/// Codes of scales and rotations are trained after this iteration.
inline constexpr int kCodesAfter = 29'000;

/// Codes drawn from the shapes of the Gaussians.
ShapeCodes first_codes(const ModelState& model, std::uint64_t seed, ThreadPool& pool);

/// The Gaussians with spherical harmonics of degree 3 that are fitted to the field.
GaussianCloud fitted_cloud(const ModelState& model, bool antialiased, ThreadPool& pool);

/// Writes point_cloud.ply and .pth as published final models: opacities, scales and rotations as
/// renderers use them. Gaussians that are masked out are left out. Throws Error(input).
void write_field_model(const ModelState& model, const std::filesystem::path& path,
                       ThreadPool& pool);

/// Writes point_cloud.npz and point_cloud_pp.npz beside `path`, the .ply of the same model. Codes
/// of scales and rotations that were not trained are fitted to this model. Throws Error(input).
void write_coded_models(const ModelState& model, std::uint64_t seed,
                        const std::filesystem::path& path, ThreadPool& pool);

/// The paths of all forms of a model beside its .ply.
std::vector<std::filesystem::path> other_forms(const std::filesystem::path& path);

}  // namespace qs::train
