// SPDX-License-Identifier: MIT
//
// Splats as trainers save them: a .ply whose element "vertex" has x y z, f_dc_*, f_rest_*, opacity,
// scale_* and rot_* (INRIA, gsplat, Brush, PlayCanvas, 2DGS, ...). Properties are found by name, in
// any order and of any type; unknown properties are skipped. f_rest is channel-major: all red
// coefficients first.
//
// compressed.ply of PlayCanvas, SuperSplat and gsplat: 16 bytes per Gaussian, packed relative to
// the bounds of its chunk of 256, and optional SH in one byte per value. Source: the reader and
// writer of playcanvas/splat-transform and gsplat's exporter.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/parallel.h"
#include "base/progress.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/scene.h"
#include "io/scene/ply/ply_file.h"
#include "raster/scene/gaussian_cloud.h"

namespace qs {

/// True for Gaussians without colours, as Compact-3DGS saves them. Point clouds and meshes are not.
bool is_ply_without_colors(ByteSpan content);

/// The number of Gaussians of a .ply whose rows can be read in parts: binary, without lists and
/// before all other elements. 0 for other files. Throws Error(input) if the header is damaged or
/// the rows are cut off.
std::uint64_t divisible_rows(ByteSpan content, const std::filesystem::path& path);

/// The rows [begin, end) of such a file as a file of its own.
std::string ply_part(ByteSpan content, const std::filesystem::path& path, std::uint64_t begin,
                     std::uint64_t end);

RecogniseScene recognises_ply, recognises_compressed_ply, recognises_zipped_ply;
ReadScene read_ply, read_compressed_ply, read_zipped_ply;

/// SH coefficients per channel beyond DC, given the number for all channels together: 0, 3, 8, 15
/// or 24; -1 if the number fits no degree.
int sh_rest_per_channel(std::size_t values);

/// The SH degree to keep, given sh_rest_per_channel() of 0, 3, 8, 15 or 24. Degree 4 is reduced to
/// 3 with a warning.
int kept_sh_degree(int rest_per_channel, Scene& scene);

/// Applies the declarations in the header's comments: antialiased training, the vertical axis.
void apply_ply_comments(const PlyHeader& header, Scene& scene);

/// The properties of the element "chunk": the bounds of positions, logarithms of scales, colours.
inline constexpr std::array kChunkProperties = {
    "min_x",       "min_y",       "min_z",       "max_x",       "max_y",       "max_z",
    "min_scale_x", "min_scale_y", "min_scale_z", "max_scale_x", "max_scale_y", "max_scale_z",
    "min_r",       "min_g",       "min_b",       "max_r",       "max_g",       "max_b"};

/// Writes the layout of INRIA's trainer, which every viewer reads: binary little endian floats x y
/// z nx ny nz f_dc_* f_rest_* opacity scale_* rot_*, normals zero, f_rest channel-major. Lossless:
/// reading the file returns the same cloud bit by bit. Georeferenced positions are doubles in the
/// world.
WriteScene write_ply;

/// As write_ply(), with a comment that says that this program trained the model. Georeferenced
/// positions stay floats that count from the origin of a second comment, for other programs.
void write_trained_ply(const GaussianCloud& cloud, const std::filesystem::path& path,
                       ThreadPool& pool);

/// A file whose Gaussians come in parts.
struct PlyContent {
  std::size_t count = 0;
  int sh_degree = 0;
  bool antialiased = false;
};

/// As write_ply(), for scenes larger than the memory: next_part() returns at least one Gaussian of
/// that degree, and is called until all `count` have come. Positions are floats.
void write_ply_parts(const PlyContent& content, const std::filesystem::path& path, ThreadPool& pool,
                     const std::function<GaussianCloud()>& next_part);

/// The lines of properties of one type.
template <class Names>
std::string ply_properties(const char* type, const Names& names) {
  std::string text;
  for (const auto& property : names) text += fmt::format("property {} {}\n", type, property);
  return text;
}

/// "element NAME COUNT" and the lines of its properties, all of one type.
template <class Names>
std::string ply_element(const char* name, std::size_t count, const char* type, const Names& names) {
  return fmt::format("element {} {}\n", name, count) + ply_properties(type, names);
}

/// "f_rest_0" to the last of `count`.
std::vector<std::string> ply_rest_names(std::size_t count);

/// The first lines of the files that this program writes.
inline constexpr const char* kPlyStart = "ply\nformat binary_little_endian 1.0\n";

/// The comment of a file whose positions count from GaussianCloud::origin; three numbers follow.
inline constexpr std::string_view kOriginComment = "offset ";

/// The line of the header of a file that this program trained.
inline constexpr const char* kTrainedComment = "comment trained by quadsplat\n";

/// True if the file has that comment.
bool is_trained_ply(const std::filesystem::path& path);

/// Writes the Gaussians in Morton order: the 256 of a chunk are then close together, so that their
/// bounds are tight and quantisation is fine.
WriteScene write_compressed_ply;

}  // namespace qs
