// SPDX-License-Identifier: MIT
//
// The derivatives that a backward pass computes beside the parameters'.
#pragma once

namespace qs::train {

struct BackwardOrder {
  /// Also sums the absolute values of each pixel's derivatives by a Gaussian's position on the
  /// image (AbsGS, Ye et al. 2024, arXiv 2404.10484). Parts of opposite signs do not cancel in
  /// these sums, so they show large Gaussians whose pixels want to move apart.
  bool absolute = false;
};

}  // namespace qs::train
