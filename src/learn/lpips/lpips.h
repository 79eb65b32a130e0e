// SPDX-License-Identifier: MIT
//
// LPIPS, the distance of two pictures in the features of a network that was trained on photographs
// (Zhang et al. 2018, "The Unreasonable Effectiveness of Deep Features as a Perceptual Metric").
// The pictures pass through the network in bands of rows, and each layer keeps only the rows that
// the next one still needs. So memory grows with the pictures' width, not with their height, and no
// value is computed twice.
#pragma once

#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "learn/lpips/network.h"
#include "raster/scene/image.h"

namespace qs::lpips {

/// The weights of a network and of LPIPS's linear layers.
struct Weights {
  const Network* network = nullptr;
  /// One entry per convolution: (outputs, inputs, size, size) and (outputs).
  std::vector<std::vector<float>> filters, biases;
  /// One entry per compared convolution: (outputs).
  std::vector<std::vector<float>> linear;
};

/// The input of the network. Papers on Gaussian Splatting follow the published scripts of 3DGS,
/// which pass values of 0..1 to a network that was trained on -1..1.
enum class InputRange { unit, symmetric };

/// Side of the smallest square picture that the network takes, pixels.
int smallest_side(const Network& network);

/// The filters of a convolution as convolve.h reads them: (outputs / kBlock, size, size, inputs,
/// kBlock) from (outputs, inputs, size, size).
std::vector<float> pack(const Convolution& convolution, const std::vector<float>& filters);

/// LPIPS on the CPU.
class Metric {
 public:
  /// The vectors of `weights` have the sizes of their network.
  explicit Metric(const Weights& weights);

  const Network& network() const { return *network_; }

  /// The distance; 0 if the images are equal. Both have three channels, values of 0..1, the same
  /// size, and sides of smallest_side() at least. The result does not depend on the number of
  /// threads. Throws Cancelled.
  double distance(const Image& a, const Image& b, InputRange range, ThreadPool& pool,
                  const Progress& progress = {}) const;

 private:
  const Network* network_;
  std::vector<std::vector<float>> filters_;  // as pack() returns them
  std::vector<std::vector<float>> biases_, linear_;
};

}  // namespace qs::lpips
