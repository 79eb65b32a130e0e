// SPDX-License-Identifier: MIT
//
// A frame in three blocks of memory of the caller, instead of in vectors. A block begins with a
// header; its arrays follow, at multiples of kBlockAlignment bytes. A block may be copied to
// another place.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "learn/diff/block_arrays.h"
#include "learn/diff/cpu/frame.h"

namespace qs::cpu::diff {

/// The sizes of a frame. The sizes of its blocks follow from them.
struct HeldSizes {
  std::uint64_t gaussians = 0;
  std::uint64_t slots = 0;  ///< Gaussians that a tile lists: held frames have no unused slots
  std::uint64_t pairs = 0;
  std::int32_t width = 0, height = 0;
  std::uint32_t channels = 0;         ///< channels of the blended colours; 0 before blend()
  std::uint32_t has_depth = 0;        ///< 1: blend() summed depths
  std::uint32_t bytes_of_number = 0;  ///< 4: float, 8: double

  bool operator==(const HeldSizes&) const = default;
  PictureSize picture() const { return {width, height}; }

  /// The sizes of the frame before blend().
  HeldSizes projected() const {
    HeldSizes sizes = *this;
    sizes.channels = sizes.has_depth = 0;
    return sizes;
  }
};

struct BlockHeader {
  std::uint64_t mark;  ///< the kMark of the block
  HeldSizes sizes;

  bool operator==(const BlockHeader&) const = default;
};

/// The part of a ProjectedFrame whose size depends on the number of Gaussians.
template <class Real>
struct GaussianBlock {
  static constexpr std::uint64_t kMark = 0x31'73'73'75'61'67'73'71;  // "qsgauss1"
  using Splat = typename FrameView<Real>::Splat;

  BlockHeader* header;
  std::uint32_t *first, *counts;  ///< per chunk
  std::uint32_t* gaussians;       ///< per slot, as the next three
  Splat* splats;
  PixelArea* areas;
  Real* depths;
  std::uint8_t* projected;  ///< per Gaussian

  static GaussianBlock of(BlockArrays& block, const HeldSizes& sizes) {
    const std::size_t chunks = VisibleSlots::chunks_of(sizes.gaussians);
    return {.header = block.next<BlockHeader>(1),
            .first = block.next<std::uint32_t>(chunks),
            .counts = block.next<std::uint32_t>(chunks),
            .gaussians = block.next<std::uint32_t>(sizes.slots),
            .splats = block.next<Splat>(sizes.slots),
            .areas = block.next<PixelArea>(sizes.slots),
            .depths = block.next<Real>(sizes.slots),
            .projected = block.next<std::uint8_t>(sizes.gaussians)};
  }
};

/// The tile lists.
struct PairBlock {
  static constexpr std::uint64_t kMark = 0x31'73'72'69'61'70'73'71;  // "qspairs1"

  BlockHeader* header;
  std::uint64_t* list_begin;  ///< per tile and behind the last tile
  std::uint32_t* listed;      ///< per pair

  static PairBlock of(BlockArrays& block, const HeldSizes& sizes) {
    return {.header = block.next<BlockHeader>(1),
            .list_begin = block.next<std::uint64_t>(sizes.picture().tiles() + 1),
            .listed = block.next<std::uint32_t>(sizes.pairs)};
  }
};

/// The state of the pixels.
template <class Real>
struct PixelBlock {
  static constexpr std::uint64_t kMark = 0x31'73'6c'65'78'69'70'71;  // "qpixels1"

  BlockHeader* header;
  PixelState<Real> state;

  static PixelBlock of(BlockArrays& block, const HeldSizes& sizes) {
    const std::size_t pixels = sizes.picture().pixels();
    PixelBlock result{};
    result.header = block.next<BlockHeader>(1);
    result.state.color = block.next<Real>(pixels * sizes.channels);
    result.state.transmittance = block.next<Real>(pixels);
    result.state.last = block.next<std::uint32_t>(pixels);
    if (sizes.has_depth != 0) {
      result.state.depth = block.next<Real>(pixels);
      result.state.inverse_depth = block.next<Real>(pixels);
    }
    return result;
  }

  PixelState<const Real> read_only() const {
    return {state.color, state.transmittance, state.last, state.depth, state.inverse_depth};
  }
};

template <class Real>
HeldSizes sizes_of(const ProjectedFrame<Real>& frame, std::size_t gaussians,
                   const PictureSize& size) {
  return {.gaussians = gaussians,
          .slots = frame.visible.count,
          .pairs = frame.lists.pairs(),
          .width = size.width,
          .height = size.height,
          .bytes_of_number = sizeof(Real)};
}

/// Copies a frame of these sizes into its blocks, without the unused slots.
template <class Real>
void hold(const ProjectedFrame<Real>& frame, const HeldSizes& sizes,
          const GaussianBlock<Real>& gaussians, const PairBlock& pairs) {
  const FrameView<Real> view = frame.view();
  *gaussians.header = {GaussianBlock<Real>::kMark, sizes};
  *pairs.header = {PairBlock::kMark, sizes};
  std::copy_n(view.counts.begin(), view.counts.size(), gaussians.counts);
  std::copy_n(frame.projected.begin(), frame.projected.size(), gaussians.projected);
  std::vector<std::uint32_t> unused(view.counts.size());  // slots in front of a chunk
  std::uint32_t next = 0;
  for (std::size_t chunk = 0; chunk < unused.size(); ++chunk) {
    gaussians.first[chunk] = next;
    unused[chunk] = view.first[chunk] - next;
    view.for_chunk(chunk, [&](std::size_t slot) {
      gaussians.gaussians[next] = view.gaussians[slot];
      gaussians.splats[next] = view.splats[slot];
      gaussians.areas[next] = view.areas[slot];
      gaussians.depths[next++] = view.depths[slot];
    });
  }
  std::copy_n(view.list_begin, sizes.picture().tiles() + 1, pairs.list_begin);
  std::transform(view.listed, view.listed + view.pairs, pairs.listed,
                 [&](std::uint32_t slot) { return slot - unused[slot / VisibleSlots::kChunk]; });
}

/// The frame in its blocks.
template <class Real>
FrameView<Real> view_of(const HeldSizes& sizes, const GaussianBlock<Real>& gaussians,
                        const PairBlock& pairs) {
  const std::size_t chunks = VisibleSlots::chunks_of(sizes.gaussians);
  return {.first = {gaussians.first, chunks},
          .counts = {gaussians.counts, chunks},
          .slots = sizes.slots,
          .gaussians = gaussians.gaussians,
          .splats = gaussians.splats,
          .areas = gaussians.areas,
          .depths = gaussians.depths,
          .list_begin = pairs.list_begin,
          .listed = pairs.listed,
          .pairs = sizes.pairs};
}

}  // namespace qs::cpu::diff
