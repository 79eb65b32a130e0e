// SPDX-License-Identifier: MIT
//
// The values that depend on the iteration, which counts from 1: learning rates, the SH degree and
// the view (Kerbl et al. 2023 and the defaults of its published code).
#pragma once

#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "learn/gradient/adam.h"
#include "learn/run/spectrum.h"

namespace qs::train {

/// The beginning of the rate of the means.
struct MeanRateStart {
  int falls_from = 0;        ///< the iteration
  bool moves_before = true;  ///< false: the rate is 0 before
};

/// The rate of the means falls from 1.6e-4 to 1.6e-6 times `extent` until iteration 30,000,
/// independent of the number of iterations that are run. `opacity_rate` is the strategy's.
Rates rates_at(int iteration, double extent, double opacity_rate, MeanRateStart start = {});

/// Starts at 0 and grows by 1 every 1,000 iterations, up to `most`.
int sh_degree_at(int iteration, int most);

/// All views in random order, then all views again in another order, and so on.
class ViewOrder {
 public:
  ViewOrder(std::size_t views, std::uint64_t seed) : views_(views), seed_(seed) {}

  std::size_t at(int iteration);

 private:
  std::size_t views_;
  std::uint64_t seed_;
  std::uint64_t round_ = ~std::uint64_t{0};
  std::vector<std::size_t> order_;  // the order in round_
};

/// `count` different ones of `views` training views, in random order; all of them if there are
/// fewer. They depend on seed and iteration only.
std::vector<std::size_t> drawn_views(std::size_t views, std::size_t count, std::uint64_t seed,
                                     int iteration);

// Training with reduced photographs at first: the factor falls as fast as the photographs' details
// allow (DashGaussian, Chen et al., CVPR 2025, and its published code).

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
