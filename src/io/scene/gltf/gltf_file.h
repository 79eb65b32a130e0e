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
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>
#include <nlohmann/json_fwd.hpp>

#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/linear_values.h"
#include "io/scene/gltf/tinygltf.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// The values of an accessor, converted to float on access.
struct GltfNumbers {
  std::uint64_t count = 0;  ///< elements
  const std::byte* data = nullptr;
  std::uint64_t stride = 0;
  std::size_t component_bytes = 0;
  float (*convert)(const std::byte* at, bool normalized) = nullptr;  ///< null: floats
  bool normalized = false;
  std::shared_ptr<const Array<std::byte>> dense = nullptr;  ///< of a sparse accessor: its elements

  /// Component `c` of element `i`. Normalised integers become -1..1 or 0..1.
  float operator()(std::uint64_t i, std::size_t c) const {
    const std::byte* const at = data + i * stride + c * component_bytes;
    return convert == nullptr ? load<float>(at) : convert(at, normalized);
  }
};

class GltfFile {
 public:
  /// `content` is a .glb or a .gltf and must outlive this. Throws Error(input).
  GltfFile(ByteSpan content, const std::filesystem::path& path);

  const tinygltf::Model& model() const { return model_; }
  bool is_binary() const { return is_binary_; }
  std::uint64_t buffer_bytes() const { return buffer_bytes_; }    ///< each file counted once
  std::uint64_t bytes_outside() const { return bytes_outside_; }  ///< in files beside it

  /// The bytes of bufferView `index`. Throws Error(input).
  ByteSpan view(int index) const;

  /// The number of elements of accessor `index`, which may have no values; `what` names it in
  /// messages.
  std::uint64_t count(int index, const std::string& what) const;

  /// The values of accessor `index`, which must have `components` components; `what` names it in
  /// messages.
  GltfNumbers numbers(int index, std::size_t components, const std::string& what) const;

 private:
  const tinygltf::Accessor& accessor(int index, const std::string& what) const;
  const std::byte* elements(int view, std::uint64_t offset, std::uint64_t count,
                            std::uint64_t element_bytes, std::uint64_t stride,
                            const std::string& what) const;
  void replace_sparse(const tinygltf::Accessor& accessor, std::uint64_t element_bytes,
                      const std::string& what, GltfNumbers& numbers) const;
  void add_buffer(const nlohmann::json& buffer, std::optional<ByteSpan> binary_chunk);
  ByteSpan bytes_at(const nlohmann::json& uri, const std::string& where);
  ByteSpan keep(Array<std::byte> bytes);

  std::filesystem::path file_;
  std::string path_;
  bool is_binary_ = false;
  tinygltf::Model model_;
  std::vector<ByteSpan> buffers_;
  std::list<Array<std::byte>> unpacked_;     // buffers outside of the file or in base64
  std::map<std::string, ByteSpan> outside_;  // files, which several buffers may name
  std::uint64_t buffer_bytes_ = 0, bytes_outside_ = 0;
};

bool is_glb(ByteSpan content);

// The transforms of the meshes in a glTF scene.

struct PlacedMesh {
  std::size_t mesh = 0;  ///< a valid index into the model's meshes
  int node = -1;         ///< for messages
  glm::dmat4 world_from_mesh{1};
};

/// The meshes of the default scene. Without a default scene: the meshes of all nodes. Without
/// nodes: all meshes, untransformed. Nodes are walked without recursion. Throws Error(input)
/// "source: ..." if they do not form a tree.
std::vector<PlacedMesh> placed_meshes(const tinygltf::Model& model, const std::string& source);

// The Gaussians of one glTF primitive, from its accessors or from compressed data, and their
// conversion into a cloud.

/// The Gaussians of one primitive, in glTF's frame (LUF).
struct GltfSplats {
  std::uint64_t count = 0;
  int degree = 0;
  /// Set for compressed data; then the accessors below are empty.
  std::shared_ptr<const GaussianCloud> cloud;
  GltfNumbers positions, rotations, scales;
  GltfNumbers opacities, colors;  ///< opacities, or RGBA as in drafts, 0 to 1
  std::vector<GltfNumbers> sh;    ///< begins with degree 0, or with degree 1 if there are `colors`
  bool scales_are_logarithms = false;
  bool colors_are_linear = false;  ///< in lin_rec709_display, to be converted to sRGB
};

/// Writes Gaussian `from` of the primitive to position `to` of the cloud, whose degree is at least
/// as high. May be called from several threads.
void fill_gaussian(const GltfSplats& splats, std::uint64_t from, GaussianCloud& cloud,
                   std::size_t to, LinearValues& linear);

/// True if these scales are logarithms, as in the extension's draft, instead of linear.
bool are_logarithms(const GltfNumbers& scales);

}  // namespace qs
