// SPDX-License-Identifier: MIT
#include "app/framing/ground.h"

#include <algorithm>

#include <glm/trigonometric.hpp>

namespace qs {
namespace {

Extent extent_along(const Subject& subject, glm::dvec3 direction, std::size_t every) {
  std::vector<double> values;
  std::vector<float> weights;
  for (std::size_t i = 0; i < subject.positions.size(); i += every) {
    values.push_back(glm::dot(direction, glm::dvec3(subject.positions[i])));
    weights.push_back(subject.weights[i]);
  }
  const Quantiles quantiles(values, weights);
  return {quantiles.at(0.05), quantiles.at(0.95)};
}

}  // namespace

Ground::Ground(const Subject& subject, glm::dvec3 upward) : up(upward) {
  constexpr int kStep = 5, kMost = 45;  // degrees
  constexpr double kSmaller = 0.9;
  constexpr std::size_t kMostExamined = 2000;
  const glm::dvec3 usual = std::abs(up.z) < 0.8 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  const glm::dvec3 straight = glm::normalize(usual - glm::dot(usual, up) * up);
  const glm::dvec3 across = glm::cross(straight, up);
  const auto turn = [&](int degrees) {
    const double angle = glm::radians(static_cast<double>(degrees));
    forward = std::cos(angle) * straight + std::sin(angle) * across;
    right = glm::cross(forward, up);
  };
  const auto area = [&](int degrees) {
    turn(degrees);
    const std::size_t every = 1 + subject.positions.size() / kMostExamined;
    return extent_along(subject, forward, every).size() *
           extent_along(subject, right, every).size();
  };
  int best = 0;
  double least = kSmaller * area(0);
  for (int degrees = -kMost; degrees < kMost; degrees += kStep) {
    const double here = area(degrees);
    if (here < least) least = here, best = degrees;
  }
  turn(best);
  height = extent_along(subject, up, 1);
  ahead = extent_along(subject, forward, 1);
  aside = extent_along(subject, right, 1);
}

}  // namespace qs
