// SPDX-License-Identifier: MIT
//
// Where the meshes of a glTF scene stand.
#pragma once

#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "io/scene/tinygltf.h"

namespace qs {

struct PlacedMesh {
  std::size_t mesh = 0;  ///< exists in the model
  int node = -1;         ///< for messages
  glm::dmat4 world_from_mesh{1};
};

/// The meshes of the default scene, or else of all nodes, or else all meshes as they are. Nodes are
/// walked without recursion. Throws Error(input) "source: ..." when they form no tree.
std::vector<PlacedMesh> placed_meshes(const tinygltf::Model& model, const std::string& source);

}  // namespace qs
