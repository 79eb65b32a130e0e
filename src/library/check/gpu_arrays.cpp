// SPDX-License-Identifier: MIT
#include "library/check/gpu_arrays.h"

#ifdef QUADSPLAT_HAVE_CUDA
#include <algorithm>
#include <cstdint>

#include "learn/diff/cuda/device.h"
#include "library/check/stage_arguments.h"
#endif

namespace qs::library {

#ifdef QUADSPLAT_HAVE_CUDA

namespace gpu = cuda::diff;

namespace {

/// The elements from the lowest address to the highest, as offsets from QsArray::data.
struct Reach {
  std::int64_t low = 0, high = 0;

  explicit Reach(const QsArray& array) {
    for (std::uint32_t i = 0; i < array.dimensions; ++i) {
      const std::int64_t reach = (array.sizes[i] - 1) * array.strides[i];
      (reach < 0 ? low : high) += reach;
    }
  }
  std::int64_t count() const { return high - low + 1; }
};

}  // namespace

std::optional<int> other_gpu_of(const QsArray& array) {
  return gpu::other_gpu_of(array.data, array.device);
}

QsArray HostCopies::of(const QsArray& array) {
  QsArray copy = array;
  copy.memory = QS_MEMORY_HOST;
  copy.device = 0;
  const bool is_empty =
      std::find(array.sizes, array.sizes + array.dimensions, 0) != array.sizes + array.dimensions;
  if (array.memory == QS_MEMORY_HOST || is_absent(array) || is_empty) return copy;
  const Reach reach(array);
  with_type(array, [&](auto* elements) {
    auto* const from = elements + reach.low;
    auto& bytes = copies_.emplace_back(static_cast<std::size_t>(reach.count()) * sizeof(*from));
    const gpu::SelectedGpu selected(use_.device());
    gpu::copy_from_gpu(bytes.data(), from, bytes.size(), {stream_, use_.stop()});
    copy.data = reinterpret_cast<decltype(from)>(bytes.data()) - reach.low;
  });
  return copy;
}

void store_on_gpu(const DeviceMaps& maps, const QsPicture& picture, const Camera& camera,
                  const Use& use) {
  const gpu::SelectedGpu selected(use.device());
  const gpu::Queue queue{picture.stream, use.stop()};
  const auto save = [&](const QsArray& to, const float* values, int channels) {
    if (is_absent(to)) return;
    const gpu::PackedMap map{values, camera.height, camera.width, channels};
    if (to.type == QS_UINT8)
      gpu::store_map(map, pixels_of<std::uint8_t>(to), queue);
    else
      gpu::store_map(map, pixels_of<float>(to), queue);
  };
  save(picture.color, maps.color, 3);
  save(picture.alpha, maps.alpha, 1);
  save(picture.depth, maps.expected, 1);
  save(picture.median_depth, maps.median, 1);
  gpu::wait(queue);
}

#else

std::optional<int> other_gpu_of(const QsArray&) { return std::nullopt; }
QsArray HostCopies::of(const QsArray& array) { return array; }
void store_on_gpu(const DeviceMaps&, const QsPicture&, const Camera&, const Use&) {}

#endif

}  // namespace qs::library
