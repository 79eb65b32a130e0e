// SPDX-License-Identifier: MIT
//
// A seeded city of any number of Gaussians, to measure levels of detail: facades with windows,
// wires of 0.02 units, leaves, ground, and a sky shell. A unit is a metre, and y points down. Each
// Gaussian follows from the seed and its index alone, so parts can be made in any order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/parallel.h"
#include "raster/scene/camera.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

enum class CityKind { sky, ground, wire, leaf, facade };

class City {
 public:
  /// `count`: 1 to 2^32. A block of houses has about 200,000 Gaussians.
  City(std::size_t count, int sh_degree, std::uint64_t seed);

  std::size_t size() const { return count_; }

  /// The kind of Gaussian `i`.
  CityKind kind(std::size_t i) const;

  /// The Gaussians [begin, end).
  GaussianCloud part(std::size_t begin, std::size_t end, ThreadPool& pool) const;

  /// Views of 800 x 600 pixels: two in streets, one between roofs, one from the air.
  std::vector<Camera> cameras() const;

 private:
  struct Box;
  struct Block;

  std::size_t block_count() const { return side_ * side_; }
  std::size_t block_begin(std::size_t block) const { return count_ * block / block_count(); }
  std::size_t block_of(std::size_t i) const;
  Block make_block(std::size_t number) const;
  void make_gaussian(std::size_t i, const Block& block, GaussianCloud& cloud, std::size_t k) const;

  std::size_t count_, side_;  // blocks along one side
  int degree_;
  std::uint64_t seed_;
};

}  // namespace qs
