// SPDX-License-Identifier: MIT
//
// A scene from the arrays of the caller.
#include <cmath>
#include <cstdint>

#include "io/cloud/fill_cloud.h"
#include "library/api/scene.h"
#include "library/check/arrays.h"
#include "library/check/gpu_arrays.h"
#include "library/check/structs.h"
#include "raster/kernel/constants.h"

using namespace qs::library;

namespace {

/// Element (i, j, k) of an array of real numbers, in double precision.
class Reals {
 public:
  explicit Reals(const QsArray& array) : array_(array) {}

  double operator()(std::size_t i, std::size_t j = 0, std::size_t k = 0) const {
    const std::ptrdiff_t place = offset_of(array_, i, j, k);
    if (array_.type == QS_FLOAT64) return static_cast<const double*>(array_.data)[place];
    return static_cast<double>(static_cast<const float*>(array_.data)[place]);
  }

  glm::vec3 vector(std::size_t i) const { return {real(i, 0), real(i, 1), real(i, 2)}; }
  float real(std::size_t i, std::size_t j, std::size_t k = 0) const {
    return static_cast<float>((*this)(i, j, k));
  }

 private:
  QsArray array_;
};

/// Checks everything but the values. Returns the number of SH coefficients per channel.
std::int64_t check_gaussians(const QsGaussians& given, const Where& where) {
  if (given.is_activated > 1) refuse(where / "is_activated", "is {}", given.is_activated);
  if (given.colors_are > QS_COLORS_RGB) refuse(where / "colors_are", "is {}", given.colors_are);
  if (given.antialiased > 1) refuse(where / "antialiased", "is {}", given.antialiased);
  check_dimensions(given.means, where / "means", 2);
  const Place place{given.means.memory, given.means.device, "means"};
  const std::int64_t count = given.means.sizes[0];
  if (count > kMostGaussians)
    refuse(where / "means", "{} Gaussians are more than {}", count, kMostGaussians);
  const ArrayChecks arrays{where, kReals, Access::reads, place};
  arrays.given(given.means, "means", {count, 3});
  arrays.given(given.scales, "scales", {count, 3});
  arrays.given(given.rotations, "rotations", {count, 4});
  arrays.given(given.opacities, "opacities", {count});
  if (given.colors_are != QS_COLORS_RGB)
    return arrays.sh(given.colors, "colors", given.rest, "rest", count);
  arrays.absent(given.rest, "rest", "belongs to spherical harmonics, but the colours are RGB");
  arrays.given(given.colors, "colors", {count, 3});
  return 1;
}

/// ln(o / (1 - o)); NaN outside of 0..1.
double logit_of(double opacity) { return std::log(opacity) - std::log1p(-opacity); }

/// Copies the Gaussians [begin, end) into the cloud, as logarithms, logits and SH.
void copy_gaussians(const QsGaussians& given, std::size_t begin, std::size_t end,
                    GaussianCloud& cloud) {
  const Reals means(given.means), scales(given.scales), rotations(given.rotations),
      opacities(given.opacities), colors(given.colors), rest(given.rest);
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  const std::size_t in_colors = is_absent(given.rest) ? coefficients : 1;
  for (std::size_t i = begin; i < end; ++i) {
    cloud.positions[i] = means.vector(i);
    cloud.rotations[i] = glm::quat(rotations.real(i, 0), rotations.real(i, 1), rotations.real(i, 2),
                                   rotations.real(i, 3));
    for (int axis = 0; axis < 3; ++axis) {
      const double scale = scales(i, static_cast<std::size_t>(axis));
      cloud.log_scales[i][axis] = static_cast<float>(given.is_activated ? std::log(scale) : scale);
    }
    const double opacity = opacities(i);
    cloud.opacity_logits[i] = static_cast<float>(given.is_activated ? logit_of(opacity) : opacity);
    for (int c = 0; c < 3; ++c) {
      const auto channel = static_cast<std::size_t>(c);
      if (given.colors_are == QS_COLORS_RGB) {
        cloud.sh[i][c] = static_cast<float>((colors(i, channel) - 0.5) / kSh0);
        continue;
      }
      for (std::size_t k = 0; k < coefficients; ++k)
        cloud.sh[i * coefficients + k][c] =
            k < in_colors ? colors.real(i, k, channel) : rest.real(i, k - 1, channel);
    }
  }
}

}  // namespace

int32_t qs_scene_wrap(QsContext* context, const QsGaussians* gaussians, QsSceneHandle** scene,
                      char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    *scene = nullptr;
    require(context, {function, "context"});
    const Where where{function, "gaussians"};
    QsGaussians given = read_struct(gaussians, where);
    const std::int64_t coefficients = check_gaussians(given, where);
    const Use use(*context->context, {function, "context"});
    HostCopies copies(use, given.stream);
    if (given.means.memory == QS_MEMORY_CUDA) {
      use.require_gpu(given.means.device, where / "means");
      for (QsArray* const array : {&given.means, &given.scales, &given.rotations, &given.opacities,
                                   &given.colors, &given.rest})
        *array = copies.of(*array);
    }
    Scene made;
    made.cloud.resize(static_cast<std::size_t>(given.means.sizes[0]), sh_degree_of(coefficients));
    made.cloud.antialiased = given.antialiased == 1;
    made.format = "memory";
    const std::vector<std::size_t> removed = fill_drawable(
        made.cloud, use.pool(), {{}, use.stop()},
        [&](std::size_t begin, std::size_t end) { copy_gaussians(given, begin, end, made.cloud); });
    *scene = new QsSceneHandle{OpenScene(context->context, std::move(made), removed)};
  });
}
