// SPDX-License-Identifier: MIT
//
// Instances of a scene: a small JSON file that names a scene beside it and lists similarity
// transforms in RDF axes.
//   {"version": 1, "scene": "plush.spz", "instances": [
//     {"position": [0, 0, 4], "rotation": [1, 0, 0, 0], "scale": 1.5, "tint": [1, 0.9, 0.8]}]}
// A point p of the scene is at position + scale * rotation(p); `rotation` is w, x, y, z. `tint`
// multiplies the colours. Members of an instance may be missing.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "io/cloud/scene.h"

namespace qs {

struct Instance {
  glm::dvec3 position{0};           ///< world units
  glm::dquat rotation{1, 0, 0, 0};  ///< unit length
  double scale = 1;                 ///< 1e-9 to 1e9
  glm::vec3 tint{1};                ///< factors of the colours, 0 to 1000
};

/// Moves points that count from the origin `from` of the scene to the instance, where they count
/// from the origin `to`.
glm::dmat4 matrix_of(const Instance& instance, const glm::dvec3& from,
                     const glm::dvec3& to = glm::dvec3(0));

/// Writes the Gaussians of `source`, transformed by `instance`, to `cloud` from place `first` on.
/// Both have the same SH degree; positions of `cloud` count from its own origin.
void place_instance(const GaussianCloud& source, const Instance& instance, GaussianCloud& cloud,
                    std::size_t first, ThreadPool& pool);

/// A file of instances.
struct InstanceList {
  std::filesystem::path path, scene;  ///< of the file, and of the scene that it names
  std::vector<Instance> instances;
  std::vector<std::string> warnings;
};

InstanceList read_instance_list(std::span<const std::byte> content,
                                const std::filesystem::path& path);

/// A file of instances, and the scene that it names.
struct InstanceFile : InstanceList {
  Scene one;
};

InstanceFile open_instances(std::span<const std::byte> content, const std::filesystem::path& path,
                            ThreadPool& pool, const ReadOptions& options);

/// Instances [begin, end) as a scene. The origin is the same for each range. Reports progress from
/// 0.5 to 1. Throws as read_instances().
void fill_instances(const InstanceFile& file, std::size_t begin, std::size_t end, ThreadPool& pool,
                    const Progress& progress, Scene& scene);

RecogniseScene recognises_instances;
/// Reads the scene and all of its instances into one cloud. Throws Error(device) if that takes more
/// than half of the available memory, because a renderer keeps a copy.
ReadScene read_instances;

}  // namespace qs
