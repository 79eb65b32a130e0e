// SPDX-License-Identifier: MIT
//
// Reads any splat file or model directory. reader.cpp has one row of kReaders per format. To add a
// format: write NAME.cpp with a recognise and a read function, declare them in the header of its
// folder, add the row and a test;
// command line, help, tests and fuzzing walk the table. Every size is checked in 64 bits against
// the bytes left before anything is allocated.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string_view>

#include "base/parallel.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/scene.h"

namespace qs {

struct LodPages;
struct PageSource;

/// One file format.
struct ReaderRow {
  const char* name;        ///< "ply"
  const char* extensions;  ///< ".ply", space separated
  const char* summary;
  const char* axes;        ///< default frame of its values: "RDF"
  const char* sh_degrees;  ///< SH degrees that are read: "0-3"
  const char* limits;      ///< content that is refused or lost
  RecogniseScene* recognises;
  ReadScene* read;
};

/// All readable formats; content decides, the extension breaks ties.
std::span<const ReaderRow> readers();

/// Reads a splat file, or the highest (or chosen) point_cloud/iteration_*/point_cloud.ply of a
/// model directory. All work is done in `pool`. Throws Error(input) with one sentence "path: what",
/// and Cancelled.
Scene read_scene(const std::filesystem::path& path, ThreadPool& pool,
                 const ReadOptions& options = {});

/// Reinterprets the scene as if its file had declared the frame `axes`, for files that declare no
/// frame or a wrong one. Throws Error(usage) unless is_axes(axes).
void assume_axes(Scene& scene, std::string_view axes);

/// True if a tree of so many nodes is read page by page.
bool is_streamed(const ReadOptions& options, std::uint64_t nodes);

/// Sets the stream of a scene whose tree has page 0 in memory. Its cloud becomes the finest nodes
/// of that page.
void set_stream(LodPages tree, PageSource source, const ReadOptions& options, ThreadPool& pool,
                Scene& scene);

/// The scene file of FOLDER/iteration_N, point_cloud.ply for most, by N, in increasing order: 30000
/// comes after 7000.
std::map<int, std::filesystem::path> find_iterations(const std::filesystem::path& folder);

/// The scene file for `path`: `path` itself, or the file inside a model directory.
std::filesystem::path find_scene_file(const std::filesystem::path& path, int iteration = -1);

/// True if a reader's files have this ending, such as ".ply".
bool reads_ending(const std::string& ending);

/// True if find_scene_file() finds a file.
bool holds_scene(const std::filesystem::path& path);

}  // namespace qs
