// SPDX-License-Identifier: MIT
//
// Reads .splat (antimatter15): rows of 32 bytes without a header: position and linear scale as
// floats, colour and opacity as four bytes, the quaternion w, x, y, z as bytes (v - 128) / 128. The
// format has no magic number; files are recognised by values that are plausible only in such rows.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "base/parallel.h"
#include "io/cloud/scene.h"

namespace qs {

bool recognises_splat(std::span<const std::byte> content, const std::filesystem::path& path);
void read_splat(std::span<const std::byte> content, const std::filesystem::path& path,
                ThreadPool& pool, const ReadOptions& options, Scene& scene);

}  // namespace qs
