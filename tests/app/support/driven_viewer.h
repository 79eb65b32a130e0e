// SPDX-License-Identifier: MIT
//
// A viewer without a window: actions change its state as in the loop, and a host records their
// requests.
#pragma once

#include <cmath>

#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/camera_actions.h"
#include "support/recording_host.h"

namespace qs::test {

inline ViewedScene some_scene(int cameras) {
  ViewedScene scene;
  scene.path = "/data/garden.ply";
  scene.name = "garden";
  scene.core = {glm::vec3(-1), glm::vec3(1)};
  scene.smallest_radius = 0.01f;
  scene.framing.eye = {0, -1, -4};
  scene.gaussians = 500;
  scene.sh_degree = 3;
  for (int i = 0; i < cameras; ++i) {
    scene.cameras.push_back(
        look_at({3.0 * std::sin(i), -1, -3.0 * std::cos(i)}, {0, 0, 0}, {0, -1, 0}, 1, 800, 600));
  }
  return scene;
}

// A viewer with its host, driven as the loop does it.
struct Driven : RecordingHost {
  ViewerStore store{Viewer()};
  const Viewer& viewer = store.viewer();

  template <class Function, class... Arguments>
  void apply(Function function, Arguments... arguments) {
    store.apply(call(function, std::move(arguments)...), *this);
  }
  void press(const std::string& key) {
    const KeyPress press = parse_key(key);
    store.apply(find_key_command(press.key, press.mods)->action, *this);
  }
  void apply_all(const Actions& actions) {
    for (const Action& action : actions) store.apply(action, *this);
  }
};

struct DrivenScene : Driven {
  explicit DrivenScene(int cameras) {
    apply(action::resize, 640, 480);
    apply(action::scene_opened, OpenedScene{some_scene(cameras), RenderSettings(), Backend::cpu});
  }
};

}  // namespace qs::test
