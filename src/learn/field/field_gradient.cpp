// SPDX-License-Identifier: MIT
#include "learn/field/field_gradient.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "learn/gradient/color_field.h"

namespace qs {
namespace {

constexpr std::size_t kUsedOutputs = 3;

// Adds weight x value to every element of y; the compiler makes vectors of it.
template <class Real>
void add_multiple(Real value, const Real* x, std::size_t count, Real* y) {
  for (std::size_t k = 0; k < count; ++k) y[k] += value * x[k];
}

}  // namespace

// The values of one evaluation.
template <class Real>
struct FieldGradient<Real>::Pass {
  glm::vec<3, Real> position, direction;
  std::array<Real, kMostInputs> input;
  std::array<Real, kMostWidth> first, second;  ///< hidden layers, after ReLU
};

template <class Real>
FieldGradient<Real>::FieldGradient(const GridShape& shape, int width, std::span<const Real> grid,
                                   std::span<const Real> weights)
    : levels_(grid_levels(shape)),
      network_{shape.levels * kGridFeatures, width},
      grid_(grid),
      weights_(weights.begin(), weights.end()),
      columns_(weights.size()) {
  const auto inputs = static_cast<std::size_t>(network_.inputs());
  const auto rows = static_cast<std::size_t>(width);
  if (inputs > kMostInputs || rows > kMostWidth)
    throw std::length_error("the network of a colour field is too large to be trained");
  const auto turn = [&](std::size_t begin, std::size_t height, std::size_t length) {
    for (std::size_t row = 0; row < height; ++row)
      for (std::size_t k = 0; k < length; ++k)
        columns_[begin + k * height + row] = weights_[begin + row * length + k];
  };
  turn(0, rows, inputs);
  turn(network_.second(), rows, rows);
  turn(network_.third(), NetworkShape::kOutputs, rows);
}

template <class Real>
void FieldGradient<Real>::run(const glm::vec<3, Real>& mean, const glm::vec<3, Real>& eye,
                              Pass& pass) const {
  const auto inputs = static_cast<std::size_t>(network_.inputs());
  const auto width = static_cast<std::size_t>(network_.width);
  pass.position = contract(mean);
  pass.direction = glm::normalize(mean - eye);
  std::ranges::fill(pass.input, Real(1));
  std::size_t at = 0;
  for (const GridLevel& level : levels_) {
    std::array<Real, kGridFeatures> sums{};
    for_each_vertex(level, pass.position, [&](std::size_t entry, Real weight) {
      for (std::size_t k = 0; k < sums.size(); ++k)
        sums[k] += weight * grid_[entry * kGridFeatures + k];
    });
    for (const Real sum : sums) pass.input[at++] = sum;
  }
  encode_direction(pass.direction, &pass.input[at]);
  const auto layer = [&](const Real* columns, const Real* x, std::size_t count, Real* y) {
    std::fill(y, y + width, Real(0));
    for (std::size_t k = 0; k < count; ++k) add_multiple(x[k], columns + k * width, width, y);
    for (std::size_t row = 0; row < width; ++row) y[row] = std::max(y[row], Real(0));
  };
  layer(columns_.data(), pass.input.data(), inputs, pass.first.data());
  layer(columns_.data() + network_.second(), pass.first.data(), width, pass.second.data());
}

template <class Real>
glm::vec<3, Real> FieldGradient<Real>::output(const glm::vec<3, Real>& mean,
                                              const glm::vec<3, Real>& eye) const {
  Pass pass;
  run(mean, eye, pass);
  std::array<Real, NetworkShape::kOutputs> out{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(network_.width); ++k)
    add_multiple(pass.second[k], &columns_[network_.third() + k * out.size()], out.size(),
                 out.data());
  return {out[0], out[1], out[2]};
}

template <class Real>
glm::vec<3, Real> FieldGradient<Real>::add(const glm::vec<3, Real>& mean,
                                           const glm::vec<3, Real>& eye,
                                           const glm::vec<3, Real>& d_output, IntegerSums& grid,
                                           std::span<Real> weights) const {
  const auto inputs = static_cast<std::size_t>(network_.inputs());
  const auto width = static_cast<std::size_t>(network_.width);
  Pass pass;
  run(mean, eye, pass);
  // Through a matrix of rows: adds the derivatives by it, and by its input x.
  const auto through = [&](std::size_t begin, const Real* d, std::size_t rows, const Real* x,
                           std::size_t length, Real* d_x) {
    for (std::size_t row = 0; row < rows; ++row) {
      if (d[row] == 0) continue;
      const std::size_t first = begin + row * length;
      add_multiple(d[row], x, length, &weights[first]);
      add_multiple(d[row], &weights_[first], length, d_x);
    }
  };
  std::array<Real, kMostWidth> d_second{}, d_first{};
  std::array<Real, kMostInputs> d_input{};
  const std::array<Real, kUsedOutputs> d_out = {d_output.x, d_output.y, d_output.z};
  through(network_.third(), d_out.data(), d_out.size(), pass.second.data(), width, d_second.data());
  for (std::size_t k = 0; k < width; ++k)
    if (!(pass.second[k] > 0)) d_second[k] = 0;
  through(network_.second(), d_second.data(), width, pass.first.data(), width, d_first.data());
  for (std::size_t k = 0; k < width; ++k)
    if (!(pass.first[k] > 0)) d_first[k] = 0;
  through(0, d_first.data(), width, pass.input.data(), inputs, d_input.data());

  std::size_t at = 0;
  for (const GridLevel& level : levels_) {
    for_each_vertex(level, pass.position, [&](std::size_t entry, Real weight) {
      for (std::size_t k = 0; k < kGridFeatures; ++k)
        grid.add(entry * kGridFeatures + k, weight * d_input[at + k]);
    });
    at += kGridFeatures;
  }
  return direction_features_gradient(pass.direction, &d_input[at]);
}

template class FieldGradient<float>;
template class FieldGradient<double>;

}  // namespace qs
