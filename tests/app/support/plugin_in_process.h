// SPDX-License-Identifier: MIT
//
// Draws with a plugin inside of the test's process: without the process of PluginRenderer, many
// small scenes take little time.
#pragma once

#include <filesystem>

#include "quadsplat/plugin.h"
#include "raster/api/renderer.h"

namespace qs::test {

class PluginInProcess {
 public:
  /// Loads a plugin for host memory that draws interleaved images. Throws std::runtime_error.
  explicit PluginInProcess(const std::filesystem::path& library);

  /// Opens the scene, draws one frame and closes the scene. Threads may call it at the same time if
  /// the plugin allows that. Throws std::runtime_error.
  Image draw(const GaussianCloud& cloud, const Camera& camera,
             const RenderSettings& settings) const;

 private:
  const QsPlugin* plugin_;
};

}  // namespace qs::test
