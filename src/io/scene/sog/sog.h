// SPDX-License-Identifier: MIT
//
// SOG (PlayCanvas), versions 1 and 2: meta.json and WebP pictures, in a folder or zipped; and
// streamed SOG: lod-meta.json, a tree whose leaves are parts of several SOG scenes. Its finest
// level is read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/parallel.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/scene.h"

namespace qs {

RecogniseScene recognises_sog, recognises_streamed_sog;
ReadScene read_sog, read_streamed_sog;

/// Writes version 2 in a zip, along a Morton curve. Scales, colours and SH are entries of codebooks
/// of 256 values; the SH of a Gaussian are one of at most 65,536 vectors. Throws Error(input) for
/// more Gaussians than WebP pictures hold.
WriteScene write_sog;

}  // namespace qs
