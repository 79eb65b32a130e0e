// SPDX-License-Identifier: MIT
//
// A scene as readers return it, and the options of reading. Every format fills a Scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/progress.h"
#include "io/cloud/edits.h"
#include "raster/field/color_field.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

class PageStream;
class ThreadPool;

/// A part of a scene's files.
struct FilePart {
  std::string name;
  std::uint64_t bytes = 0;  ///< in the file, as it is compressed there
  std::string content;      ///< "600 values of 16 bits"
};

/// A scene whose colours a network computes (Compact-3DGS). Its cloud has spherical harmonics that
/// were fitted to the network.
struct NetworkColors {
  std::shared_ptr<const ColorField> field;
  double rms = 0;        ///< rms of the fit's difference in 24 directions, in units of 0..1
  double rms_of_99 = 0;  ///< 99 % of the Gaussians have at most this rms
};

/// The levels of detail of a file. Its leaves, the finest Gaussians, are in the cloud.
struct LevelsOfDetail {
  std::uint64_t levels = 0;
  std::uint64_t nodes = 0;     ///< of the tree
  std::uint64_t leaves = 0;    ///< Gaussians that were read
  std::uint64_t merged = 0;    ///< Gaussians of coarser levels, which were left out
  bool has_errors = false;     ///< quadsplat lod wrote the file
  bool has_originals = false;  ///< the leaves have the bits and the order of their sources
  bool operator==(const LevelsOfDetail&) const = default;
};

/// A cloud and the facts its file states about it.
struct Scene {
  GaussianCloud cloud;
  std::optional<NetworkColors> network;
  std::optional<LevelsOfDetail> levels;  ///< unset: the file has no levels
  /// The pages of a tree that is not read whole; then the cloud is a coarse picture of all. Or
  /// null.
  std::shared_ptr<PageStream> stream;
  std::filesystem::path path;  ///< the file that was read (of a model directory: the chosen file)
  std::string format;  ///< name of the reader's row, with a variant: "ply, binary little endian"
  std::vector<std::string> warnings;  ///< one sentence each: values that were dropped or assumed
  std::string axes = "RDF";  ///< frame of the file's values, see axes.h; the cloud is always in RDF
  /// as the file or its format declares; ReadOptions::axes do not change it
  std::string declared_axes = "RDF";
  std::string vertical_axis;     ///< as the file declares it ("y", "-z", ...); empty if it does not
  std::uint64_t file_bytes = 0;  ///< sum over all files that were read
  std::vector<FilePart> parts;   ///< set by formats that consist of arrays
  double unpack_ms = 0;          ///< headers, decompression and allocation
  double fill_ms = 0;            ///< conversion of the values into the cloud, with checks
  Edits edits;                   ///< of the cloud since it was read

  template <class... Args>
  void warn(fmt::format_string<Args...> sentence, Args&&... args) {
    warnings.push_back(fmt::format(sentence, std::forward<Args>(args)...));
  }
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
  /// SH are unpacked, other formats when all Gaussians are read. Called on the thread that reads
  /// the scene.
  std::function<void(SceneSample sample)> take;
  std::size_t most = 50'000;     ///< Gaussians in the sample
  std::size_t fewest = 300'000;  ///< files with fewer Gaussians give no sample
};

/// The .rad files with a tree of which pages are read when they are drawn, see Scene::stream.
enum class StreamedTrees {
  none,
  large,  ///< trees that would take more than half of the memory
  all
};

struct ReadOptions {
  int iteration = -1;  ///< N of a model's point_cloud/iteration_N; -1 = the highest
  /// Overrides the frame declared by the file, see is_axes(); empty: trust the file.
  std::string axes = {};
  /// Positions stay where the file has them, rounded to single precision.
  bool keeps_place = false;
  StreamedTrees streams = StreamedTrees::none;
  /// Most bytes of a streamed tree's pages in memory; 0, or more than that: half of the available
  /// memory.
  std::uint64_t page_memory = 0;
  Progress progress = {};
  Sampling sampling = {};
};

// Samples of scenes that are being read; see Sampling.

/// The functions of a format. They get the file's whole content (memory-mapped) and its path, which
/// is used in messages and for the extension, and work in the caller's thread pool.
using RecogniseScene = bool(std::span<const std::byte> content, const std::filesystem::path& path);
using ReadScene = void(std::span<const std::byte> content, const std::filesystem::path& path,
                       ThreadPool& pool, const ReadOptions& options, Scene& scene);
using WriteScene = void(const GaussianCloud& cloud, const std::filesystem::path& path,
                        ThreadPool& pool, const Progress& progress);

/// True if `sampling` requests a sample of a scene with `count` Gaussians.
inline bool is_sampled(std::size_t count, const Sampling& sampling) {
  return sampling.take && count >= sampling.fewest;
}

/// A sample of `count` Gaussians of the scene, with its places and without its values.
SceneSample make_sample(const Scene& scene, std::size_t count, const Sampling& sampling);

/// The sample of a complete scene.
SceneSample sample_of(const Scene& scene, const Sampling& sampling);

}  // namespace qs
