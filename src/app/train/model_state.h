// SPDX-License-Identifier: MIT
//
// Everything that training changes. A checkpoint holds exactly this.
#pragma once

#include <cstdint>
#include <vector>

#include "raster/cpu/train/adam.h"
#include "raster/cpu/train/density.h"
#include "raster/cpu/train/parameters.h"

namespace qs::train {

using Parameters = cpu::train::Parameters<float>;
using Gradients = cpu::train::Gradients<float>;

struct ModelState {
  int iteration = 0;  ///< of the last step; 0: none was taken
  Parameters parameters;
  cpu::train::AdamState adam;
  cpu::train::DensityStatistics density;

  static ModelState starting_with(Parameters parameters);

  std::size_t size() const { return parameters.size(); }

  /// Whether all arrays have the same Gaussians: not if memory ran out while the set changed.
  bool is_whole() const;

  /// Keeps the Gaussians `rows`, in this order, with their moments. Resets the statistics.
  void keep(const std::vector<std::uint32_t>& rows);

  /// Sets Adam's moments of Gaussian i to 0.
  void clear_moments(std::size_t i);

  /// Adds copies of the Gaussians `rows` with zero moments. Resets the statistics.
  void duplicate(const std::vector<std::uint32_t>& rows);
};

/// Opacity and largest standard deviation of Gaussian i.
double opacity(const Parameters& parameters, std::size_t i);
double largest_scale(const Parameters& parameters, std::size_t i);

}  // namespace qs::train
