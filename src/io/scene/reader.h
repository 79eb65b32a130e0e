// SPDX-License-Identifier: MIT
//
// Reads any splat file or model directory. reader.cpp has one row of kReaders per format. To add a
// format: write NAME.h and NAME.cpp with a recognise and a read function, add the row and a test;
// command line, help, tests and fuzzing walk the table. Every size is checked in 64 bits against
// the bytes left before anything is allocated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "raster/base/parallel.h"
#include "raster/base/progress.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// A cloud and the facts its file states about it.
struct Scene {
  GaussianCloud cloud;
  std::filesystem::path
      path;            ///< the file that was read (inside a model directory, the one chosen)
  std::string format;  ///< name of the reader's row, with a variant: "ply, binary little endian"
  std::vector<std::string> warnings;  ///< one sentence each: values that were dropped or assumed
  std::string axes = "RDF";  ///< frame of the file's values, see axes.h; the cloud is always in RDF
  std::string declared_axes = "RDF";  ///< as the file or its format says; ReadOptions::axes differ
  std::string vertical_axis;     ///< as the file declares it ("y", "-z", ...); empty if it does not
  std::uint64_t file_bytes = 0;  ///< of all files that were read
  double unpack_ms = 0;          ///< headers, decompression and allocation
  double fill_ms = 0;            ///< conversion of the values into the cloud, with checks
};

/// Some Gaussians of a scene that is being read, for a picture before the rest is read.
struct SceneSample {
  Scene scene;           ///< its cloud has the base colour only; no warnings
  std::size_t step = 1;  ///< every step-th Gaussian of the file, from the first on
  std::size_t of = 0;    ///< Gaussians of the file
};

/// The distance between Gaussians of a sample of at most `most`.
constexpr std::size_t sample_step(std::size_t count, std::size_t most) {
  return count <= most ? 1 : (count + most - 1) / most;
}

struct Sampling {
  /// Receives the sample, at most once and as early as the format permits: .spz in gzip before its
  /// SH are unpacked, others when all Gaussians are read. On the thread of read_scene().
  std::function<void(SceneSample sample)> take;
  std::size_t most = 50'000;     ///< of the sample
  std::size_t fewest = 300'000;  ///< of the file; smaller ones are read in a moment
};

struct ReadOptions {
  int iteration = -1;  ///< of a model directory: point_cloud/iteration_N; -1 = the highest
  /// Overrides the frame declared by the file, see is_axes(); empty: trust the file.
  std::string axes = {};
  Progress progress = {};
  Sampling sampling = {};
};

/// One file format. Both functions get the file's whole content (memory-mapped) and its path, which
/// is used in messages and for the extension. read() works in the caller's thread pool.
struct ReaderRow {
  const char* name;        ///< "ply"
  const char* extensions;  ///< ".ply", space separated
  const char* summary;
  const char* axes;        ///< default frame of its values: "RDF"
  const char* sh_degrees;  ///< SH degrees that are read: "0-3"
  const char* limits;      ///< what is refused or lost
  bool (*recognises)(std::span<const std::byte> content, const std::filesystem::path& path);
  void (*read)(std::span<const std::byte> content, const std::filesystem::path& path,
               ThreadPool& pool, const ReadOptions& options, Scene& scene);
};

/// All readable formats; content decides, the extension breaks ties.
std::span<const ReaderRow> readers();

/// Reads a splat file, or the highest (or chosen) point_cloud/iteration_*/point_cloud.ply of a
/// model directory. All work is done in `pool`. Throws Error(input) with one sentence "path: what",
/// and Cancelled.
Scene read_scene(const std::filesystem::path& path, ThreadPool& pool,
                 const ReadOptions& options = {});

/// Reinterprets the scene as if its file had declared the frame `axes`, for files
/// that declare none or the wrong one. Throws Error(usage) for another name.
void assume_axes(Scene& scene, std::string_view axes);

/// The scene file for `path`: `path` itself, or the file inside a model directory.
std::filesystem::path find_scene_file(const std::filesystem::path& path, int iteration = -1);

}  // namespace qs
