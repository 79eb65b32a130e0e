// SPDX-License-Identifier: MIT
#include "io/scene/gltf/gltf.h"

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/fail.h"
#include "base/text.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/json_text.h"
#include "io/cloud/axes.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/scene/gltf/gltf_file.h"
#include "io/scene/ply/ply.h"
#include "io/scene/spz/spz.h"
#include "raster/scene/transform.h"

namespace qs {
namespace {

constexpr const char* kExtension = "KHR_gaussian_splatting";
constexpr const char* kSpzExtension = "KHR_gaussian_splatting_compression_spz_2";
constexpr const char* kWithdrawn = "KHR_spz_gaussian_splats_compression";
constexpr const char* kLinearSpace = "lin_rec709_display";
constexpr int kMaxStoredDegree = 4;

std::string attribute_name(const std::string& name) {
  return fmt::format("{}:{}", kExtension, name);
}

// nullptr if `object` has no such member.
const tinygltf::Value* member(const tinygltf::Value* object, const std::string& key) {
  return object != nullptr && object->IsObject() && object->Has(key) ? &object->Get(key) : nullptr;
}

class GltfScene {
 public:
  GltfScene(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool, Scene& scene)
      : path_(path), source_(path.string()), pool_(pool), scene_(scene), file_(content, path) {
    check_required_extensions();
    for (const PlacedMesh& placed : placed_meshes(file_.model(), source_)) add_mesh(placed);
    if (instances_.empty()) complain_about_nothing();
    warn(others_, "{} other meshes are not shown.");
  }

  const GltfFile& file() const { return file_; }

  void read(const Progress& progress) {
    int degree = 0;
    for (const Instance& instance : instances_) degree = std::max(degree, instance.splats->degree);
    scene_.cloud = make_cloud(parts_.count(), degree);
    LinearValues linear;
    fill_cloud(scene_, pool_, progress, 0.1f, [&](std::size_t begin, std::size_t end) {
      parts_.for_range(begin, end, [&](std::size_t part, std::uint64_t row, std::size_t i) {
        const Instance& instance = instances_[part];
        fill_gaussian(*instance.splats, row, scene_.cloud, i, linear);
        if (instance.transform) instance.transform->apply(scene_.cloud, i);
      });
      flip_axes(scene_.cloud, begin, end, kTurnAboutZ);
    });
    linear.warn(scene_);
  }

 private:
  struct Instance {
    std::shared_ptr<const GltfSplats> splats;
    std::shared_ptr<const Transform> transform;  // nullptr: identity
  };

  // Appends `sentence` with {} replaced by the count, unless the count is 0.
  void warn(std::size_t count, fmt::format_string<std::size_t&> sentence) {
    if (count > 0) scene_.warn(sentence, count);
  }
  void warn_once(const std::string& sentence) { add_new(scene_.warnings, sentence); }

  // Extensions of materials and textures do not matter for Gaussians.
  void check_required_extensions() const {
    constexpr std::string_view kKnown[] = {kExtension, kSpzExtension, "KHR_mesh_quantization"};
    for (const std::string& name : file_.model().extensionsRequired) {
      const bool known = std::find(std::begin(kKnown), std::end(kKnown), name) != std::end(kKnown);
      if (!known && !name.starts_with("KHR_materials_") && !name.starts_with("KHR_texture_") &&
          name != kWithdrawn)
        fail("{}: it requires the glTF extension '{}', which cannot be read", source_,
             printable(name.substr(0, 40)));
    }
  }

  void add_mesh(const PlacedMesh& placed) {
    std::shared_ptr<const Transform> transform;
    const auto& primitives = file_.model().meshes[placed.mesh].primitives;
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const auto splats = splats_of(placed.mesh, i);
      if (!splats) continue;
      if (!transform && placed.world_from_mesh != glm::dmat4(1)) transform = transform_of(placed);
      // Limits amplification: many nodes may show one mesh, so few bytes can represent many
      // Gaussians.
      constexpr std::uint64_t kAlwaysAllowed = 1 << 20, kPerByte = 8;
      parts_.add(splats->count);
      if (parts_.count() > std::max(kAlwaysAllowed, kPerByte * file_.buffer_bytes()))
        fail("{}: its nodes repeat meshes to more than {} Gaussians", source_, parts_.count());
      instances_.push_back({splats, transform});
    }
  }

  std::shared_ptr<const Transform> transform_of(const PlacedMesh& placed) {
    if (!Transform::is_invertible(placed.world_from_mesh))
      fail("{}: node {}: its transform cannot be applied: it flattens or distorts space", source_,
           placed.node);
    auto transform = std::make_shared<Transform>(placed.world_from_mesh);
    if (!transform->is_similarity())
      warn_once(
          "A node stretches or mirrors its Gaussians; their covariances were transformed, which "
          "the glTF extension leaves undefined.");
    return transform;
  }

  std::shared_ptr<const GltfSplats> splats_of(std::size_t mesh, std::size_t number) {
    const auto key = std::pair(mesh, number);
    if (const auto known = splats_.find(key); known != splats_.end()) return known->second;
    const tinygltf::Primitive& primitive = file_.model().meshes[mesh].primitives[number];
    std::shared_ptr<const GltfSplats> splats;
    const auto extension = primitive.extensions.find(kExtension);
    if (extension == primitive.extensions.end()) {
      ++others_;
    } else {
      if (!is_draft(primitive)) check_extension(extension->second);
      if (primitive.mode != TINYGLTF_MODE_POINTS)
        warn_once("A primitive with Gaussians is not marked as points; it was read all the same.");
      const tinygltf::Value* const compressed =
          member(member(&extension->second, "extensions"), kSpzExtension);
      auto read = compressed != nullptr ? unpack(*compressed, primitive) : bind(primitive);
      read->colors_are_linear = text_member(extension->second, "colorSpace") == kLinearSpace;
      splats = read;
    }
    return splats_[key] = splats;
  }

  // Drafts of 2024 and 2025 keep colour and opacity in COLOR_0, and name neither kernel nor space.
  static bool is_draft(const tinygltf::Primitive& primitive) {
    return primitive.attributes.count("COLOR_0") > 0 &&
           primitive.attributes.count(attribute_name("OPACITY")) == 0;
  }

  // The text of a member, empty without one.
  static std::string text_member(const tinygltf::Value& extension, const char* key) {
    const tinygltf::Value* const value = member(&extension, key);
    return value != nullptr && value->IsString() ? value->Get<std::string>() : std::string();
  }

  void check_extension(const tinygltf::Value& extension) {
    const std::string kernel = text_member(extension, "kernel");
    const std::string space = text_member(extension, "colorSpace");
    const std::string order = text_member(extension, "sortingMethod");
    const std::string projection = text_member(extension, "projection");
    if (kernel.empty()) {
      warn_once("The file names no kernel; ellipses were assumed.");
    } else if (kernel != "ellipse") {
      warn_once(fmt::format("Kernel '{}' is not known; ellipses were assumed.",
                            printable(kernel.substr(0, 40))));
    }
    if (!order.empty() && order != "cameraDistance")
      warn_once(fmt::format("Sorting method '{}' is not known; Gaussians are sorted by depth.",
                            printable(order.substr(0, 40))));
    if (!projection.empty() && projection != "perspective")
      warn_once(fmt::format("Projection '{}' is not known; perspective was assumed.",
                            printable(projection.substr(0, 40))));
    if (space == kLinearSpace) {
      warn_once(
          "The colours are linear (lin_rec709_display); they were converted to sRGB, in which they "
          "are blended.");
    } else if (space.empty()) {
      warn_once("The file names no colour space; sRGB was assumed.");
    } else if (space != "srgb_rec709_display") {
      warn_once(fmt::format("Colour space '{}' is not known; sRGB was assumed.",
                            printable(space.substr(0, 40))));
    }
  }

  std::shared_ptr<GltfSplats> unpack(const tinygltf::Value& compressed,
                                     const tinygltf::Primitive& primitive) {
    const tinygltf::Value* const view = member(&compressed, "bufferView");
    if (view == nullptr || !view->IsInt()) fail("{}: {} has no bufferView", source_, kSpzExtension);
    const auto content = file_.view(view->Get<int>());
    if (!recognises_spz(content, path_))
      fail("{}: the data of {} are not .spz", source_, kSpzExtension);
    Scene unpacked;
    unpacked.path = path_;
    read_spz(content, path_, pool_, {}, unpacked);
    if (unpacked.format != "spz, version 2")
      warn_once(fmt::format("{} holds '{}' instead of version 2.", kSpzExtension, unpacked.format));
    for (const std::string& warning : unpacked.warnings) warn_once(warning);
    if (const auto position = primitive.attributes.find("POSITION");
        position != primitive.attributes.end()) {
      const std::uint64_t announced = file_.count(position->second, "POSITION");
      if (announced != unpacked.cloud.size())
        fail("{}: {} holds {} Gaussians, POSITION announces {}", source_, kSpzExtension,
             unpacked.cloud.size(), announced);
    }
    flip_axes(unpacked.cloud, 0, unpacked.cloud.size(), kTurnAboutZ);
    auto splats = std::make_shared<GltfSplats>();
    splats->count = unpacked.cloud.size();
    splats->degree = unpacked.cloud.sh_degree;
    splats->cloud = std::make_shared<GaussianCloud>(std::move(unpacked.cloud));
    return splats;
  }

  std::shared_ptr<GltfSplats> bind(const tinygltf::Primitive& primitive) {
    auto splats = std::make_shared<GltfSplats>();
    const auto numbers = [&](const std::string& name, std::size_t components) {
      const auto found = primitive.attributes.find(name);
      if (found == primitive.attributes.end()) fail("{}: attribute {} is missing", source_, name);
      GltfNumbers result = file_.numbers(found->second, components, name);
      if (splats->count == 0) splats->count = result.count;
      if (result.count != splats->count)
        fail("{}: {} has {} elements, POSITION {}", source_, name, result.count, splats->count);
      return result;
    };
    // The name of the extension, or the name in the draft of 2024 if the file has only that.
    const auto name_of = [&](const std::string& name) {
      const bool old = primitive.attributes.count("_" + name) > 0 &&
                       primitive.attributes.count(attribute_name(name)) == 0;
      return old ? "_" + name : attribute_name(name);
    };
    splats->positions = numbers("POSITION", 3);
    splats->rotations = numbers(name_of("ROTATION"), 4);
    splats->scales = numbers(name_of("SCALE"), 3);
    const bool draft = is_draft(primitive);
    if (draft) {
      splats->colors = numbers("COLOR_0", 4);
      warn_once(
          "Colours and opacities come from COLOR_0, as in drafts of the glTF extension before it "
          "was ratified.");
    } else {
      splats->opacities = numbers(attribute_name("OPACITY"), 1);
    }
    int stored = 0;
    const auto sh_name = [](int degree, int coefficient) {
      return attribute_name(fmt::format("SH_DEGREE_{}_COEF_{}", degree, coefficient));
    };
    while (stored < kMaxStoredDegree && primitive.attributes.count(sh_name(stored + 1, 0)) > 0)
      ++stored;
    splats->degree = kept_sh_degree(sh_coefficient_count(stored) - 1, scene_);
    for (int degree = draft ? 1 : 0; degree <= splats->degree; ++degree)
      for (int k = 0; k < 2 * degree + 1; ++k) splats->sh.push_back(numbers(sh_name(degree, k), 3));
    splats->scales_are_logarithms = are_logarithms(splats->scales);
    if (splats->scales_are_logarithms)
      warn_once(
          "Scales are logarithms, as in drafts of the glTF extension before it was ratified; they "
          "were read as such.");
    return splats;
  }

  [[noreturn]] void complain_about_nothing() const {
    for (const std::string& name : file_.model().extensionsUsed)
      if (name == kWithdrawn)
        fail("{}: Gaussians of the withdrawn draft {}, which cannot be read", source_, name);
    fail("{}: not a splat file: no mesh of its scene has the extension {}", source_, kExtension);
  }

  std::filesystem::path path_;
  std::string source_;
  ThreadPool& pool_;
  Scene& scene_;
  GltfFile file_;
  std::map<std::pair<std::size_t, std::size_t>, std::shared_ptr<const GltfSplats>> splats_;
  std::vector<Instance> instances_;
  CloudParts parts_;  // the instances
  std::size_t others_ = 0;
};

}  // namespace

bool recognises_gltf(ByteSpan content, const std::filesystem::path&) {
  return is_glb(content) || json_kind(text_of(content)) == JsonKind::gltf;
}

void read_gltf(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
               const ReadOptions& options, Scene& scene) {
  GltfScene gltf(content, path, pool, scene);
  options.progress.update(0.1f);
  scene.axes = "LUF";
  scene.format = gltf.file().is_binary() ? "glb" : "gltf";
  scene.file_bytes += gltf.file().bytes_outside();
  gltf.read(options.progress);
}

}  // namespace qs
