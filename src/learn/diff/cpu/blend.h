// SPDX-License-Identifier: MIT
//
// The second pass of the differentiable rasterizer: composites the listed Gaussians to pictures,
// and its backward pass, from the pictures to the boundary. No result depends on the number of
// threads: every pair of a tile and a Gaussian gets its own sum over the tile's pixels, row by row,
// and a Gaussian's pairs are summed in the order of tiles.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "learn/diff/channels.h"
#include "learn/diff/cpu/frame.h"
#include "learn/diff/gaussians.h"
#include "learn/diff/rules.h"
#include "learn/diff/strided_arrays.h"
#include "learn/gradient/pixel.h"
#include "raster/kernel/blend.h"

namespace qs::cpu::diff {

/// Draws the frame into `state`, whose arrays have the picture's size, and into all wanted
/// pictures. Depths are summed if `state` has their arrays. Throws Error(usage) if inputs do not
/// fit together, and Cancelled.
template <class Real>
void blend(const BlendInput<Real>& in, const FrameView<Real>& frame, const Workers& workers,
           const PixelState<Real>& state, const Pictures<Real>& out = {});

/// Memory of blend_backward() that may be used again.
template <class Real>
struct PairScratch {
  std::vector<Real> pairs;                  ///< PixelSums per pair, in the order of the lists
  std::vector<Real> depths;                 ///< per pair: derivative by z
  std::vector<glm::vec<2, Real>> absolute;  ///< per pair: absolute gradients
  std::vector<std::uint64_t> begin;         ///< slots + 1 offsets into `order`
  std::vector<std::uint64_t> order;         ///< pairs by slot and tile
};

/// `state` is the result of blend() for the same arguments; `by` are the derivatives by the
/// pictures, each of which may be missing. Writes all rows of the wanted arrays. Throws
/// Error(usage) and Cancelled.
template <class Real>
void blend_backward(const BlendInput<Real>& in, const FrameView<Real>& frame, std::size_t gaussians,
                    const PixelState<const Real>& state, const Pictures<const Real>& by,
                    const Workers& workers, PairScratch<Real>& scratch,
                    const BoundaryGradients<Real>& out);

/// The first step of blend_backward(): the sums of each pair. `absolute` requests absolute
/// gradients. Colours have kChannels channels, of which in.channel_count are used.
template <int kChannels, class Real>
void sum_pairs(const BlendInput<Real>& in, const FrameView<Real>& frame,
               const PixelState<const Real>& state, const Pictures<const Real>& by, bool absolute,
               const Workers& workers, PairScratch<Real>& scratch);

/// The sums of a pair, as PairScratch stores them.
template <class Real, int kChannels>
struct StoredSums {
  using Sums = PixelSums<Real, Color<Real, kChannels>>;
  static constexpr std::size_t kNumbers = 6 + kChannels;
  using Numbers = std::array<Real, kNumbers>;
  static void store(const Sums& sums, std::size_t pair, std::vector<Real>& pairs) {
    const auto numbers = std::bit_cast<Numbers>(sums);
    std::copy_n(numbers.begin(), kNumbers, &pairs[pair * kNumbers]);
  }
  static Sums load(const std::vector<Real>& pairs, std::size_t pair) {
    Numbers numbers;
    std::copy_n(&pairs[pair * kNumbers], kNumbers, numbers.begin());
    return std::bit_cast<Sums>(numbers);
  }
};

/// A Gaussian's derivatives by the values that pixels read, summed over its pairs.
template <class Real, int kChannels>
struct SlotGradient {
  SplatGradient<Real, Color<Real, kChannels>> splat;
  Real depth = 0;
  glm::vec<2, Real> absolute{0};

  static SlotGradient of(const FrameView<Real>& frame, std::size_t slot,
                         const PairScratch<Real>& scratch) {
    typename StoredSums<Real, kChannels>::Sums sums;
    SlotGradient result;
    for (std::uint64_t at = scratch.begin[slot]; at < scratch.begin[slot + 1]; ++at) {
      const std::size_t pair = scratch.order[at];
      sums += StoredSums<Real, kChannels>::load(scratch.pairs, pair);
      if (!scratch.depths.empty()) result.depth += scratch.depths[pair];
      if (!scratch.absolute.empty()) result.absolute += scratch.absolute[pair];
    }
    result.splat = splat_gradient<Real>(frame.splats[slot], sums);
    return result;
  }
};

/// Sets counts.at(i), for each of `gaussians` Gaussians, to the number of pixels that blend it and
/// have a transmittance above `behind` after it. blend() makes the same decisions. Throws
/// Cancelled.
template <class Real>
void count_pixels(const PictureSize& size, const PixelRules<Real>& rules,
                  const FrameView<Real>& frame, std::size_t gaussians, Real behind,
                  const Workers& workers, const qs::diff::Rows<std::int32_t>& counts);

}  // namespace qs::cpu::diff
