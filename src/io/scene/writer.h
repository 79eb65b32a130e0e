// SPDX-License-Identifier: MIT
//
// Writes a cloud in any writable format; writer.cpp has one row of kWriters per format. To add a
// format: write NAME_writer.cpp, declare its function in the header of its folder, add the row and
// a round-trip test.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "base/parallel.h"
#include "base/progress.h"
#include "io/cloud/scene.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

struct WriterRow {
  const char* name;       ///< "ply"
  const char* extension;  ///< ".ply"
  const char* summary;
  const char* axes;    ///< frame of its values: "RDF"
  int max_sh_degree;   ///< highest degree that the format stores
  const char* losses;  ///< rounding and omissions
  WriteScene* write;
  bool keeps_origin = false;  ///< it holds GaussianCloud::origin, in doubles
  /// A sentence about what this cloud loses beyond `losses`, or ""; null: nothing.
  std::string (*loss)(const GaussianCloud& cloud) = nullptr;
};

std::span<const WriterRow> writers();

/// The row called `format`, or else the first row with the extension of `path`; null without one.
const WriterRow* find_writer(const std::filesystem::path& path, std::string_view format = {});

/// Writes the format called `format`, or else the first format with the extension of `path`, and
/// returns its row. The file appears whole or not at all. Throws Error(usage) for an unknown
/// extension or name, Error(input) if the file cannot be written.
const WriterRow& write_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                             ThreadPool& pool, const Progress& progress = {},
                             std::string_view format = {});

/// Writes a .ply file that says that this program trained the model. Throws Error(input).
void write_trained_scene(const GaussianCloud& cloud, const std::filesystem::path& path,
                         ThreadPool& pool);

/// True if write_trained_scene() wrote the file.
bool is_trained_scene(const std::filesystem::path& path);

}  // namespace qs
