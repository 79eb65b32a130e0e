// SPDX-License-Identifier: MIT
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "base/fail.h"
#include "io/scene/gltf/gltf_file.h"

namespace qs {
namespace {

std::size_t checked(int index, std::size_t count, const char* what, const std::string& source) {
  if (index < 0 || static_cast<std::size_t>(index) >= count)
    fail("{}: {} {} does not exist", source, what, index);
  return static_cast<std::size_t>(index);
}

glm::dmat4 parent_from_node(const tinygltf::Node& node, int number, const std::string& source) {
  const auto has = [&](const std::vector<double>& values, std::size_t count, const char* what) {
    if (!values.empty() && values.size() != count)
      fail("{}: node {}: {} has {} numbers instead of {}", source, number, what, values.size(),
           count);
    return !values.empty();
  };
  glm::dmat4 matrix(1);
  if (has(node.matrix, 16, "matrix")) {
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
    return matrix;
  }
  if (has(node.translation, 3, "translation")) {
    const auto& t = node.translation;
    matrix = glm::translate(matrix, glm::dvec3(t[0], t[1], t[2]));
  }
  if (has(node.rotation, 4, "rotation")) {
    const auto& r = node.rotation;  // x y z w
    matrix *= glm::mat4_cast(glm::normalize(glm::dquat(r[3], r[0], r[1], r[2])));
  }
  if (has(node.scale, 3, "scale")) {
    const auto& s = node.scale;
    matrix = glm::scale(matrix, glm::dvec3(s[0], s[1], s[2]));
  }
  return matrix;
}

// The root nodes of the default scene; without scenes, all nodes that are not a child of another
// node.
std::vector<int> root_nodes(const tinygltf::Model& model, const std::string& source) {
  if (!model.scenes.empty()) {
    const int scene = model.defaultScene < 0 ? 0 : model.defaultScene;
    return model.scenes[checked(scene, model.scenes.size(), "scene", source)].nodes;
  }
  std::vector<bool> is_child(model.nodes.size());
  for (const tinygltf::Node& node : model.nodes)
    for (const int child : node.children)
      is_child[checked(child, model.nodes.size(), "node", source)] = true;
  std::vector<int> roots;
  for (std::size_t i = 0; i < is_child.size(); ++i)
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  return roots;
}

}  // namespace

std::vector<PlacedMesh> placed_meshes(const tinygltf::Model& model, const std::string& source) {
  std::vector<PlacedMesh> placed;
  if (model.nodes.empty()) {
    for (std::size_t i = 0; i < model.meshes.size(); ++i) placed.push_back({i, -1, glm::dmat4(1)});
    return placed;
  }
  struct Visit {
    int node;
    glm::dmat4 world_from_parent;
  };
  std::vector<Visit> pending;
  for (const int root : root_nodes(model, source)) pending.push_back({root, glm::dmat4(1)});
  std::vector<bool> visited(model.nodes.size());
  while (!pending.empty()) {
    const Visit visit = pending.back();
    pending.pop_back();
    const std::size_t index = checked(visit.node, model.nodes.size(), "node", source);
    if (visited[index]) fail("{}: its nodes are no tree: node {} is met twice", source, index);
    visited[index] = true;
    const tinygltf::Node& node = model.nodes[index];
    const glm::dmat4 world = visit.world_from_parent * parent_from_node(node, visit.node, source);
    if (node.mesh >= 0)
      placed.push_back(
          {checked(node.mesh, model.meshes.size(), "mesh", source), visit.node, world});
    for (const int child : node.children) pending.push_back({child, world});
  }
  return placed;
}

}  // namespace qs
