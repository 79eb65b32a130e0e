// SPDX-License-Identifier: MIT
#include "io/scene/ply/ply.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include <glm/exponential.hpp>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/scene/ply/ply_file.h"
#include "raster/kernel/constants.h"
#include "raster/scene/place.h"

namespace qs {
namespace {

// Every row is first brought into the order of INRIA's files without normals: position, DC, the
// rest of the SH channel by channel, opacity, log scale, rotation (w, x, y, z).
constexpr std::size_t kPosition = 0, kDc = 3, kRest = 6;
constexpr std::size_t kValuesBesidesRest = 14;
constexpr std::size_t kMaxValues = kValuesBesidesRest + 3 * 15;
constexpr std::array kColorNames = {"red", "green", "blue"};
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

// Mip-Splatting's 3D filter: a Gaussian is blurred by a round Gaussian of standard deviation
// `filter`, and its opacity falls as its volume grows (Yu et al. 2024, equation 9).
void apply_filter(double filter, GaussianCloud& cloud, std::size_t i) {
  if (filter == 0) return;
  const glm::dvec3 before(cloud.log_scales[i]);
  const glm::dvec3 after = 0.5 * glm::log(glm::exp(2.0 * before) + filter * filter);
  cloud.log_scales[i] = after;
  const glm::dvec3 change = before - after;  // the sum: ln of the ratio of the volumes
  const double logit = static_cast<double>(cloud.opacity_logits[i]);
  const double opacity = std::exp(change.x + change.y + change.z) / (1 + std::exp(-logit));
  cloud.opacity_logits[i] = static_cast<float>(std::log(opacity / (1 - opacity)));
}

class SplatRows {
 public:
  /// `rest` is the number of SH coefficients per channel beyond DC that are read, `stored` the
  /// number in the file.
  SplatRows(const PlyRows& rows, std::size_t rest, std::size_t stored, const std::string& path)
      : rows_(rows), path_(path) {
    // 2DGS saves two scales: its Gaussians have no thickness.
    row_.fill(-std::numeric_limits<float>::infinity());
    is_double_ = rows.of_vertices("x", path).type == PlyType::f64;
    has_colors_ = rows.find("f_dc_0") == nullptr && rows.find(kColorNames[0]) != nullptr;
    filter_ = rows.find("filter_3D");
    for (const char* name : {"x", "y", "z"}) bind(name);
    for (std::size_t channel = 0; channel < 3; ++channel)
      bind(has_colors_ ? kColorNames[channel] : fmt::format("f_dc_{}", channel));
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
  /// The origin for positions in double precision, which then count from it; 0 for others.
  glm::dvec3 choose_origin() {
    if (!is_double_) return glm::dvec3(0);
    origin_ = origin_of(rows_.count, [&](std::size_t i) {
      return glm::dvec3(rows_.value(i, sources_[0].column), rows_.value(i, sources_[1].column),
                        rows_.value(i, sources_[2].column));
    });
    return origin_;
  }
  bool is_filtered() const { return filter_ != nullptr; }

  /// Fills the Gaussians [begin, end) of the cloud. `kRestCount` is the constructor's `rest`.
  template <std::size_t kRestCount>
  void fill(GaussianCloud& cloud, std::size_t begin, std::size_t end) const {
    Row row = row_;
    for (std::size_t i = begin; i < end; ++i) {
      gather(i, row);
      cloud.positions[i] = {row[kPosition], row[kPosition + 1], row[kPosition + 2]};
      glm::vec3* const sh = &cloud.sh[i * (kRestCount + 1)];
      sh[0] = {row[kDc], row[kDc + 1], row[kDc + 2]};
      if (has_colors_)
        for (int channel = 0; channel < 3; ++channel) sh[0][channel] = dc_of_color(sh[0], channel);
      const float* const rest = row.data() + kRest;
      for (std::size_t k = 0; k < kRestCount; ++k)
        sh[1 + k] = {rest[k], rest[kRestCount + k], rest[2 * kRestCount + k]};
      const float* const tail = rest + 3 * kRestCount;
      cloud.opacity_logits[i] = tail[0];
      cloud.log_scales[i] = {tail[1], tail[2], tail[3]};
      cloud.rotations[i] = glm::quat(tail[4], tail[5], tail[6], tail[7]);
      if (filter_ != nullptr) apply_filter(rows_.value(i, *filter_), cloud, i);
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
      if (origin_ == glm::dvec3(0)) return;
      for (std::size_t axis = 0; axis < 3; ++axis)
        row[kPosition + axis] = static_cast<float>(rows_.value(i, sources_[axis].column) -
                                                   origin_[static_cast<int>(axis)]);
      return;
    }
    const std::byte* const from = rows_.data + i * rows_.row_bytes;
    for (const Run& run : runs_)
      std::memcpy(&row[run.slot], from + run.offset, run.floats * sizeof(float));
  }

  // Integers are fractions of the largest number of their type, as 255.
  float dc_of_color(const glm::vec3& color, int channel) const {
    const PlyType type = sources_[kDc + static_cast<std::size_t>(channel)].column.stored;
    const double most = type == PlyType::u8 ? 255 : type == PlyType::u16 ? 65535 : 1;
    return static_cast<float>((static_cast<double>(color[channel]) / most - 0.5) / kSh0);
  }

  const PlyRows& rows_;
  std::string path_;
  std::size_t slot_ = 0;
  bool is_2d_ = false, has_colors_ = false, is_double_ = false;
  glm::dvec3 origin_{0};
  const PlyColumn* filter_ = nullptr;  // Mip-Splatting's 3D filter; null: none
  std::vector<Source> sources_;
  std::vector<Run> runs_;
  Row row_;
};

// Vertices that are more than Gaussians, or others, by a property that only they have. To add a
// kind: a row.
struct OtherKind {
  const char* property;
  const char* name;  // with its paper or program
  bool is_drawn;     // its properties contain whole Gaussians
};
constexpr std::array kOtherKinds = {
    OtherKind{"f_anchor_feat_0", "anchors of Scaffold-GS", false},
    OtherKind{"f_offset_0", "anchors of Scaffold-GS", false},
    OtherKind{"trbf_center", "4D Gaussians (SpacetimeGaussians)", true},
    OtherKind{"motion_0", "4D Gaussians with motion", true},
    OtherKind{"velocity_0", "4D Gaussians with motion", true},
    OtherKind{"scale_t", "4D Gaussians (4DGS)", true},
    OtherKind{"t_scale", "4D Gaussians (4DGS)", true},
    OtherKind{"scaling_t_0", "4D Gaussians (4DGS)", true},
    OtherKind{"rot_r_0", "4D Gaussians (4DGS)", true},
    OtherKind{"t", "4D Gaussians", true},
};

// Users sometimes open the point cloud or mesh that is stored beside the splats.
void refuse_other_contents(const PlyHeader& header, const std::string& path) {
  const PlyElement* const vertices = header.find("vertex");
  const bool has_faces = header.find("face") != nullptr;
  if (vertices == nullptr) fail("{}: not a splat file: it has no element 'vertex'", path);
  for (const OtherKind& kind : kOtherKinds)
    if (!kind.is_drawn && vertices->has(kind.property))
      fail("{}: {} (property {}): networks of its program make the Gaussians of such a model", path,
           kind.name, kind.property);
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

// CloudCompare puts "scalar_" before the names of properties that it does not know.
void drop_prefixes(PlyHeader& header) {
  constexpr std::string_view kPrefix = "scalar_";
  for (PlyElement& element : header.elements)
    for (PlyProperty& property : element.properties)
      if (property.name.starts_with(kPrefix) && !element.has(property.name.substr(kPrefix.size())))
        property.name.erase(0, kPrefix.size());
}

// Names what the file holds besides the Gaussians that are drawn.
void name_other_kind(const PlyHeader& header, const std::filesystem::path& path, bool is_2d,
                     Scene& scene) {
  for (const OtherKind& kind : kOtherKinds) {
    if (!header.find("vertex")->has(kind.property)) continue;
    scene.warn("{} (property {}): all of them are drawn as they are stored, without time.",
               kind.name, kind.property);
    break;
  }
  std::error_code error;
  if (std::filesystem::exists(path.parent_path() / "deformation.pth", error))
    scene.warn(
        "4D Gaussians (4DGaussians): they are drawn as they are stored, without the motion of the "
        "network deformation.pth beside them.");
  if (is_2d)
    scene.warn(
        "2D Gaussians (2DGS): they are drawn as flat 3D Gaussians, without 2DGS's intersection of "
        "rays.");
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
    // Brush writes SplatRenderMode and the vertical axis, Postshot writes antialiased. Programs
    // that append comments leave the earlier ones, so the last one holds.
    if (text.starts_with("splatrendermode:") || text.starts_with("antialiased "))
      scene.cloud.antialiased = text == "splatrendermode: mip" || text == "antialiased 1";
    if (text.starts_with(kOriginComment))
      scene.cloud.origin =
          parse_origin(text.substr(kOriginComment.size())).value_or(scene.cloud.origin);
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
  return has(" opacity") && has(" rot_0") && !has(" f_dc_") && !has(" packed_position") &&
         !has(" red") && !has(" f_anchor_feat_") && !has(" f_offset_");
}

bool recognises_ply(ByteSpan content, const std::filesystem::path& path) {
  return is_ply(content) && !recognises_compressed_ply(content, path) &&
         !is_ply_without_colors(content);
}

std::uint64_t divisible_rows(ByteSpan content, const std::filesystem::path& path) {
  if (!recognises_ply(content, path)) return 0;
  const PlyHeader header = parse_ply_header(content, path);
  const bool is_binary = header.format != PlyFormat::ascii;
  if (!is_binary || header.elements.empty() || header.elements[0].name != "vertex") return 0;
  const PlyElement& vertices = header.elements[0];
  const std::uint64_t left = content.size() - header.body_offset;
  if (vertices.has_list || vertices.row_bytes == 0) return 0;
  if (!fits(vertices.count, vertices.row_bytes, left))
    fail("{}: cut off: {} vertices need {} bytes each, {} bytes are left", path.string(),
         vertices.count, vertices.row_bytes, left);
  return vertices.count;
}

std::string ply_part(ByteSpan content, const std::filesystem::path& path, std::uint64_t begin,
                     std::uint64_t end) {
  const PlyHeader header = parse_ply_header(content, path);
  const std::uint64_t row_bytes = header.elements[0].row_bytes;
  std::string part(text_of(content.first(header.body_offset)));
  // The line "element vertex COUNT" and the lines of other elements, which have no rows here.
  std::size_t element = 0;
  for (std::size_t line = 0; line < part.size();) {
    std::size_t stop = std::min(part.find_first_of("\r\n", line), part.size());
    if (part.compare(line, 8, "element ") == 0) {
      const std::uint64_t count = element == 0 ? end - begin : 0;
      const std::string text = fmt::format("element {} {}", header.elements[element++].name, count);
      part.replace(line, stop - line, text);
      stop = line + text.size();
    }
    line = std::min(part.find_first_not_of("\r\n", stop), part.size());
  }
  part +=
      text_of(content.subspan(header.body_offset + begin * row_bytes, (end - begin) * row_bytes));
  return part;
}

void read_ply(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
              const ReadOptions& options, Scene& scene) {
  PlyHeader header = parse_ply_header(content, path);
  drop_prefixes(header);
  refuse_other_contents(header, path.string());
  PlyBody body(content, header, path, options.progress);
  const PlyRows rows = body.rows("vertex");

  const int stored = stored_rest(rows, scene);
  const int degree = kept_sh_degree(stored, scene);
  SplatRows splats(rows, static_cast<std::size_t>(sh_coefficient_count(degree) - 1),
                   static_cast<std::size_t>(stored), path.string());

  scene.format = "ply, " + describe(header.format) + (splats.is_2d() ? ", 2D Gaussians" : "") +
                 (splats.is_filtered() ? ", with Mip-Splatting's 3D filter" : "");
  scene.cloud = make_cloud(rows.count, degree);
  apply_ply_comments(header, scene);
  if (!options.keeps_place) scene.cloud.origin += splats.choose_origin();

  const float start = rows.decoded.empty() ? 0 : 0.5f;  // PlyBody has reported up to here
  constexpr decltype(&SplatRows::fill<0>) kFills[] = {&SplatRows::fill<0>, &SplatRows::fill<3>,
                                                      &SplatRows::fill<8>, &SplatRows::fill<15>};
  const auto fill = kFills[degree];
  fill_cloud(scene, pool, options.progress, start,
             [&](std::size_t begin, std::size_t end) { (splats.*fill)(scene.cloud, begin, end); });
  name_other_kind(header, path, splats.is_2d(), scene);
  for (std::string& warning : body.leftovers()) scene.warnings.push_back(std::move(warning));
}

}  // namespace qs
