// SPDX-License-Identifier: MIT
//
// A caller whose arrays are on a GPU.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "library/stage_drawing.h"
#include "support/gpu_memory.h"

namespace qs::test {

/// OnGpu: arrays of at least this number of elements may not be on the host.
inline constexpr std::int64_t kSmall = 32;

inline std::size_t bytes_of_type(std::uint32_t type) {
  return type == QS_FLOAT64 || type == QS_INT64 || type == QS_UINT64 ? 8 : type == QS_UINT8 ? 1 : 4;
}

/// Copies of a call's arrays on the GPU.
class OnGpu final : public Placement {
 public:
  bool keeps_small_arrays = false;  ///< on the host
  bool gives_temporary = false;
  int asked_for_temporary = 0;

  using Placement::place;
  void place(QsArray& array) override {
    std::int64_t low = 0, high = 0, count = 1;
    for (std::uint32_t i = 0; i < array.dimensions; ++i) {
      const std::int64_t reach = (array.sizes[i] - 1) * array.strides[i];
      (reach < 0 ? low : high) += reach;
      count *= array.sizes[i];
    }
    if (array.dimensions == 0 || (keeps_small_arrays && count <= kSmall)) return;
    array.memory = QS_MEMORY_CUDA;
    if (count == 0) return;
    const auto element = static_cast<std::int64_t>(bytes_of_type(array.type));
    auto* const begin = static_cast<std::byte*>(array.data) + low * element;
    const auto bytes = static_cast<std::size_t>((high - low + 1) * element);
    Copy& copy = copies_.emplace_back(Copy{begin, GpuMemory(bytes)});
    copy.memory.upload(begin);
    array.data = static_cast<std::byte*>(copy.memory.data()) - low * element;
  }
  void give_back() override {
    for (const Copy& copy : copies_) copy.memory.download(copy.from);
    copies_.clear();
  }
  QsMemory memory() override { return memory_; }
  const QsMemory* temporary() override { return gives_temporary ? &memory_ : nullptr; }

 private:
  struct Copy {
    std::byte* from;
    GpuMemory memory;
  };
  static QsMemory memory_of(OnGpu* self) {
    auto memory = quadsplat::sized<QsMemory>();
    memory.user = self;
    memory.allocate = [](void* user, std::uint64_t bytes, std::uint32_t kind) {
      auto& on_gpu = *static_cast<OnGpu*>(user);
      if (kind == QS_TEMPORARY) ++on_gpu.asked_for_temporary;
      on_gpu.blocks_.emplace_back(bytes).fill(0x7f);
      return on_gpu.blocks_.back().data();
    };
    return memory;
  }
  QsMemory memory_ = memory_of(this);
  std::vector<Copy> copies_;
  std::vector<GpuMemory> blocks_;
};

}  // namespace qs::test
