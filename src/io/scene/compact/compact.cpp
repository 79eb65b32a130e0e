// SPDX-License-Identifier: MIT
#include "io/scene/compact/compact.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/file_source.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/scene/compact/compact_model.h"
#include "io/scene/ply/ply.h"
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
  const std::size_t rank = (rms.size() - 1) * 99 / 100;
  std::nth_element(rms.begin(), rms.begin() + static_cast<std::ptrdiff_t>(rank), rms.end());
  network.rms_of_99 = static_cast<double>(rms[rank]);
  return network;
}

// Option --max_hashmap of Compact-3DGS, 19 by default.
constexpr int kLeastLog2Entries = 3, kMostLog2Entries = 21;

}  // namespace

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
