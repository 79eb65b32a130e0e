// SPDX-License-Identifier: MIT
//
// The plugins of `bench --plugin` on one scene: opens them, and records each failure as a sentence
// in the report's environment and on stderr. No failure of a plugin ends the benchmark.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/measure/measure.h"
#include "app/plugin/plugin_renderer.h"
#include "app/session/session.h"

namespace qs {

class BenchPlugins {
 public:
  /// Opens the session's scene in every library. `environment` must outlive this object.
  BenchPlugins(const std::vector<std::filesystem::path>& libraries, int timeout_s,
               const Session& session, std::string scene, nlohmann::ordered_json& environment);

  /// The plugins that can be measured on the next view.
  std::vector<Guest> guests() const;

  /// The renderer of a plugin's row, null for the name of a mode.
  Renderer* find(const std::string& name) const;

  /// Records a problem of a plugin on a camera.
  void note(const std::string& camera, const std::string& problem);

  /// Closes the scene and records the facts of the plugins that rendered.
  void close();

 private:
  struct Plugin {
    std::string name;  ///< unique in the tables
    std::filesystem::path library;
    std::unique_ptr<PluginRenderer> renderer;
  };

  std::string unique(const std::string& name) const;
  void add_problem(const std::string& sentence);

  std::string scene_;
  nlohmann::ordered_json& environment_;
  std::vector<Plugin> plugins_;
};

}  // namespace qs
