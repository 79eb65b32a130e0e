// SPDX-License-Identifier: MIT
//
// Learned masks (Compact 3D Gaussian Representation, Lee et al., CVPR 2024, arXiv 2311.13681, with
// the constants of its published code): adaptive density control, in which every Gaussian has a
// mask that is trained (kernel/gradient/mask.h). The mean mask has a share in the loss, so
// Gaussians that the photographs do not need are masked out, and removed at the next change. After
// densification they are removed every 1,000 iterations. A clone and the children of a split have
// the mask of their Gaussian.
#include "learn/run/field_model.h"
#include "learn/run/strategy.h"

namespace qs::train {
namespace {

constexpr double kMaskRate = 0.01, kMaskWeight = 5e-4;

}  // namespace

void mask_step(const IterationContext& context, StepOrder& order) {
  order.rates.mask = kMaskRate;
  order.mask_weight = kMaskWeight;
  order.field_rate = field_rate_at(context.iteration);
}

}  // namespace qs::train
