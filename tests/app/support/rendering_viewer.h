// SPDX-License-Identifier: MIT
//
// A viewer with its render thread and a small scene, 96 x 64 pixels, without a window.
#pragma once

#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "app/viewer/commands/commands.h"
#include "app/viewer/commands/keys.h"
#include "app/viewer/render/frame_requests.h"
#include "app/viewer/render/render_thread.h"
#include "app/viewer/render/upload_scene.h"
#include "app/viewer/state/camera_actions.h"
#include "support/recording_host.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {

// The loop on the main thread without its window: jobs run, their reports change the viewer.
class RenderingViewer : public testing::Test, protected RecordingHost {
 protected:
  static FrameOptions one_thread() {
    FrameOptions options;
    options.threads = 1;
    return options;
  }

  RenderingViewer()
      : thread_(
            one_thread(), [] {}, nullptr) {
    Scene scene;
    scene.cloud = random_cloud(300, 1, 5);
    scene.path = scenes_ / "random scene.ply";
    write_scene(scene.cloud, scene.path);
    ViewedScene facts;
    facts.name = "random";
    facts.path = scene.path;
    facts.core = {glm::vec3(-1), glm::vec3(1)};
    apply(call(action::resize, 96, 64));
    show(std::move(scene), facts);
    apply(call(action::set_camera, front_camera(96, 64)));
    change([this](Viewer& viewer) { viewer.out_dir = scenes_.path(); });
    request_ = full_frame(viewer());
    request_.picture = -1;  // tests change the request, so its picture is not the viewer's
  }

  void run(Job job) override { thread_.run(std::move(job)); }
  void stop_job() override { thread_.stop_job(); }
  void leave_job(bool keeps) override { thread_.stop_job(keeps); }
  void save_results(const std::filesystem::path& folder) override {
    thread_.run([folder](RenderContext& context) { context.save_unsaved(folder); });
  }

  // Shows a scene with black behind it, as after reading.
  void show(Scene scene, const ViewedScene& facts, Backend backend = Backend::cpu) {
    const UploadOrder order{std::make_shared<const Scene>(std::move(scene)), facts,
                            settings_for(facts, viewer().settings, false), backend};
    thread_.run([order](RenderContext& context) {
      context.report(action::scene_opened, show_scene(context, order, {}));
    });
    settle();
  }
  void show_beside_it(std::shared_ptr<const Scene> scene) {
    const Backend backend = viewer().backend;
    thread_.run([scene = std::move(scene), backend](RenderContext& context) {
      context.report(action::beside_opened, show_beside(context, scene, backend, {}));
    });
    settle();
  }

  const Viewer& viewer() const { return store_.viewer(); }
  void apply(const Action& action) { store_.apply(action, *this); }
  void change(const std::function<void(Viewer&)>& edit) { apply(call(edit)); }
  void press(const std::string& key) {
    const KeyPress press = parse_key(key);
    apply(find_key_command(press.key, press.mods)->action);
  }
  void take_reports() {
    Actions reports;
    thread_.take_reports(reports);
    for (const Action& report : reports) apply(report);
  }

  // Until nothing runs; returns the newest frame.
  std::optional<RenderedFrame> settle() {
    std::optional<RenderedFrame> newest;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(120);
    while (std::chrono::steady_clock::now() < deadline) {
      take_reports();
      if (auto frame = thread_.take_frame()) newest = std::move(frame);
      if (!thread_.busy()) return newest;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ADD_FAILURE() << "the render thread does not come to rest";
    return newest;
  }

  std::optional<RenderedFrame> draw(const FrameRequest& request) {
    thread_.request(request);
    return settle();
  }

  TemporaryFolder scenes_;
  RenderThread thread_;
  FrameRequest request_;
  ViewerStore store_{Viewer()};
};

}  // namespace qs::test
