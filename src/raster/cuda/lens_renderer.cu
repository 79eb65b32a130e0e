// SPDX-License-Identifier: MIT
#include <algorithm>
#include <utility>
#include <vector>

#include "raster/cuda/common/stream.cuh"
#include "raster/cuda/lens_renderer.h"
#include "raster/lens/added_face.h"
#include "raster/lens/lens_renderer_of.h"

namespace qs {
namespace cuda {
namespace {

/// A lens's map on the GPU.
struct MapCopy {
  std::shared_ptr<const LensMap> map;
  std::vector<DeviceBuffer<FacePixel>> faces = {};
  DeviceBuffer<std::uint8_t> nearest = {};
};

constexpr const char* kMap = "the map of a lens";

/// Sums in the memory of the GPU.
class GpuFaceSums {
 public:
  explicit GpuFaceSums(int device) : device_(device), stream_(device, true) {}
  ~GpuFaceSums() { cudaSetDevice(device_); }

  Target face_target() const { return DeviceImage{}; }

  void begin(glm::ivec2 size, const Outputs& outputs) {
    check(cudaSetDevice(device_), "cudaSetDevice");
    added_.make_wait(stream_);  // a cancelled picture
    size_ = size;
    pixels_ = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    maps_ = {};
    if (outputs.color) {
      color_.reserve("the picture of a lens", 3 * pixels_);
      set_zero("lens", maps_.color = color_.data(), 3 * pixels_, stream_);
    }
    if (!outputs.depth) return;
    depth_.reserve("the depths of a lens", 3 * pixels_);
    set_zero("lens", depth_.data(), 3 * pixels_, stream_);
    maps_.alpha = depth_.data();
    maps_.expected = maps_.alpha + pixels_;
    maps_.median = maps_.expected + pixels_;
  }

  void begin_eye(std::shared_ptr<const LensMap> map, std::size_t first_pixel,
                 const glm::vec3& background) {
    const MapCopy& copy = copy_of(std::move(map));
    eye_ = maps_.from(first_pixel);
    added_.make_wait(stream_);
    if (eye_.color != nullptr)
      for_each_item(
          "lens", copy.map->nearest.size(), stream_,
          [=, color = eye_.color, nearest = copy.nearest.data()] __device__(std::size_t at) {
            if (nearest[at] != LensMap::kNoFace) return;
            for (int c = 0; c < 3; ++c) color[3 * at + c] = background[c];
          });
    added_.record(stream_);
  }

  void add(const Frame& frame, std::size_t number) {
    const MapCopy& copy = copies_.back();
    const FaceMap& face = copy.map->faces[number];
    const AddedFace added{frame.on_device, face.camera.width, eye_, copy.nearest.data(),
                          static_cast<std::uint8_t>(number)};
    // One face after the other, because two of them add to the pixels at their border, and sums of
    // floats depend on the order.
    const auto stream = static_cast<cudaStream_t>(frame.on_device.stream);
    added_.make_wait(stream);
    for_each_item("lens", face.pixels.size(), stream,
                  [=, pixels = copy.faces[number].data()] __device__(std::size_t k) {
                    added.add(pixels[k]);
                  });
    added_.record(stream);
  }

  void wait() const { added_.wait("lens"); }

  void finish(const Target& target, Frame& result) {
    if (std::holds_alternative<DeviceImage>(target)) {
      result.on_device = {maps_.color, maps_.alpha, maps_.expected, maps_.median};
      return;
    }
    if (maps_.color != nullptr) {
      result.color = Image(size_.x, size_.y, 3);
      copy_to_host(maps_.color, result.color.values.data(), 3 * pixels_, stream_);
    }
    if (maps_.alpha == nullptr) return;
    result.depth = {copied(maps_.alpha, pixels_, stream_), copied(maps_.expected, pixels_, stream_),
                    copied(maps_.median, pixels_, stream_)};
  }

 private:
  /// The copy of the map, made now or before; the last element of copies_.
  const MapCopy& copy_of(std::shared_ptr<const LensMap> map) {
    auto found = std::find_if(copies_.begin(), copies_.end(),
                              [&](const MapCopy& copy) { return copy.map == map; });
    if (found == copies_.end()) {
      if (copies_.size() == kMostMaps) copies_.erase(copies_.begin());
      MapCopy copy{std::move(map)};
      copy_to_device(kMap, copy.map->nearest, copy.nearest, stream_);
      copy.faces.resize(copy.map->faces.size());
      for (std::size_t i = 0; i < copy.faces.size(); ++i)
        copy_to_device(kMap, copy.map->faces[i].pixels, copy.faces[i], stream_);
      copies_.push_back(std::move(copy));
      found = copies_.end() - 1;
    }
    std::rotate(found, found + 1, copies_.end());
    return copies_.back();
  }

  int device_;
  Stream stream_;
  Event added_;                  // the last face
  std::vector<MapCopy> copies_;  // the last used last
  DeviceBuffer<float> color_, depth_;
  SummedMaps maps_, eye_;
  glm::ivec2 size_{0};
  std::size_t pixels_ = 0;
};

}  // namespace
}  // namespace cuda

std::unique_ptr<Renderer> with_lenses_on_gpu(std::unique_ptr<Renderer> inner, ThreadPool& pool,
                                             int device) {
  return std::make_unique<LensRenderer<cuda::GpuFaceSums>>(std::move(inner), pool, device);
}

}  // namespace qs
