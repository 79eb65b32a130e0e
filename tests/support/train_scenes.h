// SPDX-License-Identifier: MIT
//
// A small scene to train, the same in both precisions, and its parameters as arrays of numbers.
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "learn/step/cpu/parameters.h"
#include "learn/step/training_model.h"

namespace qs::test {

using cpu::train::Parameters;

inline constexpr int kWidth = 45, kHeight = 35;  // tiles at the border are cut

/// Gaussians of a few pixels each in front of front_camera(), with some beyond the edges.
template <class Real>
Parameters<Real> small_scene(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Parameters<Real> scene;
  scene.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double z = uniform(2, 5);
    scene.means[i] = glm::dvec3(uniform(-0.65, 0.65) * z, uniform(-0.5, 0.5) * z, z);
    scene.log_scales[i] = glm::dvec3(uniform(-2.5, -1), uniform(-2.5, -1), uniform(-2.5, -1));
    scene.rotations[i] =
        glm::qua<Real>(glm::dquat(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
    scene.opacity_logits[i] = static_cast<Real>(uniform(-2, 2));
    for (std::size_t k = 0; k < scene.sh_stride(); ++k) {
      const double size = k == 0 ? 1.5 : 0.3;
      scene.sh[i * scene.sh_stride() + k] =
          glm::dvec3(uniform(-size, size), uniform(-size, size), uniform(-size, size));
    }
  }
  return scene;
}

/// The scene with masks, of which every seventh masks its Gaussian out.
template <class Real>
Parameters<Real> with_masks(Parameters<Real> scene) {
  scene.has_masks = true;
  scene.resize(scene.size());
  for (std::size_t i = 0; i < scene.size(); ++i)
    scene.mask_logits[i] = i % 7 == 3 ? Real(-5) : Real(2) - static_cast<Real>(i % 5);
  return scene;
}

template <class Real>
std::vector<glm::vec<3, Real>> pixel_weights(int width = kWidth, int height = kHeight) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<glm::vec<3, Real>> weights(static_cast<std::size_t>(width * height));
  for (auto& weight : weights)
    weight = glm::dvec3(uniform(random), uniform(random), uniform(random));
  return weights;
}

inline RenderSettings settings_of(CullMode mode, bool antialiased) {
  RenderSettings settings;
  settings.mode = mode;
  settings.antialiased = antialiased;
  settings.background = {0.2f, 0.5f, 0.9f};
  return settings;
}

/// Calls visit(value pointer) for every group of parameters: name, values per Gaussian, first
/// value.
template <class Scene, class Visit>
void for_each_group(Scene& scene, const Visit& visit) {
  const auto first = [](auto& vectors) { return vectors.empty() ? nullptr : &vectors[0][0]; };
  visit("mean", std::size_t{3}, first(scene.means));
  visit("log scale", std::size_t{3}, first(scene.log_scales));
  visit("rotation", std::size_t{4}, first(scene.rotations));
  visit("opacity", std::size_t{1}, scene.opacity_logits.data());
  visit("sh", 3 * scene.sh_stride(), first(scene.sh));
  if (scene.has_masks) visit("mask", std::size_t{1}, scene.mask_logits.data());
}

template <class Real>
std::vector<std::vector<Real>> groups_of(const Parameters<Real>& scene) {
  std::vector<std::vector<Real>> groups;
  for_each_group(scene, [&](const char*, std::size_t values, const Real* first) {
    groups.emplace_back(first, first + values * scene.size());
  });
  return groups;
}

/// Replaces the model by a scene that was never trained.
inline void start(train::TrainingModel& model, Parameters<float> scene) {
  model.set_state(train::ModelState::starting_with(std::move(scene)));
}

/// Adam's step, with the view in the density statistics.
inline train::StepOrder counted_step(const Rates& rates) {
  train::StepOrder order;
  order.rates = rates;
  order.counts_density = true;
  return order;
}

}  // namespace qs::test
