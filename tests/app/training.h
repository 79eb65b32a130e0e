// SPDX-License-Identifier: MIT
//
// A synthetic data set for training tests: views of known Gaussians from a sphere around them.
#pragma once

#include <string>

#include "app/train/data_set.h"
#include "raster/cpu/train/parameters.h"

namespace qs::test {

/// `count` opaque and transparent Gaussians of one colour each in a ball of radius 1.
cpu::train::Parameters<float> ball_of_gaussians(std::size_t count, unsigned seed);

/// The same with noise in every parameter.
cpu::train::Parameters<float> perturbed(cpu::train::Parameters<float> scene, unsigned seed);

/// `count` cameras of 64 x 48 pixels on a sphere of radius 3.5 that look at its middle; names are
/// "view00", "view01", ...
std::vector<Camera> sphere_cameras(int count);

/// The scene's pictures, rounded to 8 bits. Every fourth view is a test view.
train::DataSet data_set_of(const cpu::train::Parameters<float>& scene, int views);

/// The same as a folder with cameras.json and images/view00.png, ...
void write_data_set(const train::DataSet& data, const std::filesystem::path& folder);

}  // namespace qs::test
