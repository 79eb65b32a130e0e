// SPDX-License-Identifier: MIT
//
// Frames of the differentiable rasterizer in memory of the caller (QsStageFrame).
#pragma once

#include "learn/diff/cpu/frame_blocks.h"
#include "library/check/stage_arguments.h"
#include "quadsplat/quadsplat.h"

namespace qs::library {

/// Memory from the caller's callback.
class CallersMemory {
 public:
  /// Throws Error(usage).
  CallersMemory(const Where& where, const QsMemory* memory);

  /// Throws Error(device) if the callback has no memory.
  void* allocate(std::size_t bytes, std::uint32_t kind) const;

  /// Throws Error(usage) with a sentence about the callback.
  [[noreturn]] void refuse_memory(const std::string& reason) const {
    refuse(where_ / "allocate", "{}", reason);
  }

  template <class Block>
  Block allocate(const cpu::diff::HeldSizes& sizes, std::uint32_t kind) const {
    return cpu::diff::block_at<Block>(allocate(cpu::diff::bytes_of<Block>(sizes), kind), sizes);
  }

 private:
  Where where_;
  QsMemory memory_;
};

/// Makes a frame of the caller an empty frame. Throws Error(usage).
void clear_frame(QsStageFrame* frame, const Where& where);

/// A copy of the caller's frame, which belongs to the call. `is_blended`: it must have pixels.
/// Throws Error(usage).
QsStageFrame frame_of(const StageCall& call, const QsStageFrame* frame, bool is_blended);

/// Throws Error(usage) for a frame on a GPU.
cpu::diff::HeldSizes sizes_on_host(const QsStageFrame& frame);

/// A checked frame as the stages read it.
template <class Real>
struct HeldFrame {
  cpu::diff::HeldSizes sizes;
  cpu::diff::GaussianBlock<Real> gaussians;
  cpu::diff::PairBlock pairs;

  /// Throws Error(usage) for a frame on a GPU, whose blocks have other arrays.
  explicit HeldFrame(const QsStageFrame& frame)
      : sizes(sizes_on_host(frame)),
        gaussians(cpu::diff::block_at<cpu::diff::GaussianBlock<Real>>(frame.per_gaussian, sizes)),
        pairs(cpu::diff::block_at<cpu::diff::PairBlock>(frame.per_pair, sizes)) {}

  cpu::diff::FrameView<Real> view() const { return cpu::diff::view_of(sizes, gaussians, pairs); }
  std::span<const std::uint8_t> projected() const { return {gaussians.projected, sizes.gaussians}; }
};

}  // namespace qs::library
