// SPDX-License-Identifier: MIT
//
// LPIPS, the distance of two pictures in the features of a network that was trained on photographs
// (Zhang et al. 2018, "The Unreasonable Effectiveness of Deep Features as a Perceptual Metric").
// The pictures pass through the network in bands of rows, and each layer keeps only the rows that
// the next one still needs. So memory grows with the pictures' width, not with their height, and no
// value is computed twice.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "base/parallel.h"
#include "base/progress.h"
#include "raster/scene/image.h"

namespace qs::lpips {

/// A convolution with the ReLU behind it.
struct Convolution {
  int number;           ///< N of the tensors features.N.weight and features.N.bias
  int inputs, outputs;  ///< channels; outputs are a multiple of 32
  int size;             ///< side of the filter, pixels
  int stride, padding;  ///< pixels
  bool pooled_before;   ///< a maximum pool lies between the convolution before and this one
  bool compared;        ///< LPIPS compares the values behind the ReLU

  /// Side of the output for an input of `side` pixels; not positive: the input is too small.
  constexpr int side_of(int side) const { return (side + 2 * padding - size) / stride + 1; }
};

/// Pools take the maximum of `pool_size` x `pool_size` values at every second pixel.
inline constexpr int kPoolStride = 2;

struct Network {
  std::string_view name;  ///< as in the metadata `network` of a file of weights
  int pool_size;
  std::span<const Convolution> convolutions;
};

// The convolutional networks as tables: VGG16 (Simonyan and Zisserman 2015) and AlexNet (Krizhevsky
// 2014) with the numbers that torchvision gives the layers. A new network is a table and a row of
// kNetworks.
inline constexpr std::array<Convolution, 13> kVgg16 = {{{0, 3, 64, 3, 1, 1, false, false},
                                                        {2, 64, 64, 3, 1, 1, false, true},
                                                        {5, 64, 128, 3, 1, 1, true, false},
                                                        {7, 128, 128, 3, 1, 1, false, true},
                                                        {10, 128, 256, 3, 1, 1, true, false},
                                                        {12, 256, 256, 3, 1, 1, false, false},
                                                        {14, 256, 256, 3, 1, 1, false, true},
                                                        {17, 256, 512, 3, 1, 1, true, false},
                                                        {19, 512, 512, 3, 1, 1, false, false},
                                                        {21, 512, 512, 3, 1, 1, false, true},
                                                        {24, 512, 512, 3, 1, 1, true, false},
                                                        {26, 512, 512, 3, 1, 1, false, false},
                                                        {28, 512, 512, 3, 1, 1, false, true}}};

inline constexpr std::array<Convolution, 5> kAlexNet = {{{0, 3, 64, 11, 4, 2, false, true},
                                                         {3, 64, 192, 5, 1, 2, true, true},
                                                         {6, 192, 384, 3, 1, 1, true, true},
                                                         {8, 384, 256, 3, 1, 1, false, true},
                                                         {10, 256, 256, 3, 1, 1, false, true}}};

inline constexpr std::array<Network, 2> kNetworks = {
    {{"vgg16", 2, kVgg16}, {"alexnet", 3, kAlexNet}}};

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

  const Network& network() const { return *packed_.network; }

  /// The distance; 0 if the images are equal. Both have three channels, values of 0..1, the same
  /// size, and sides of smallest_side() at least. The result does not depend on the number of
  /// threads. Throws Cancelled.
  double distance(const Image& a, const Image& b, InputRange range, ThreadPool& pool,
                  const Progress& progress = {}) const;

 private:
  Weights packed_;  // filters as pack() returns them
};

}  // namespace qs::lpips
