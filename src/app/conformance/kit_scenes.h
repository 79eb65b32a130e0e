// SPDX-License-Identifier: MIT
//
// The scenes of the conformance kit: small clouds that each test one rule of 3DGS.
// To add a scene: a function and a row of kScenes in kit_scenes.cpp. The tests run for every row.
#pragma once

#include <filesystem>
#include <span>

#include "raster/api/renderer.h"

namespace qs {

/// A scene with its camera. Its truth is the image of mode `reference`.
struct KitView {
  GaussianCloud cloud;
  Camera camera;
  RenderSettings settings;  ///< only the background differs from the default
};

struct KitScene {
  const char* name;  ///< the beginning of its files' names
  const char* what;  ///< the rule that it tests, a clause
  KitView (*make)();
};

std::span<const KitScene> kit_scenes();

/// The truth: the image of mode `reference` of a view.
Image truth_of(const KitView& view, ThreadPool& pool);

/// Writes the kit as files that other software reads into a new folder: for every scene NAME.ply,
/// NAME.cameras.json and in `truth` NAME.png and NAME.pfm, and kit.json with sizes, matrices and
/// backgrounds. Throws Error(input).
void write_kit(const std::filesystem::path& folder, ThreadPool& pool,
               const Progress& progress = {});

}  // namespace qs
