// SPDX-License-Identifier: MIT
#include "learn/run/field_model.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "io/scene/compact/compact_model.h"
#include "learn/field/code_training.h"
#include "learn/step/shape_codes.h"
#include "raster/field/field_evaluator.h"
#include "raster/kernel/activation.h"
#include "raster/kernel/random.h"

namespace qs::train {
namespace {

// The parameters as the passes draw them.
Parameters drawn_parameters(const ModelState& model, ThreadPool& pool) {
  Parameters drawn = model.parameters;
  if (model.codes.exist()) code_shapes(model.parameters, model.codes, pool, drawn);
  return drawn;
}

ResidualCodebook fitted(std::span<const float> values, std::size_t dimensions, const Random& random,
                        ThreadPool& pool, int rounds) {
  ResidualCodebook shape;
  shape.dimensions = dimensions;
  return fit_codebook(shape, values, random, pool, rounds);
}

// Of two quaternions of the same rotation, the quaternion with w >= 0 is taken.
CompactModel compact_model_of(const ModelState& model, ThreadPool& pool) {
  const GaussianCloud cloud = to_cloud(drawn_parameters(model, pool), false);
  CompactModel file;
  file.field = model.color_field.field;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::quat q = cloud.rotations[i].w < 0 ? -cloud.rotations[i] : cloud.rotations[i];
    const glm::vec3& s = cloud.log_scales[i];
    file.means.push_back(cloud.positions[i]);
    file.scales.push_back({std::exp(s.x), std::exp(s.y), std::exp(s.z)});
    file.rotations.push_back({q.w, q.x, q.y, q.z});
    file.opacities.push_back(opacity_of(cloud.opacity_logits[i]));
  }
  return file;
}

}  // namespace

FieldState starting_field(std::uint64_t seed, const GridShape& grid, int width) {
  constexpr double kGridBound = 1e-4;
  ColorField field;
  field.grid = grid;
  field.width = width;
  const NetworkShape shape = field.network();
  field.grid_values.resize(grid_value_count(grid));
  field.weights.resize(shape.weight_count());
  const Random random = Random::of(seed, RandomUse::color_field, 0);
  std::uint64_t number = 0;
  const auto drawn = [&](double bound) {
    return static_cast<float>(bound * (2 * random.uniform(number++) - 1));
  };
  for (float& value : field.grid_values) value = drawn(kGridBound);
  for (std::size_t k = 0; k < field.weights.size(); ++k) {
    const int sum = k < shape.second()  ? shape.width + shape.inputs()
                    : k < shape.third() ? 2 * shape.width
                                        : NetworkShape::kOutputs + shape.width;
    field.weights[k] = drawn(std::sqrt(6.0 / sum));
  }
  return FieldState::starting_with(std::move(field));
}

double field_rate_at(int iteration) {
  constexpr double kFirst = 1e-4, kMost = 0.01, kFall = 0.33;
  constexpr int kGrows = 100;
  if (iteration <= kGrows) return kFirst + (kMost - kFirst) * (iteration - 1) / kGrows;
  double rate = kMost;
  for (const int end : {5000, 15'000, 25'000}) rate *= iteration > end ? kFall : 1;
  return rate;
}

GaussianCloud fitted_cloud(const ModelState& model, bool antialiased, ThreadPool& pool) {
  constexpr std::size_t kGrain = 1024, kCoefficients = sh_coefficient_count(kMaxShDegree);
  GaussianCloud cloud = to_cloud(drawn_parameters(model, pool), antialiased);
  cloud.sh_degree = kMaxShDegree;
  cloud.sh.resize(cloud.size() * kCoefficients);
  const FieldEvaluator evaluator(model.color_field.field);
  pool.for_chunks(cloud.size(), kGrain, [&](std::size_t begin, std::size_t end, int) {
    std::vector<float> rms(end - begin);
    evaluator.fit_sh(
        std::span(cloud.positions.data() + begin, end - begin),
        std::span(cloud.sh.data() + begin * kCoefficients, (end - begin) * kCoefficients), rms);
  });
  return cloud;
}

ShapeCodes first_codes(const ModelState& model, std::uint64_t seed, ThreadPool& pool) {
  const auto drawn = [&](const std::vector<float>& values, std::size_t dimensions,
                         std::uint64_t use) {
    return CodeState::starting_with(
        fitted(values, dimensions, Random::of(seed, RandomUse::color_field, use), pool, 1));
  };
  return {drawn(scale_vectors(model.parameters), 3, 3),
          drawn(rotation_vectors(model.parameters), 4, 4)};
}

void write_field_model(const ModelState& model, const std::filesystem::path& path,
                       ThreadPool& pool) {
  write_compact_ply(compact_model_of(model, pool), path, true);
}

void write_coded_models(const ModelState& model, std::uint64_t seed,
                        const std::filesystem::path& path, ThreadPool& pool) {
  const CompactModel file = compact_model_of(model, pool);
  Parameters existing;
  existing.sh_degree = 0;
  for (std::size_t i = 0; i < model.parameters.size(); ++i) {
    if (model.parameters.is_masked_out(i)) continue;
    existing.log_scales.push_back(model.parameters.log_scales[i]);
    existing.rotations.push_back(model.parameters.rotations[i]);
    existing.means.push_back(model.parameters.means[i]);
  }
  const auto coded_vectors = [&](const CodeState& trained, const std::vector<float>& values,
                                 std::size_t dimensions, std::uint64_t use) {
    CodedVectors result;
    result.codebook =
        trained.exists()
            ? trained.codebook
            : fitted(values, dimensions, Random::of(seed, RandomUse::color_field, use), pool, 10);
    result.numbers = encode_all(result.codebook, values, pool);
    return result;
  };
  const CodedVectors scales = coded_vectors(model.codes.scales, scale_vectors(existing), 3, 1),
                     rotations =
                         coded_vectors(model.codes.rotations, rotation_vectors(existing), 4, 2);
  const auto forms = other_forms(path);
  write_compact_npz(file, scales, rotations, forms[1]);
  write_compact_processed(file, scales, rotations, forms[2]);
}

std::vector<std::filesystem::path> other_forms(const std::filesystem::path& path) {
  const std::string stem = (path.parent_path() / path.stem()).string();
  return {stem + ".pth", stem + ".npz", stem + "_pp.npz"};
}

}  // namespace qs::train
