// SPDX-License-Identifier: MIT
//
// The render thread's part of opening a scene: it draws a sample, uploads the scene, and shows it.
#pragma once

#include <functional>
#include <memory>

#include "app/viewer/render/render_context.h"
#include "app/viewer/state/actions.h"
#include "app/viewer/state/crop_actions.h"

namespace qs {

/// Uploads a scene and shows it in the place of the scene in the window.
struct UploadOrder {
  std::shared_ptr<const Scene> scene;
  ViewedScene facts;
  RenderSettings settings;
  Backend backend = Backend::cpu;
};

/// The settings that a scene opens with: `settings`, but with the model's background unless
/// `keep_background`.
RenderSettings settings_for(const ViewedScene& facts, RenderSettings settings,
                            bool keep_background);

/// Shows a picture of a sample, whose cloud it takes, in the view that the scene will open with.
/// Draws on the CPU with any backend, because a separate CPU renderer is made quickly. Throws Error
/// and Cancelled.
void draw_sample(RenderContext& context, SceneSample& sample, FrameRequest request);

/// The old scene leaves the backend's memory first, because both may not fit; it returns if the new
/// scene fails. Throws Error and Cancelled, and then the old scene is still shown.
OpenedScene show_scene(RenderContext& context, const UploadOrder& order, const Progress& progress);
/// Shows a scene beside the scene in the window.
SceneBeside show_beside(RenderContext& context, const std::shared_ptr<const Scene>& scene,
                        Backend backend, const Progress& progress);

/// Progress of an upload that the window shows.
Progress upload_progress(RenderContext& context, const Scene& scene);

/// A renderer with the scene; of the session's scene it draws what the session draws. Throws Error
/// and Cancelled.
std::unique_ptr<Renderer> upload_to(RenderContext& context,
                                    const std::shared_ptr<const Scene>& scene, Backend backend,
                                    const Progress& progress);

/// Uploads a scene to a renderer, and again without the other renderers if memory is short; these
/// are made again when they are needed. Throws Error and Cancelled, and then the renderer has its
/// old scene.
void upload_making_room(RenderContext& context, Renderer& renderer,
                        const std::shared_ptr<const Scene>& scene, const Progress& progress);

/// Replaces the session's renderer by upload(backend). The old renderer goes first, because both
/// may not fit into memory, and upload(the old backend) makes it again if the new one fails. Throws
/// what `upload` throws.
void change_renderer(Session& session, Backend backend,
                     const std::function<std::unique_ptr<Renderer>(Backend)>& upload);

/// The renderer of RenderContext::beside on the session's backend, to which it is uploaded again
/// after a change of the backend. Throws Error and Cancelled.
Renderer& renderer_beside(RenderContext& context);

/// Shows the scene as requested and reports crop_shown(). If that fails, the window keeps the old
/// picture, and crop_failed() is reported.
Job show_crop(const CropRequest& request);
}  // namespace qs
