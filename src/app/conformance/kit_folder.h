// SPDX-License-Identifier: MIT
//
// Writes the conformance kit as files that other software reads.
#pragma once

#include <filesystem>

#include "app/conformance/kit_scenes.h"

namespace qs {

/// The truth: the image of mode `reference` of a view.
Image truth_of(const KitView& view, ThreadPool& pool);

/// Writes into a new folder for every scene NAME.ply, NAME.cameras.json and in `truth`
/// NAME.png and NAME.pfm, and kit.json with sizes, matrices and backgrounds. Throws Error(input).
void write_kit(const std::filesystem::path& folder, ThreadPool& pool,
               const Progress& progress = {});

}  // namespace qs
