// SPDX-License-Identifier: MIT
#include "library/check/frame_memory.h"

#include <cstring>

#include "library/check/structs.h"

namespace qs::library {
namespace {

using namespace cpu::diff;

bool is_aligned(const void* memory) {
  return reinterpret_cast<std::uintptr_t>(memory) % kBlockAlignment == 0;
}

/// Throws Error(usage) unless the memory begins with this header. Blocks on a GPU have none.
void check_block(const void* memory, const BlockHeader& expected, const Place& place,
                 const Where& where) {
  require(memory, where);
  if (!is_aligned(memory)) refuse(where, "is not aligned to {} bytes", kBlockAlignment);
  if (place.is_gpu()) return;
  BlockHeader found;
  std::memcpy(&found, memory, sizeof(found));
  if (found != expected) refuse(where, "does not hold this frame");
}

HeldSizes sizes_of(const QsStageFrame& frame) {
  return {.gaussians = frame.gaussians,
          .slots = frame.listed,
          .pairs = frame.pairs,
          .width = frame.width,
          .height = frame.height,
          .channels = frame.channels,
          .has_depth = frame.has_depth,
          .bytes_of_number = static_cast<std::uint32_t>(frame.type == QS_FLOAT64 ? sizeof(double)
                                                                                 : sizeof(float))};
}

}  // namespace

CallersMemory::CallersMemory(const Where& where, const QsMemory* memory)
    : where_(where), memory_(read_struct(memory, where_)) {
  if (memory_.reserved != 0) refuse(where_ / "reserved", "is not 0");
  if (memory_.allocate == nullptr) refuse(where_ / "allocate", "is null");
}

void* CallersMemory::allocate(std::size_t bytes, std::uint32_t kind) const {
  void* const memory = memory_.allocate(memory_.user, bytes, kind);
  if (memory == nullptr)
    fail(ErrorKind::device, "{}: returned null for {} bytes", (where_ / "allocate").text(), bytes);
  if (!is_aligned(memory))
    refuse(where_ / "allocate", "returned memory that is not aligned to {} bytes", kBlockAlignment);
  return memory;
}

void clear_frame(QsStageFrame* frame, const Where& where) {
  write_struct(QsStageFrame{}, frame, where);
}

HeldSizes sizes_on_host(const QsStageFrame& frame) {
  if (frame.memory != QS_MEMORY_HOST)
    fail(ErrorKind::usage,
         "the frame is in the memory of a GPU, which this function does not support yet");
  return sizes_of(frame);
}

QsStageFrame frame_of(const StageCall& call, const QsStageFrame* frame, bool is_blended) {
  const Where where = call.where("frame");
  const QsStageFrame given = read_struct(frame, where);
  if (given.per_gaussian == nullptr) refuse(where, "is empty: qs_project() fills it");
  const Place place{given.memory, given.device};
  if (place.memory != call.place.memory || place.device != call.place.device)
    refuse(where, "is in {}, but the inputs are in {}", place.text(), call.place.text());
  if (given.type != call.type())
    refuse(where, "belongs to arrays of float{}", given.type == QS_FLOAT64 ? 64 : 32);
  if (given.gaussians != static_cast<std::uint64_t>(call.gaussians))
    refuse(where, "belongs to {} Gaussians, but the inputs have {}", given.gaussians,
           call.gaussians);
  const Camera& camera = call.view.camera;
  if (given.width != camera.width || given.height != camera.height)
    refuse(where, "belongs to {} x {} pixels, but the camera has {} x {}", given.width,
           given.height, camera.width, camera.height);
  const HeldSizes sizes = sizes_of(given), projected = sizes.projected();
  // The blocks of both types have the same marks.
  check_block(given.per_gaussian, {GaussianBlock<float>::kMark, projected}, place,
              where / "per_gaussian");
  check_block(given.per_pair, {PairBlock::kMark, projected}, place, where / "per_pair");
  if (!is_blended) return given;
  if (given.per_pixel == nullptr) refuse(where, "has no pixels: qs_blend() draws them");
  if (given.channels != static_cast<std::uint32_t>(call.channels))
    refuse(where, "belongs to {} channels, but the inputs have {}", given.channels, call.channels);
  check_block(given.per_pixel, {PixelBlock<float>::kMark, sizes}, place, where / "per_pixel");
  return given;
}

}  // namespace qs::library
