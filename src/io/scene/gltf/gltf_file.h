// SPDX-License-Identifier: MIT
//
// A parsed glTF file: its JSON, parsed by tinygltf, and the bytes of its buffers, which are in the
// file itself, in base64 or in files beside it. Buffers, images and materials are removed from the
// JSON before tinygltf parses it, so that tinygltf opens no file and copies no buffer. Every access
// to a buffer goes through view() and numbers(), which check it in 64 bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <span>
#include <string>
#include <vector>

#include "io/bytes/byte_cursor.h"
#include "io/scene/gltf/tinygltf.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The values of an accessor, converted to float on access.
class GltfNumbers {
 public:
  std::uint64_t count = 0;  ///< elements

  /// Component `c` of element `i`. Normalised integers become -1..1 or 0..1.
  float operator()(std::uint64_t i, std::size_t c) const {
    const std::byte* const at = data_ + i * stride_ + c * component_bytes_;
    return convert_ == nullptr ? load<float>(at) : convert_(at, normalized_);
  }

 private:
  friend class GltfFile;

  const std::byte* data_ = nullptr;
  std::uint64_t stride_ = 0;
  std::size_t component_bytes_ = 0;
  float (*convert_)(const std::byte* at, bool normalized) = nullptr;  // null: floats
  bool normalized_ = false;
};

/// The buffers of a file, and the memory of buffers outside of it or in base64.
struct GltfBuffers {
  std::vector<std::span<const std::byte>> buffers;
  std::list<Array<std::byte>> unpacked;
  std::uint64_t bytes = 0, bytes_outside = 0;
};

class GltfFile {
 public:
  /// `content` is a .glb or a .gltf and must outlive this. Throws Error(input).
  GltfFile(std::span<const std::byte> content, const std::filesystem::path& path);

  const tinygltf::Model& model() const { return model_; }
  bool is_binary() const { return is_binary_; }
  std::uint64_t buffer_bytes() const { return buffers_.bytes; }  ///< each file counted once
  std::uint64_t bytes_outside() const { return buffers_.bytes_outside; }  ///< in files beside it

  /// The bytes of bufferView `index`. Throws Error(input).
  std::span<const std::byte> view(int index) const;

  /// The number of elements of accessor `index`, which may have no values; `what` names it in
  /// messages.
  std::uint64_t count(int index, const std::string& what) const;

  /// The values of accessor `index`, which must have `components` components; `what` names it in
  /// messages.
  GltfNumbers numbers(int index, std::size_t components, const std::string& what) const;

 private:
  const tinygltf::Accessor& accessor(int index, const std::string& what) const;

  std::string path_;
  bool is_binary_ = false;
  tinygltf::Model model_;
  GltfBuffers buffers_;
};

bool is_glb(std::span<const std::byte> content);

}  // namespace qs
