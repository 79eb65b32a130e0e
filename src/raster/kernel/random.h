// SPDX-License-Identifier: MIT
//
// Random numbers as a function of seed, purpose, step and index. They need no state, so they are
// the same on all backends and threads, and after training is resumed.
#pragma once

#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>

#include "raster/kernel/hd.h"

namespace qs {

/// The mixing function of SplitMix64 (Steele, Lea and Flood 2014).
QS_HD std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

/// The purpose of a random number. Every purpose has its own sequence.
enum class RandomUse : std::uint64_t {
  views,
  background,
  start,
  split,
  relocate,
  add,
  noise,
  scored_views,
  color_field
};

struct Random {
  std::uint64_t state;

  /// The numbers of one purpose at one step of training.
  static QS_HD Random of(std::uint64_t seed, RandomUse use, std::uint64_t step) {
    return {mix_bits(mix_bits(mix_bits(seed) ^ static_cast<std::uint64_t>(use)) ^ step)};
  }

  QS_HD std::uint64_t bits(std::uint64_t i) const { return mix_bits(state ^ mix_bits(i)); }

  /// Number i in [0, 1), a multiple of 2^-53.
  QS_HD double uniform(std::uint64_t i) const {
    return static_cast<double>(bits(i) >> 11) * 0x1p-53;
  }

  /// Number i of a standard normal distribution (Box and Muller 1958).
  QS_HD double normal(std::uint64_t i) const {
    const double radius = std::sqrt(-2 * std::log(1 - uniform(2 * i)));
    return radius * std::cos(6.283185307179586 * uniform(2 * i + 1));
  }

  /// Three independent normal numbers.
  QS_HD glm::dvec3 normal3(std::uint64_t i) const {
    return {normal(3 * i), normal(3 * i + 1), normal(3 * i + 2)};
  }
};

}  // namespace qs
