// SPDX-License-Identifier: MIT
//
// The job that uploads a scene that was read and shows it.
#pragma once

#include <memory>

#include "app/viewer/state/action.h"
#include "io/scene/reader.h"

namespace qs {

/// A scene that was read, and its facts for the viewer.
struct LoadedScene {
  Scene scene;
  ViewedScene facts;
};

/// A sample of a scene that is being read, and the facts that the viewer shows of it.
struct ReadSample {
  SceneSample sample;
  ViewedScene facts;
};

/// A renderer with the scene; the window shows the progress. Throws Error and Cancelled.
std::unique_ptr<Renderer> upload_to(RenderContext& context,
                                    const std::shared_ptr<const Scene>& scene, Backend backend);

/// The renderer of RenderContext::beside on the session's backend, to which it is uploaded again
/// after a change of the backend. Throws Error and Cancelled.
Renderer& renderer_beside(RenderContext& context);

/// Uploads a scene to show beside the scene in the window.
Job open_beside(const std::shared_ptr<const Scene>& scene, Backend backend);

/// Uploads to a new renderer first, so that the old scene stays if the new scene does not fit.
/// `settings` are used unchanged, except that without `keep_background` the background is the
/// model's.
Job open_scene(const std::shared_ptr<LoadedScene>& loaded, Backend backend, RenderSettings settings,
               bool keep_background);

namespace action {

/// Runs open_scene() on the viewer's backend with its settings.
void scene_read(Viewer& viewer, Host& host, const std::shared_ptr<LoadedScene>& loaded,
                bool keep_background);

/// Runs open_beside() on the viewer's backend.
void beside_read(Viewer& viewer, Host& host, const std::shared_ptr<const Scene>& scene);

/// Shows a picture of the sample in the scene's first view, if no other scene is in the window. It
/// does not change the viewer.
void sample_read(Viewer& viewer, Host& host, const std::shared_ptr<ReadSample>& read,
                 bool keep_background);

}  // namespace action
}  // namespace qs
