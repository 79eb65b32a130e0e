// SPDX-License-Identifier: MIT
//
// Reads .spz (Niantic), versions 1 to 4: quantised attributes in six blocks, compressed as one gzip
// member (1-3) or one zstd frame per block (4). Files store RUB axes unless an extension names
// another frame; files that store RDF without declaring it cannot be detected. Source: README.md
// and load-spz.cc of nianticlabs/spz; the code is our own.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/parallel.h"
#include "io/cloud/scene.h"

namespace qs {

bool recognises_spz(std::span<const std::byte> content, const std::filesystem::path& path);
void read_spz(std::span<const std::byte> content, const std::filesystem::path& path,
              ThreadPool& pool, const ReadOptions& options, Scene& scene);

}  // namespace qs
