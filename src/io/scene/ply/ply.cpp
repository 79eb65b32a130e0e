// SPDX-License-Identifier: MIT
#include "io/scene/ply/ply.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/scene/ply/ply_file.h"

namespace qs {
namespace {

// Every row is first brought into the order of INRIA's files without normals: position, DC, the
// rest of the SH channel by channel, opacity, log scale, rotation (w, x, y, z).
constexpr std::size_t kPosition = 0, kDc = 3, kRest = 6;
constexpr std::size_t kValuesBesidesRest = 14;
constexpr std::size_t kMaxValues = kValuesBesidesRest + 3 * 15;
using Row = std::array<float, kMaxValues>;

struct Source {
  std::size_t slot;  // in the Row
  PlyColumn column;
};

// Consecutive floats of the file that are consecutive in the Row too.
struct Run {
  std::size_t slot;
  std::uint64_t offset;
  std::size_t floats;
};

class SplatRows {
 public:
  /// `rest` is the number of SH coefficients per channel beyond DC that are read, `stored` the
  /// number in the file.
  SplatRows(const PlyRows& rows, std::size_t rest, std::size_t stored, const std::string& path)
      : rows_(rows), path_(path) {
    // 2DGS saves two scales: its Gaussians have no thickness.
    row_.fill(-std::numeric_limits<float>::infinity());
    for (const char* name : {"x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2"}) bind(name);
    for (std::size_t channel = 0; channel < 3; ++channel)
      for (std::size_t k = 0; k < rest; ++k) bind(fmt::format("f_rest_{}", channel * stored + k));
    for (const char* name : {"opacity", "scale_0", "scale_1"}) bind(name);
    is_2d_ = rows.find("scale_2") == nullptr;
    if (is_2d_)
      ++slot_;
    else
      bind("scale_2");
    for (const char* name : {"rot_0", "rot_1", "rot_2", "rot_3"}) bind(name);
    find_runs();
  }

  bool is_2d() const { return is_2d_; }

  /// Fills the Gaussians [begin, end) of the cloud. `kRestCount` is the constructor's `rest`.
  template <std::size_t kRestCount>
  void fill(GaussianCloud& cloud, std::size_t begin, std::size_t end) const {
    Row row = row_;
    for (std::size_t i = begin; i < end; ++i) {
      gather(i, row);
      cloud.positions[i] = {row[kPosition], row[kPosition + 1], row[kPosition + 2]};
      glm::vec3* const sh = &cloud.sh[i * (kRestCount + 1)];
      sh[0] = {row[kDc], row[kDc + 1], row[kDc + 2]};
      const float* const rest = row.data() + kRest;
      for (std::size_t k = 0; k < kRestCount; ++k)
        sh[1 + k] = {rest[k], rest[kRestCount + k], rest[2 * kRestCount + k]};
      const float* const tail = rest + 3 * kRestCount;
      cloud.opacity_logits[i] = tail[0];
      cloud.log_scales[i] = {tail[1], tail[2], tail[3]};
      cloud.rotations[i] = glm::quat(tail[4], tail[5], tail[6], tail[7]);
    }
  }

 private:
  void bind(const std::string& name) {
    sources_.push_back({slot_++, rows_.of_vertices(name, path_)});
  }

  // Filled only if every value is a float in this machine's byte order.
  void find_runs() {
    const auto in_place = [](const Source& source) { return source.column.type == PlyType::f32; };
    if (rows_.swap_bytes || !std::ranges::all_of(sources_, in_place)) return;
    for (const Source& source : sources_) {
      const Run* const last = runs_.empty() ? nullptr : &runs_.back();
      if (last == nullptr || source.column.offset != last->offset + last->floats * sizeof(float) ||
          source.slot != last->slot + last->floats)
        runs_.push_back({source.slot, source.column.offset, 0});
      ++runs_.back().floats;
    }
  }

  void gather(std::size_t i, Row& row) const {
    if (runs_.empty()) {
      for (const Source& source : sources_)
        row[source.slot] = static_cast<float>(rows_.value(i, source.column));
      return;
    }
    const std::byte* const from = rows_.data + i * rows_.row_bytes;
    for (const Run& run : runs_)
      std::memcpy(&row[run.slot], from + run.offset, run.floats * sizeof(float));
  }

  const PlyRows& rows_;
  std::string path_;
  std::size_t slot_ = 0;
  bool is_2d_ = false;
  std::vector<Source> sources_;
  std::vector<Run> runs_;
  Row row_;
};

// Users sometimes open the point cloud or mesh that is stored beside the splats.
void refuse_other_contents(const PlyHeader& header, const std::string& path) {
  const PlyElement* const vertices = header.find("vertex");
  const bool has_faces = header.find("face") != nullptr;
  if (vertices == nullptr) fail("{}: not a splat file: it has no element 'vertex'", path);
  for (const char* name : {"f_dc_0", "opacity", "scale_0", "rot_0"})
    if (vertices->has(name)) return;
  fail("{}: a {}, not a splat file: its vertices have no f_dc, opacity, scale and rot properties",
       path, has_faces ? "triangle mesh" : "point cloud");
}

// The number of f_rest values per channel; 0 with a warning when they fit no degree.
int stored_rest(const PlyRows& rows, Scene& scene) {
  std::size_t count = 0;
  for (const PlyColumn& column : rows.columns) count += column.name.starts_with("f_rest_") ? 1 : 0;
  bool numbered = true;
  const int rest = sh_rest_per_channel(count);
  for (std::size_t i = 0; rest > 0 && numbered && i < count; ++i)
    numbered = rows.find(fmt::format("f_rest_{}", i)) != nullptr;
  if (rest >= 0 && numbered) return rest;
  scene.warn(
      "Only the base colour is used: {} f_rest properties are not f_rest_0 to f_rest_8, 23, 44 or "
      "71.",
      count);
  return 0;
}

std::string trimmed(std::string_view text) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t"), text.size());
  const std::size_t end = text.find_last_not_of(" \t") + 1;
  return std::string(text.substr(begin, std::max(begin, end) - begin));
}

}  // namespace

int sh_rest_per_channel(std::size_t values) {
  for (const int rest : {0, 3, 8, 15, 24})
    if (values == 3 * static_cast<std::size_t>(rest)) return rest;
  return -1;
}

int kept_sh_degree(int rest_per_channel, Scene& scene) {
  if (rest_per_channel == 24) {
    scene.warn("Spherical harmonics of degree 4 were cut to degree 3.");
    return kMaxShDegree;
  }
  int degree = 0;
  while (sh_coefficient_count(degree) < rest_per_channel + 1) ++degree;
  return degree;
}

void apply_ply_comments(const PlyHeader& header, Scene& scene) {
  for (const std::string& comment : header.comments) {
    const std::string text = trimmed(lower_case(comment));
    constexpr std::string_view kVerticalAxis = "vertical axis:";
    // Brush writes SplatRenderMode and the vertical axis, Postshot writes antialiased.
    if (text == "splatrendermode: mip" || text == "antialiased 1") scene.cloud.antialiased = true;
    if (!text.starts_with(kVerticalAxis)) continue;
    const std::string axis = trimmed(std::string_view(text).substr(kVerticalAxis.size()));
    for (const char* known : {"x", "y", "z", "-x", "-y", "-z"})
      if (axis == known) scene.vertical_axis = axis;
  }
}

bool is_ply_without_colors(ByteSpan content) {
  if (!is_ply(content)) return false;
  const std::string_view header = ply_header_text(content);
  const auto has = [&](std::string_view property) {
    return header.find(property) != std::string_view::npos;
  };
  return has(" opacity") && has(" rot_0") && !has(" f_dc_") && !has(" packed_position");
}

bool recognises_ply(ByteSpan content, const std::filesystem::path& path) {
  return is_ply(content) && !recognises_compressed_ply(content, path) &&
         !is_ply_without_colors(content);
}

void read_ply(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene) {
  const PlyHeader header = parse_ply_header(content, path);
  refuse_other_contents(header, path.string());
  PlyBody body(content, header, path, options.progress);
  const PlyRows rows = body.rows("vertex");

  const int stored = stored_rest(rows, scene);
  const int degree = kept_sh_degree(stored, scene);
  const SplatRows splats(rows, static_cast<std::size_t>(sh_coefficient_count(degree) - 1),
                         static_cast<std::size_t>(stored), path.string());

  scene.format = "ply, " + describe(header.format) + (splats.is_2d() ? ", 2D Gaussians" : "");
  scene.cloud = make_cloud(rows.count, degree);
  apply_ply_comments(header, scene);

  const float start = rows.decoded.empty() ? 0 : 0.5f;  // PlyBody has reported up to here
  constexpr decltype(&SplatRows::fill<0>) kFills[] = {&SplatRows::fill<0>, &SplatRows::fill<3>,
                                                      &SplatRows::fill<8>, &SplatRows::fill<15>};
  const auto fill = kFills[degree];
  fill_cloud(scene, pool, options.progress, start,
             [&](std::size_t begin, std::size_t end) { (splats.*fill)(scene.cloud, begin, end); });
  for (std::string& warning : body.leftovers()) scene.warnings.push_back(std::move(warning));
}

}  // namespace qs
