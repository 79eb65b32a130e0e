// SPDX-License-Identifier: MIT
//
// A synthetic data set for training tests: views of known Gaussians from a sphere around them.
#pragma once

#include <string>

#include "learn/run/trainer.h"

namespace qs::test {

/// `count` opaque and transparent Gaussians of one colour each in a ball of radius 1.
train::Parameters ball_of_gaussians(std::size_t count, unsigned seed);

/// The same with noise in every parameter.
train::Parameters perturbed(train::Parameters scene, unsigned seed);

/// `count` cameras of 64 x 48 pixels on a sphere of radius 3.5 that look at its middle; names are
/// "view00", "view01", ...
std::vector<Camera> sphere_cameras(int count);

/// The scene's pictures, rounded to 8 bits. Every fourth view is a test view.
train::DataSet data_set_of(const train::Parameters& scene, int views);

/// The same as a folder with cameras.json and images/view00.png, ...
void write_data_set(const train::DataSet& data, const std::filesystem::path& folder);

/// Trains a model on a backend from a state, which gets masks if the strategy has them.
train::Trainer trainer_on(Backend backend, const train::TrainSettings& settings,
                          const train::DataSet& data, train::ModelState state, int threads = 0);

/// Expects that all values have the same bits.
void expect_same(const train::ModelState& a, const train::ModelState& b);

}  // namespace qs::test
