// SPDX-License-Identifier: MIT
//
// Writes a cloud in any writable format; one row of writers() per format.
// To add a format: a write function in the format's own file, its row in writer.cpp, its round-trip
// test.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "raster/base/parallel.h"
#include "raster/base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

struct WriterRow {
  const char* name;       ///< "ply"
  const char* extension;  ///< ".ply"
  const char* summary;
  const char* axes;    ///< of its values: "RDF"
  int max_sh_degree;   ///< that it can hold
  const char* losses;  ///< what is lost
  void (*write)(const GaussianCloud& cloud, const std::filesystem::path& path, ThreadPool& pool,
                const Progress& progress);
};

std::span<const WriterRow> writers();

/// Writes the first format with the extension of `path`, or the one called `format`, and tells
/// which one that was; the file appears whole or not at all. Throws Error(usage) for an unknown
/// extension or name, Error(input) when the file cannot be written.
const WriterRow& write_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                             ThreadPool& pool, const Progress& progress = {},
                             std::string_view format = {});

}  // namespace qs
