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

bool recognises_sog(ByteSpan content, const std::filesystem::path& path);
void read_sog(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene);

bool recognises_streamed_sog(ByteSpan content, const std::filesystem::path& path);
void read_streamed_sog(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                       const ReadOptions& options, Scene& scene);

}  // namespace qs
