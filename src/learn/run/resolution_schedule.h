// SPDX-License-Identifier: MIT
//
// Training with reduced photographs at first: the factor falls as fast as the photographs' details
// allow (DashGaussian, Chen et al., CVPR 2025, and its published code).
#pragma once

#include <vector>

#include "base/parallel.h"
#include "learn/run/spectrum.h"

namespace qs::train {

/// The training views' frequencies: what the schedule is computed from. Photographs of different
/// sizes count equally.
class PhotographSpectra {
 public:
  void add(const Image& photograph, ThreadPool& pool);

  /// The largest factor, at most 8, with which every photograph keeps a quarter of its sum.
  double largest_scale() const { return largest_; }
  /// The mean spectrum of the photographs of every size, times their share of all photographs.
  std::vector<SpectrumSums> means() const;

 private:
  double largest_ = 8;
  std::size_t photographs_ = 0;
  std::vector<Spectrum> by_size_;  // sums over the photographs of a size
};

class ResolutionSchedule {
 public:
  /// Full size in every iteration.
  ResolutionSchedule() = default;

  /// Reduced until iteration `end`.
  ResolutionSchedule(const PhotographSpectra& spectra, int end);

  /// The factor that an iteration asks for, at least 1.
  int factor_at(int iteration) const;
  /// The factor that an iteration uses. As published, it is renewed when Gaussians may be added:
  /// after every 100th iteration from 600.
  int factor_in(int iteration) const;
  /// The iteration from which the rate of the means falls: about when the factor reaches 2.
  int details_from() const;

  const std::vector<double>& scales() const { return scales_; }
  const std::vector<int>& begins() const { return begins_; }

 private:
  std::vector<double> scales_ = {1};  // at `begins_`; 1 / scale^2 is linear in between
  std::vector<int> begins_ = {0};
};

}  // namespace qs::train
