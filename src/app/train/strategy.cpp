// SPDX-License-Identifier: MIT
#include "app/train/strategy.h"

#include <algorithm>
#include <array>

#include "raster/base/fail.h"

namespace qs::train {
namespace {

constexpr std::array kStrategies = {
    Strategy{"adc", "adaptive density control, as published with 3DGS", 2.5e-2, 0.1, 1, 0,
             adc_prepare, adc_step},
    Strategy{"mcmc", "relocates nearly transparent Gaussians (3DGS as Markov Chain Monte Carlo)",
             5e-2, 0.5, 0.1, 1'000'000, mcmc_prepare, mcmc_step},
};

}  // namespace

void StepContext::take_step() const {
  cpu::train::take_step(model.parameters, gradients.by, rates, model.adam, pool);
}

std::span<const Strategy> strategies() { return kStrategies; }

const Strategy& find_strategy(std::string_view name) {
  const auto found = std::find_if(kStrategies.begin(), kStrategies.end(),
                                  [&](const Strategy& row) { return row.name == name; });
  if (found == kStrategies.end()) fail(ErrorKind::usage, "--strategy: '{}' is no strategy", name);
  return *found;
}

}  // namespace qs::train
