// SPDX-License-Identifier: MIT
#include "app/train/model_state.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "raster/kernel/activation.h"

namespace qs::train {
namespace {

void keep_rows(Parameters& parameters, const std::vector<std::uint32_t>& rows) {
  cpu::train::for_each_array(
      [&rows](std::size_t values, auto& array) {
        std::decay_t<decltype(array)> kept(rows.size() * values);
        for (std::size_t i = 0; i < rows.size(); ++i) {
          std::copy_n(array.begin() + static_cast<std::ptrdiff_t>(rows[i] * values), values,
                      kept.begin() + static_cast<std::ptrdiff_t>(i * values));
        }
        array = std::move(kept);
      },
      parameters);
}

void reserve_rows(Parameters& parameters, std::size_t rows) {
  cpu::train::for_each_array(
      [rows](std::size_t values, auto& array) { array.reserve(rows * values); }, parameters);
}

void append_rows(Parameters& parameters, const std::vector<std::uint32_t>& rows) {
  cpu::train::for_each_array(
      [&rows](std::size_t values, auto& array) {
        for (const std::uint32_t row : rows) {
          for (std::size_t k = 0; k < values; ++k) array.push_back(array[row * values + k]);
        }
      },
      parameters);
}

}  // namespace

ModelState ModelState::starting_with(Parameters parameters) {
  ModelState state;
  state.adam = cpu::train::AdamState::like(parameters);
  state.density.reset(parameters.size());
  state.parameters = std::move(parameters);
  return state;
}

bool ModelState::is_whole() const {
  bool whole = density.sums.size() == size() && density.views.size() == size();
  for (const Parameters* arrays : {&parameters, &adam.first, &adam.second}) {
    cpu::train::for_each_array(
        [&](std::size_t values, const auto& array) {
          whole = whole && array.size() == size() * values;
        },
        *arrays);
  }
  return whole;
}

void ModelState::keep(const std::vector<std::uint32_t>& rows) {
  keep_rows(parameters, rows);
  keep_rows(adam.first, rows);
  keep_rows(adam.second, rows);
  density.reset(size());
}

void ModelState::clear_moments(std::size_t i) {
  for (Parameters* moments : {&adam.first, &adam.second}) {
    cpu::train::for_each_array(
        [i](std::size_t values, auto& array) {
          using Value = typename std::decay_t<decltype(array)>::value_type;
          std::fill_n(array.begin() + static_cast<std::ptrdiff_t>(i * values), values, Value{});
        },
        *moments);
  }
}

void ModelState::duplicate(const std::vector<std::uint32_t>& rows) {
  for (Parameters* arrays : {&parameters, &adam.first, &adam.second})
    reserve_rows(*arrays, size() + rows.size());
  append_rows(parameters, rows);
  adam.first.resize(size());
  adam.second.resize(size());
  density.reset(size());
}

double opacity(const Parameters& parameters, std::size_t i) {
  return opacity_of(static_cast<double>(parameters.opacity_logits[i]));
}

double largest_scale(const Parameters& parameters, std::size_t i) {
  const glm::vec3& s = parameters.log_scales[i];
  return std::exp(static_cast<double>(std::max(s.x, std::max(s.y, s.z))));
}

}  // namespace qs::train
