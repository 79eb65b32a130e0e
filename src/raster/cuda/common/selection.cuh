// SPDX-License-Identifier: MIT
//
// The passes of selecting Gaussians in the picture of a drawn frame: Outputs::seen and share.
#pragma once

#include "raster/cuda/common/depth.cuh"

namespace qs::cuda {

/// The bit of a Gaussian, by its index in the file, in words of 32. Passed by value.
struct FileBits {
  const std::uint32_t* file_indices;  ///< by place; null in Order::file
  std::uint32_t* words;

  __device__ std::uint32_t* word_of(std::uint32_t gaussian, std::uint32_t& bit) const {
    const std::uint32_t i = file_indices == nullptr ? gaussian : file_indices[gaussian];
    bit = 1u << i % 32;
    return words + i / 32;
  }
};

/// Sets the bits of the Gaussians that chosen pixels show, see SeenPixels.
struct SeenPass {
  PixelBox box;
  const std::uint8_t* chosen;
  float weight;
  FileBits seen;

  struct Pixel {
    float transmittance = 1;
  };
  __device__ std::uint32_t value_of(std::uint32_t gaussian) const { return gaussian; }
  __device__ bool takes(int x, int y) const {
    return x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1 &&
           chosen[(y - box.y0) * (box.x1 - box.x0) + x - box.x0] != 0;
  }
  __device__ void add(Pixel& pixel, float alpha, std::uint32_t gaussian, float next) const {
    if (alpha * pixel.transmittance >= weight) {
      std::uint32_t bit;
      std::uint32_t* const word = seen.word_of(gaussian, bit);
      if ((*word & bit) == 0) atomicOr(word, bit);
    }
    pixel.transmittance = next;
  }
  __device__ void store(std::size_t, const Pixel&) const {}
};

/// Sums the weights of the Gaussians with a bit.
struct SharePass {
  FileBits set;
  float* share;

  struct Pixel {
    float transmittance = 1, sum = 0;
  };
  __device__ bool value_of(std::uint32_t gaussian) const {
    std::uint32_t bit;
    return (*set.word_of(gaussian, bit) & bit) != 0;
  }
  __device__ bool takes(int, int) const { return true; }
  __device__ void add(Pixel& pixel, float alpha, bool has, float next) const {
    if (has) pixel.sum += alpha * pixel.transmittance;
    pixel.transmittance = next;
  }
  __device__ void store(std::size_t at, const Pixel& pixel) const { share[at] = pixel.sum; }
};

class Selection {
 public:
  /// Fills Frame::seen and share as requested, and waits. `in` has the lists and splats of the
  /// frame. Throws Error(device).
  template <class Entry>
  void fill(const FrameContext& frame, const BlendInput<Entry>& in, const Outputs& outputs,
            Frame& result) {
    constexpr const char* kWhat = "the selection";
    const std::size_t count = frame.cloud.count, words = (count + 31) / 32;
    const auto tiles = static_cast<unsigned>(frame.grid.count());
    words_.reserve(kWhat, words + 1);
    const FileBits bits{frame.cloud.file_indices.data(), words_.data()};
    if (outputs.seen) {
      const SeenPixels& seen = *outputs.seen;
      set_zero(kWhat, words_.data(), words + 1, frame.stream);
      copy_to_device(kWhat, seen.chosen, chosen_, frame.stream);
      launch(kWhat, walk_tiles<Entry, SeenPass>, tiles, frame.stream, in,
             SeenPass{seen.box, chosen_.data(), seen.weight, bits});
      const auto found = copied(words_.data(), words, frame.stream);
      result.seen = GaussianSet::of_bytes(count, std::as_bytes(std::span(found)));
    }
    if (outputs.share) {
      const std::size_t pixels = Pixels::count_of(frame.camera);
      const auto set = outputs.share->bytes();
      copy_to_device(set.data(), set.size(), reinterpret_cast<std::byte*>(words_.data()),
                     frame.stream);
      share_.reserve(kWhat, pixels);
      launch(kWhat, walk_tiles<Entry, SharePass>, tiles, frame.stream, in,
             SharePass{bits, share_.data()});
      result.share = copied(share_.data(), pixels, frame.stream);
    }
  }

 private:
  DeviceBuffer<std::uint32_t> words_;
  DeviceBuffer<std::uint8_t> chosen_;
  DeviceBuffer<float> share_;
};

}  // namespace qs::cuda
