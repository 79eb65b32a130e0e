// SPDX-License-Identifier: MIT
//
// What the render thread does besides frames: opens scenes, finds the point under the cursor,
// writes pictures and measurements. Each reports its outcome as actions; what it throws becomes a
// sentence in the window.
#pragma once

#include "app/viewer/render/render_thread.h"
#include "app/viewer/render/scene_loader.h"

namespace qs {

/// Uploads to a new renderer first, so that a scene that does not fit leaves the old one on show.
/// `settings` are used as they are but for the background, which is the file's unless it was
/// chosen.
Job open_scene(LoadedScene loaded, Backend backend, RenderSettings settings, bool keep_background);

/// Uploads the scene on show to another backend.
Job switch_backend(Backend backend);

Job pick_pivot(FrameOrder order, glm::ivec2 pixel);

/// Into screenshots/SCENE_CAMERA_MODE_WxH_NNNN.png below `folder`, never over a file.
Job take_screenshot(FrameOrder order, std::string camera_name, std::filesystem::path folder);

/// From this view to what is seen at `pixel`, all modes, saved in zoom/SCENE_NNNN below `folder`.
Job record_zoom_from(FrameOrder order, glm::ivec2 pixel, std::filesystem::path folder);

/// All modes with bench's plan, saved in bench/SCENE_NNNN below `folder`.
Job bench_view(FrameOrder order, std::string camera_name, std::filesystem::path folder);

/// What makes a pixel, and the construction of one of its Gaussians.
Job inspect_view(FrameOrder order, glm::ivec2 pixel, std::optional<std::uint32_t> gaussian);

/// Compares the view, or a part of it, with the fp64 reference, which takes seconds. The
/// reference's image is kept, and shown at once when the order has it beside the view.
Job ask_oracle_about(FrameOrder order, std::optional<PixelBox> region);

/// FOLDER/STEM_0001ENDING, the first number that does not exist yet.
std::filesystem::path free_name(const std::filesystem::path& folder, const std::string& stem,
                                const std::string& ending);

}  // namespace qs
