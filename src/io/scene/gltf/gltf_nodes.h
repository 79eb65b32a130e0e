// SPDX-License-Identifier: MIT
//
// The transforms of the meshes in a glTF scene.
#pragma once

#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "io/scene/gltf/tinygltf.h"

namespace qs {

struct PlacedMesh {
  std::size_t mesh = 0;  ///< a valid index into the model's meshes
  int node = -1;         ///< for messages
  glm::dmat4 world_from_mesh{1};
};

/// The meshes of the default scene. Without a default scene: the meshes of all nodes. Without
/// nodes: all meshes, untransformed. Nodes are walked without recursion. Throws Error(input)
/// "source: ..." if they do not form a tree.
std::vector<PlacedMesh> placed_meshes(const tinygltf::Model& model, const std::string& source);

}  // namespace qs
