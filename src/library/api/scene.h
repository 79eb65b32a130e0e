// SPDX-License-Identifier: MIT
//
// A scene in a context, with the renderer that draws it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/cloud/scene.h"
#include "library/check/context.h"
#include "quadsplat/quadsplat.h"
#include "raster/api/renderer.h"

namespace qs::library {

/// Everything that a handle stands for.
class OpenScene {
 public:
  OpenScene(std::shared_ptr<Context> context, Scene scene, std::vector<std::size_t> not_drawn);

  Context& context() const { return *context_; }
  const GaussianCloud& cloud() const { return scene_->cloud; }
  const std::filesystem::path& path() const { return scene_->path; }
  QsSceneFacts facts() const;

  /// The renderer with the uploaded scene. The first call uploads it. Throws Error and Cancelled.
  Renderer& renderer(const std::stop_token& stop);

  /// True if the numbers of Gaussians are their indices in the cloud.
  bool keeps_numbers() const { return numbers_.empty(); }
  /// Replaces indices in the cloud by numbers.
  std::vector<std::uint32_t> numbers_of(const std::vector<std::uint32_t>& indices) const;
  /// The index in the cloud of a Gaussian's number; nullopt: it is not drawn.
  std::optional<std::size_t> index_of(std::size_t number) const;

  // The lists of the last qs_lists(), if they are not the renderer's.
  std::vector<std::uint32_t> visible, listed;

 private:
  std::shared_ptr<Context> context_;  // outlives the renderer
  std::shared_ptr<const Scene> scene_;
  std::size_t not_drawn_ = 0;
  std::vector<std::uint32_t> numbers_;          // per Gaussian of the cloud; empty: their indices
  std::string path_, cameras_path_, warnings_;  // behind QsSceneFacts
  bool white_background_ = false;
  glm::vec3 low_{0.0f}, high_{0.0f};
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace qs::library

struct QsSceneHandle {
  qs::library::OpenScene scene;
};
