// SPDX-License-Identifier: MIT
#include "app/cli/bench_plugins.h"

#include <algorithm>

#include "app/measure/scene_facts.h"
#include "app/report/environment.h"
#include "base/fail.h"
#include "io/bytes/file_hash.h"

namespace qs {

BenchPlugins::BenchPlugins(const std::vector<std::filesystem::path>& libraries, int timeout_s,
                           const Session& session, std::string scene,
                           nlohmann::ordered_json& environment)
    : scene_(std::move(scene)), environment_(environment) {
  for (const std::filesystem::path& library : libraries) {
    auto renderer = std::make_unique<PluginRenderer>(
        PluginOptions{library, session.device, timeout_s}, *session.pool);
    try {
      renderer->upload(cloud_of(session.scene), {});
      plugins_.push_back({unique(renderer->name()), library, std::move(renderer)});
    } catch (const Error& error) {
      add_problem(fmt::format("{}: {}", scene_, error.what()));
    }
  }
}

// A row is found by its name. So plugins of the same name are numbered, and no plugin has the name
// of a mode.
std::string BenchPlugins::unique(const std::string& name) const {
  std::string result = name;
  for (int number = 2; find(result) != nullptr || find_culler(result) >= 0; ++number)
    result = fmt::format("{}-{}", name, number);
  return result;
}

std::vector<Guest> BenchPlugins::guests() const {
  std::vector<Guest> guests;
  for (const Plugin& plugin : plugins_)
    if (plugin.renderer->usable()) guests.push_back({plugin.name, plugin.renderer.get()});
  return guests;
}

Renderer* BenchPlugins::find(const std::string& name) const {
  const auto plugin = std::ranges::find(plugins_, name, &Plugin::name);
  return plugin == plugins_.end() ? nullptr : plugin->renderer.get();
}

void BenchPlugins::note(const std::string& camera, const std::string& problem) {
  add_problem(fmt::format("{}, camera {}: {}", scene_, camera, problem));
}

void BenchPlugins::close() {
  for (const Plugin& plugin : plugins_) {
    const PluginRenderer& renderer = *plugin.renderer;
    if (renderer.frames() > 0)
      add_line(
          environment_, "plugins",
          plugin_line(
              {plugin.name, renderer.description(),
               fmt::format("{}, {}", plugin.library.filename().string(), file_hash(plugin.library)),
               renderer.measures_itself(), renderer.on_device(), scene_, renderer.call_factor()}));
    try {
      plugin.renderer->close();
    } catch (const Error& error) {
      add_problem(fmt::format("{}: {}", scene_, error.what()));
    }
  }
}

void BenchPlugins::add_problem(const std::string& sentence) {
  add_line(environment_, "plugin_problems", sentence);
  warn("warning: " + sentence);
}

}  // namespace qs
