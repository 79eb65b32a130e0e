// SPDX-License-Identifier: MIT
//
// The numbers of the plot of the loss, apart from its drawing: the loss against the iteration, both
// from 0, with round ticks.
#pragma once

#include <vector>

#include "app/report/zoom_bundle.h"
#include "app/viewer/state/training.h"

namespace qs {

/// The loss has no unit: it is a mean over the pixels, of colours from 0 to 1.
inline constexpr const char* kLossTitle = "loss: 0.8 L1 + 0.2 (1 - SSIM), colours 0 to 1";
inline constexpr const char* kIterationTitle = "iteration";

struct LossChart {
  double most_iteration = 1, most_loss = 1;  ///< the ends of the axes, which begin at 0
  std::vector<AxisTick> iteration_ticks, loss_ticks;
};

LossChart loss_chart(const std::vector<LossPoint>& losses);

/// The loss whose iteration is nearest to `iteration`. `losses` must not be empty.
const LossPoint& loss_near(const std::vector<LossPoint>& losses, double iteration);

}  // namespace qs
