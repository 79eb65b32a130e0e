// SPDX-License-Identifier: MIT
//
// Opens any splat file or model directory. One row of kReaders per format, in reader.cpp.
// To add a format: write NAME.h/.cpp with a recognise and a read function, add its row, add its
// test; command line, help and tests walk the table.
// Every size is checked in 64 bits against the bytes left before anything is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "raster/base/parallel.h"
#include "raster/base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A cloud and what its file says about it.
struct Scene {
  GaussianCloud cloud;
  std::filesystem::path
      path;            ///< the file that was read (inside a model directory, the one chosen)
  std::string format;  ///< name of the reader's row, with a variant: "ply, binary little endian"
  std::vector<std::string> warnings;  ///< whole sentences: what was dropped or assumed
  std::string axes = "RDF";      ///< of the values in the file, one of kAxes; the cloud has RDF
  std::string vertical_axis;     ///< from the file ("y", "-z", ...), empty when it says nothing
  std::uint64_t file_bytes = 0;  ///< of all files that were read
  double unpack_ms = 0;  ///< time until values could be filled in: headers, decompression, memory
  double fill_ms = 0;    ///< time of filling them in and checking them
};

struct ReadOptions {
  int iteration = -1;  ///< of a model directory: point_cloud/iteration_N; -1 = the highest
  std::string axes =
      {};  ///< one of kAxes: what the file's axes are, whatever it says; empty: it is right
  Progress progress = {};
};

/// One file format. Both functions get the file's whole content (memory-mapped) and its path, which
/// is used in messages and for the extension.
struct ReaderRow {
  const char* name;        ///< "ply"
  const char* extensions;  ///< ".ply", space separated
  const char* summary;
  const char* axes;        ///< of its values, when it says nothing else: "RDF"
  const char* sh_degrees;  ///< that it can hold: "0-3"
  const char* limits;      ///< what is refused, what is lost
  bool (*recognises)(std::span<const std::byte> content, const std::filesystem::path& path);
  void (*read)(std::span<const std::byte> content, const std::filesystem::path& path,
               ThreadPool& pool, const ReadOptions& options, Scene& scene);
};

/// All readable formats; content decides, the extension breaks ties.
std::span<const ReaderRow> readers();

/// Reads a splat file, or of a model directory its highest (or chosen)
/// point_cloud/iteration_*/point_cloud.ply. Throws Error(input) with one sentence "path: what" and
/// Cancelled.
Scene read_scene(const std::filesystem::path& path, ThreadPool& pool,
                 const ReadOptions& options = {});

/// Turns the scene as if its file had said that its values are in `axes`, one of kAxes: some
/// writers lie about that, or do not say it. Throws Error(usage) for another name.
void assume_axes(Scene& scene, std::string_view axes);

/// The scene file that `path` stands for: itself, or the one inside a model directory.
std::filesystem::path find_scene_file(const std::filesystem::path& path, int iteration = -1);

}  // namespace qs
