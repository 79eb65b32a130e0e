// SPDX-License-Identifier: MIT
//
// Instances of a tree as one tree. They share the pages of the file of that tree, whose nodes are
// placed when they are used, so a billion Gaussians need no more disk and memory than one of the
// instances. The tree over the instances is made when the file is opened.
#pragma once

#include "io/scene/reader.h"

namespace qs {

/// Opens the file at Scene::path as Scene::stream, if it has instances of a .rad file that
/// `quadsplat lod` wrote and ReadOptions::streams asks for it. Otherwise returns false. Throws
/// Error(input).
bool stream_instances(const ReadOptions& options, ThreadPool& pool, Scene& scene);

}  // namespace qs
