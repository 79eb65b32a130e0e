// SPDX-License-Identifier: MIT
//
// The Gaussians of a scene, copied into the arrays of the caller.
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "library/api/scene.h"
#include "library/check/arrays.h"
#include "library/check/structs.h"
#include "raster/scene/activated_cloud.h"

using namespace qs::library;

namespace {

/// Checks everything before any element is written.
void check_wanted(const QsGaussians& wanted, const QsSceneFacts& facts, const Where& where) {
  if (wanted.is_activated > 1) refuse(where / "is_activated", "is {}", wanted.is_activated);
  if (wanted.colors_are == QS_COLORS_RGB)
    refuse(where / "colors_are", "is QS_COLORS_RGB, but scenes have spherical harmonics");
  if (wanted.colors_are != QS_COLORS_SH) refuse(where / "colors_are", "is {}", wanted.colors_are);
  if (wanted.antialiased != 0)
    refuse(where / "antialiased", "is {} instead of 0: qs_scene_facts() has it",
           wanted.antialiased);
  const auto count = static_cast<std::int64_t>(facts.gaussians);
  const ArrayChecks arrays{where, kReals, Access::writes};
  arrays.optional(wanted.means, "means", {count, 3});
  arrays.optional(wanted.scales, "scales", {count, 3});
  arrays.optional(wanted.rotations, "rotations", {count, 4});
  arrays.optional(wanted.opacities, "opacities", {count});
  if (is_absent(wanted.colors) && is_absent(wanted.rest)) return;
  const std::int64_t coefficients = arrays.sh(wanted.colors, "colors", wanted.rest, "rest", count);
  if (coefficients > sh_coefficient_count(facts.sh_degree))
    refuse(where / "colors", "{} coefficients are more than the scene's {}", coefficients,
           sh_coefficient_count(facts.sh_degree));
}

/// The Gaussians of numbers begin .. end - 1.
struct Range {
  const OpenScene& scene;
  std::size_t begin, end;
};

/// Stores value(index, j, k), a double, as element (i, j, k) for each Gaussian i of the range and
/// its index in the cloud. Rows of Gaussians that are not drawn become NaN.
template <class Value>
void store_rows(const QsArray& array, const Range& range, const Value& value) {
  if (is_absent(array)) return;
  const auto columns = static_cast<std::size_t>(array.dimensions > 1 ? array.sizes[1] : 1);
  const auto channels = static_cast<std::size_t>(array.dimensions > 2 ? array.sizes[2] : 1);
  with_type(array, [&](auto* elements) {
    using Element = std::remove_pointer_t<decltype(elements)>;
    if constexpr (std::is_floating_point_v<Element>) {
      for (std::size_t i = range.begin; i < range.end; ++i) {
        const std::optional<std::size_t> index = range.scene.index_of(i);

        for (std::size_t j = 0; j < columns; ++j)
          for (std::size_t k = 0; k < channels; ++k)
            elements[offset_of(array, i, j, k)] = index ? static_cast<Element>(value(*index, j, k))
                                                        : std::numeric_limits<Element>::quiet_NaN();
      }
    }
  });
}

void store_gaussians(const QsGaussians& wanted, const Range& range) {
  const GaussianCloud& cloud = range.scene.cloud();
  const auto axis = [](std::size_t j) { return static_cast<glm::length_t>(j); };
  store_rows(wanted.means, range, [&](std::size_t i, std::size_t j, std::size_t) {
    return static_cast<double>(cloud.positions[i][axis(j)]);
  });
  store_rows(wanted.scales, range, [&](std::size_t i, std::size_t j, std::size_t) {
    const auto logarithm = static_cast<double>(cloud.log_scales[i][axis(j)]);
    return wanted.is_activated ? std::exp(logarithm) : logarithm;
  });
  store_rows(wanted.rotations, range, [&](std::size_t i, std::size_t j, std::size_t) {
    const glm::quat& q = cloud.rotations[i];
    return static_cast<double>(j == 0 ? q.w : j == 1 ? q.x : j == 2 ? q.y : q.z);
  });
  store_rows(wanted.opacities, range, [&](std::size_t i, std::size_t, std::size_t) {
    const float logit = cloud.opacity_logits[i];
    return wanted.is_activated ? opacity_of_logit(logit) : static_cast<double>(logit);
  });
  const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(cloud.sh_degree));
  const auto sh_from = [&](std::size_t first) {
    return [&cloud, coefficients, axis, first](std::size_t i, std::size_t j, std::size_t k) {
      return static_cast<double>(cloud.sh[i * coefficients + first + j][axis(k)]);
    };
  };
  store_rows(wanted.colors, range, sh_from(0));
  store_rows(wanted.rest, range, sh_from(1));
}

}  // namespace

int32_t qs_scene_gaussians(QsSceneHandle* scene, const QsGaussians* gaussians, char* message) {
  return library::call(__func__, message, "scene", scene, [&](const char* function) {
    const Where where{function, "gaussians"};
    const QsGaussians wanted = read_struct(gaussians, where);
    const OpenScene& open = scene->scene;
    const QsSceneFacts facts = open.facts();
    check_wanted(wanted, facts, where);
    const Use use(open.context(), {function, "scene"});
    use.pool().for_chunks(static_cast<std::size_t>(facts.gaussians), 1024,
                          [&](std::size_t begin, std::size_t end, int) {
                            store_gaussians(wanted, {open, begin, end});
                          });
  });
}
