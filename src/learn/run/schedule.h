// SPDX-License-Identifier: MIT
//
// The values that depend on the iteration, which counts from 1: learning rates, the SH degree and
// the view (Kerbl et al. 2023 and the defaults of its published code).
#pragma once

#include <cstdint>
#include <vector>

#include "learn/gradient/adam.h"

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

}  // namespace qs::train
