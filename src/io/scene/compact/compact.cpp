// SPDX-License-Identifier: MIT
#include "io/scene/compact/compact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "base/fail.h"
#include "base/path_kind.h"
#include "base/rank.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_source.h"
#include "io/bytes/mapped_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/scene/compact/compact_model.h"
#include "io/scene/ply/ply.h"
#include "io/scene/ply/ply_file.h"
#include "io/tensor/torch_tensor.h"
#include "raster/field/field_evaluator.h"

namespace qs {
namespace {

float logit(float opacity) {
  const auto o = static_cast<double>(opacity);
  return static_cast<float>(std::log(o / (1 - o)));
}

void fill(const CompactModel& model, GaussianCloud& cloud, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    const glm::vec4& q = model.rotations[i];
    cloud.positions[i] = model.means[i];
    cloud.opacity_logits[i] = model.activated_opacities
                                  ? logit(std::clamp(model.opacities[i], 0.0f, 1.0f))
                                  : model.opacities[i];
    if (model.activated_shapes) {
      const ShapeOfGaussian shape = shape_of_raw_rotation(q, model.scales[i]);
      cloud.rotations[i] = shape.rotation;
      cloud.log_scales[i] = shape.log_scale;
    } else {
      cloud.rotations[i] = glm::quat(q.x, q.y, q.z, q.w);
      cloud.log_scales[i] = model.scales[i];
    }
  }
}

// Of a list of non-negative numbers, in which NaN count as 0.
NetworkColors measured(std::vector<float> rms) {
  NetworkColors network;
  if (rms.empty()) return network;
  double squares = 0;
  for (float& value : rms) {
    if (!std::isfinite(value)) value = 0;
    squares += static_cast<double>(value) * static_cast<double>(value);
  }
  network.rms = std::sqrt(squares / static_cast<double>(rms.size()));
  network.rms_of_99 = static_cast<double>(at_rank(rms, (rms.size() - 1) * 99 / 100));
  return network;
}

// Option --max_hashmap of Compact-3DGS, 19 by default.
constexpr int kLeastLog2Entries = 3, kMostLog2Entries = 21;

constexpr const char* kGrid = "0.params";
constexpr const char* kNetwork = "1.params";

void read_gaussians(const PlyRows& rows, const std::string& path, CompactModel& model) {
  std::vector<PlyColumn> columns;
  for (const char* name : {"x", "y", "z", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1",
                           "rot_2", "rot_3", "opacity"})
    columns.push_back(rows.of_vertices(name, path));
  model.means.resize(rows.count);
  model.scales.resize(rows.count);
  model.rotations.resize(rows.count);
  model.opacities.resize(rows.count);
  for (std::size_t i = 0; i < rows.count; ++i) {
    const auto value = [&](std::size_t column) {
      return static_cast<float>(rows.value(i, columns[column]));
    };
    model.means[i] = {value(0), value(1), value(2)};
    model.scales[i] = {value(3), value(4), value(5)};
    model.rotations[i] = {value(6), value(7), value(8), value(9)};
    model.opacities[i] = value(10);
  }
}

// The header does not say what the values are.
void find_activated(CompactModel& model) {
  // No sigmoid has a value outside of 0..1, and hardly any training has all its logits inside.
  const auto is_unit = [](float value) { return !(value < 0 || value > 1); };
  model.activated_opacities = std::ranges::all_of(model.opacities, is_unit);
  if (model.activated_opacities) return;
  // Logarithms in 0..1 are standard deviations of 1 to 2.7 units: most Gaussians are smaller.
  const auto inside = std::ranges::count_if(model.scales, [&](const glm::vec3& scale) {
    return is_unit(scale.x) && is_unit(scale.y) && is_unit(scale.z);
  });
  model.activated_shapes = 2 * static_cast<std::size_t>(inside) > model.scales.size();
}

FilePart tensor_part(const char* name, const Tensor& tensor) {
  return {fmt::format(".pth: {}", name), tensor.values.size() * sizeof(float),
          fmt::format("{} values of 32 bits", tensor.values.size())};
}

constexpr int kMaxSweeps = 30;

// Turns pairs of columns until all are perpendicular (Hestenes 1958). Their product with their
// transposed matrix stays the same.
void make_perpendicular(glm::dmat3& m) {
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    bool turned = false;
    for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      const double a = glm::dot(m[p], m[p]), b = glm::dot(m[q], m[q]), c = glm::dot(m[p], m[q]);
      if (!(std::abs(c) > 1e-15 * std::sqrt(a * b)) || c == 0) continue;
      turned = true;
      const double theta = (b - a) / (2 * c);
      const double tangent =
          std::copysign(1 / (std::abs(theta) + std::sqrt(1 + theta * theta)), theta);
      const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = cosine * tangent;
      const glm::dvec3 first = m[p];
      m[p] = cosine * first - sine * m[q];
      m[q] = sine * first + cosine * m[q];
    }
    if (!turned) return;
  }
}

// A unit vector that is perpendicular to the unit vector `v`.
glm::dvec3 perpendicular_to(const glm::dvec3& v) {
  const glm::dvec3 other = std::abs(v.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(v, other));
}

}  // namespace

ShapeOfGaussian shape_of_raw_rotation(const glm::vec4& quaternion, const glm::vec3& scale) {
  const double w = static_cast<double>(quaternion.x), x = static_cast<double>(quaternion.y),
               y = static_cast<double>(quaternion.z), z = static_cast<double>(quaternion.w);
  ShapeOfGaussian shape;
  const double square = w * w + x * x + y * y + z * z;
  if (!std::isfinite(square + static_cast<double>(scale.x + scale.y + scale.z))) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    shape.rotation = {kNan, kNan, kNan, kNan};
    return shape;
  }
  glm::dmat3 m(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
               2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
               2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
  for (int axis = 0; axis < 3; ++axis) m[axis] *= static_cast<double>(scale[axis]);
  if (std::abs(square - 1) > 1e-7) make_perpendicular(m);

  glm::dvec3 lengths(glm::length(m[0]), glm::length(m[1]), glm::length(m[2]));
  glm::dmat3 axes(0);
  std::array<int, 3> flat{};
  std::size_t flats = 0;
  for (int axis = 0; axis < 3; ++axis) {
    shape.log_scale[axis] = static_cast<float>(std::log(lengths[axis]));
    if (lengths[axis] > 0)
      axes[axis] = m[axis] / lengths[axis];
    else
      flat[flats++] = axis;
  }
  // Directions without extent are any that complete the axes.
  if (flats == 3) return shape;
  if (flats == 2) axes[flat[0]] = perpendicular_to(axes[3 - flat[0] - flat[1]]);
  if (flats > 0) {
    const int last = flat[flats - 1];
    axes[last] = glm::cross(axes[(last + 1) % 3], axes[(last + 2) % 3]);
  }
  if (glm::determinant(axes) < 0) axes[0] = -axes[0];
  shape.rotation = glm::quat(glm::normalize(glm::quat_cast(axes)));
  return shape;
}

CompactModel read_compact_ply(ByteSpan content, const std::filesystem::path& path,
                              const Progress& progress) {
  std::filesystem::path weights = path;
  weights.replace_extension(".pth");
  if (!is_file(weights))
    fail(
        "{}: its Gaussians have no colours (f_dc); Compact-3DGS keeps them in a network, but {} "
        "is not beside it",
        path.string(), weights.filename().string());
  const PlyHeader header = parse_ply_header(content, path);
  PlyBody body(content, header, path, progress);
  const PlyRows rows = body.rows("vertex");
  CompactModel model;
  read_gaussians(rows, path.string(), model);
  model.warnings = body.leftovers();
  find_activated(model);

  const MappedFile file(weights);
  const TorchFile torch(file.content(), weights);
  Tensor grid = torch.tensor(kGrid), network = torch.tensor(kNetwork);
  model.file_bytes = content.size() + file.content().size();
  const std::uint64_t row_bytes = rows.count * header.find("vertex")->row_bytes;
  model.parts = {{".ply: vertices", row_bytes,
                  fmt::format("{} rows of {} values", rows.count, rows.columns.size())},
                 tensor_part(kGrid, grid),
                 tensor_part(kNetwork, network)};
  model.form = model.activated_opacities ? ".ply and .pth"
               : model.activated_shapes  ? ".ply and .pth, of the first release"
                                         : ".ply and .pth, before the last iteration";
  model.field =
      make_color_field(std::move(grid.values), std::move(network.values), weights.string());
  return model;
}

bool recognises_compact(ByteSpan content, const std::filesystem::path&) {
  return is_npz(content) || is_torch_archive(content) || is_ply_without_colors(content);
}

void read_compact(ByteSpan content, const std::filesystem::path& path, ThreadPool& pool,
                  const ReadOptions& options, Scene& scene) {
  if (is_torch_archive(content))
    fail(
        "{}: a file of PyTorch, such as the network of a Compact-3DGS model: open the .ply or "
        ".npz beside it",
        path.string());
  CompactModel model = is_npz(content) ? read_compact_npz(content, path, options.progress)
                                       : read_compact_ply(content, path, options.progress);
  scene.format = "compact-3dgs, " + model.form;
  scene.file_bytes = model.file_bytes;
  scene.parts = std::move(model.parts);
  for (std::string& warning : model.warnings) scene.warnings.push_back(std::move(warning));
  const auto field = std::make_shared<const ColorField>(std::move(model.field));
  const FieldEvaluator evaluator(*field);
  const std::size_t count = model.means.size();
  scene.cloud = make_cloud(count, kMaxShDegree);
  std::vector<float> rms(count);
  constexpr std::size_t kCoefficients = sh_coefficient_count(kMaxShDegree);
  fill_cloud(scene, pool, options.progress, 0.2f, [&](std::size_t begin, std::size_t end) {
    fill(model, scene.cloud, begin, end);
    evaluator.fit_sh(
        std::span(model.means).subspan(begin, end - begin),
        std::span(scene.cloud.sh).subspan(begin * kCoefficients, (end - begin) * kCoefficients),
        std::span(rms).subspan(begin, end - begin));
  });
  scene.network = measured(std::move(rms));
  scene.network->field = field;
  scene.warnings.push_back(fit_sentence(*scene.network));
}

std::string fit_sentence(const NetworkColors& network) {
  return fmt::format(
      "The network's colours became spherical harmonics of degree 3: in the 24 directions of the "
      "fit they differ by {:.2g} rms (of 0 to 1), in 99 % of the Gaussians by at most {:.2g}.",
      network.rms, network.rms_of_99);
}

ColorField make_color_field(std::vector<float> grid_values, std::vector<float> weights,
                            const std::string& source) {
  ColorField field;
  const std::size_t expected = field.network().weight_count();
  if (weights.size() != expected)
    fail("{}: its network has {} weights, but networks of Compact-3DGS have {}", source,
         weights.size(), expected);
  for (int log2 = kLeastLog2Entries; log2 <= kMostLog2Entries; ++log2) {
    field.grid.log2_entries = log2;
    if (grid_value_count(field.grid) != grid_values.size()) continue;
    field.grid_values = std::move(grid_values);
    field.weights = std::move(weights);
    return field;
  }
  fail("{}: its hash grid has {} values, which fit no grid of Compact-3DGS", source,
       grid_values.size());
}

}  // namespace qs
