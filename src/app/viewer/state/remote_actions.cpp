// SPDX-License-Identifier: MIT
#include "app/viewer/state/remote_actions.h"

#include <cmath>

#include <fmt/format.h>

#include "app/viewer/state/actions.h"
#include "base/fail.h"
#include "base/text.h"

namespace qs {
namespace {

constexpr float kAssumedRadius = 4;  ///< of a scene about which nothing is known, world units

// Trainers place the cameras of a capture around the origin, with y down.
ViewedScene remote_scene(const std::string& address, const std::vector<Camera>& cameras) {
  ViewedScene scene;
  scene.path = address;
  scene.name = address;
  scene.format = "a training in another program";
  scene.core = {glm::vec3(-kAssumedRadius), glm::vec3(kAssumedRadius)};
  scene.smallest_radius = 1;
  scene.framing.eye = {0, -0.25 * kAssumedRadius, -kAssumedRadius};
  scene.cameras = cameras;
  use_cameras(scene);
  return scene;
}

bool is_count(double number) { return number >= 0 && number < 1e15; }

}  // namespace

std::string remote_state(const RemoteRun& run) {
  if (!run.problem.empty()) return run.problem;
  if (!run.is_answering) return "connecting";
  return run.paused ? "paused" : "running";
}

std::vector<Fact> remote_facts(const Viewer& viewer) {
  if (!viewer.remote) return {};
  const RemoteRun& run = *viewer.remote;
  std::vector<Fact> facts = {{"training at", run.address}, {"state", remote_state(run)}};
  if (!run.source.empty()) facts.push_back({"its data", run.source});
  if (run.metrics.gaussians && is_count(*run.metrics.gaussians))
    facts.push_back({"Gaussians", grouped(static_cast<std::uint64_t>(*run.metrics.gaussians))});
  if (run.metrics.loss) facts.push_back({"loss", fmt::format("{:.4f}", *run.metrics.loss)});
  if (run.pictures > 0)
    facts.push_back({"pictures", grouped(static_cast<std::uint64_t>(run.pictures))});
  return facts;
}

void require_scene(const Viewer& viewer) {
  if (viewer.remote)
    fail(ErrorKind::usage,
         "this window shows a training in another program, of which it has pictures only");
}

namespace action {

void remote_opened(Viewer& v, Host& host, const std::string& address,
                   const std::vector<Camera>& cameras) {
  const std::vector<std::filesystem::path> recent = v.recent;
  scene_opened(v, host, {remote_scene(address, cameras), v.settings, v.backend});
  v.recent = recent;  // it is no file
  v.remote = RemoteRun();
  v.remote->address = address;
  v.panels.training = true;
  v.panels.hud = false;
}

void remote_reported(Viewer& v, const RemoteRun& run) {
  if (!v.remote) return;
  const bool is_new = !run.problem.empty() && run.problem != v.remote->problem;
  v.remote = run;
  if (v.scene && run.metrics.gaussians && is_count(*run.metrics.gaussians))
    v.scene->gaussians = static_cast<std::uint64_t>(*run.metrics.gaussians);
  if (is_new) notify_error(v, run.problem);
}

}  // namespace action
}  // namespace qs
