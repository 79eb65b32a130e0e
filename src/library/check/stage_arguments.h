// SPDX-License-Identifier: MIT
//
// The arguments of the differentiable rasterizer: checks of the caller's structs, and their arrays
// as the stages take them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "io/camera/lens.h"
#include "learn/diff/gaussians.h"
#include "learn/diff/rules.h"
#include "library/check/arrays.h"
#include "library/check/call.h"
#include "quadsplat/quadsplat.h"
#include "raster/api/renderer.h"

namespace qs::library {

// Cameras and settings of the caller as the renderer takes them.

/// A camera of the caller.
struct DrawnCamera {
  Camera camera;
  std::optional<Lens> lens = {};  ///< unset: a pinhole camera, or parallel rays
  double height = 0;              ///< above 0: of a picture of parallel rays, world units

  bool is_pinhole() const { return !lens && height == 0; }
  /// For RenderSettings::lens.
  std::shared_ptr<const LensView> view() const;
};

/// Throws Error(usage).
DrawnCamera drawn_camera_of(const QsCamera* camera, const Where& where);

/// A pinhole camera: others throw Error(usage).
Camera camera_of(const QsCamera* camera, const Where& where);

/// The members of QsCamera but its size.
QsCamera camera_struct(const DrawnCamera& camera);

/// The number of a culling mode, the default mode for null. Throws Error(usage).
CullMode mode_of(const char* name, const Where& where);

/// The usual settings for null. Throws Error(usage).
RenderSettings settings_of(const QsSettings* settings, const Where& where);

/// The arguments that all functions of the stages share, checked.
struct StageCall {
  const char* name;  ///< the function
  QsInputs inputs;
  std::int64_t gaussians, channels;
  std::int64_t coefficients;  ///< number of SH coefficients; 0: the inputs have channels
  Place place;                ///< where the arrays are
  diff::DrawnView view;       ///< without a position that is on a GPU

  /// Throws Error(usage).
  StageCall(const char* name, const QsInputs* inputs, const QsCamera* camera, const QsRules* rules);

  bool has_sh() const { return coefficients > 0; }
  std::uint32_t type() const { return inputs.means.type; }
  Types real() const { return 1u << type(); }
  Where where(const char* argument) const { return {name, argument}; }
};

// Copies of the caller's structs, with arrays that fit the call. Throw Error(usage).

/// Null: no array is wanted.
QsBoundary boundary_of(const StageCall& call, const QsBoundary* boundary);
QsBlended blended_of(const StageCall& call, const QsBlended* pictures, const char* argument,
                     Access access);
/// To be read: without the arrays that qs_project_backward() does not read.
QsBoundaryGradients boundary_gradients_of(const StageCall& call, const QsBoundaryGradients* given,
                                          Access access);
QsInputGradients input_gradients_of(const StageCall& call, const QsInputGradients* given);

/// The checked array as rows.
template <class T>
diff::Rows<T> rows_of(const QsArray& array) {
  if (is_absent(array)) return {};
  static std::remove_const_t<T> no_element{};  // a view without data would stand for no array
  T* const data = array.data == nullptr ? &no_element : static_cast<T*>(array.data);
  return {data, array.strides[0], array.dimensions > 1 ? array.strides[1] : 1};
}

template <class T>
diff::ShRows<T> sh_rows_of(const QsArray& first, const QsArray& rest) {
  if (is_absent(first)) return {};
  const auto dc_of = [](const QsArray& array) {
    diff::Rows<T> dc = rows_of<T>(array);
    dc.step = array.strides[2];
    return dc;
  };
  const diff::Rows<T> dc = dc_of(first);
  if (!is_absent(rest)) return {dc, dc_of(rest), rest.strides[1]};
  diff::Rows<T> second = dc;
  if (first.sizes[0] > 0 && first.sizes[1] > 1) second.data += first.strides[1];
  return {dc, second, first.strides[1]};
}

template <class T>
diff::Pixels<T> pixels_of(const QsArray& array) {
  if (is_absent(array)) return {};
  return {static_cast<T*>(array.data), array.strides[0], array.strides[1],
          array.dimensions > 2 ? array.strides[2] : 0};
}

template <class T>
diff::Pictures<T> pictures_of(const QsBlended& given) {
  return {pixels_of<T>(given.color), pixels_of<T>(given.alpha), pixels_of<T>(given.depth),
          pixels_of<T>(given.inverse_depth)};
}

/// The array of radii. A single radius takes both numbers, which are equal.
inline diff::Rows<std::int32_t> radius_rows_of(const QsArray& radii) {
  auto rows = rows_of<std::int32_t>(radii);
  if (radii.dimensions == 1) rows.step = 0;
  return rows;
}

/// The boundary's arrays of QsBoundary or QsBoundaryGradients.
template <class T, class Given>
diff::Boundary<T> boundary_rows_of(const Given& given) {
  diff::Boundary<T> rows{rows_of<T>(given.means_px), rows_of<T>(given.conics),
                         rows_of<T>(given.depths), rows_of<T>(given.opacities),
                         rows_of<T>(given.colors)};
  if constexpr (std::is_same_v<Given, QsBoundary>)
    if (given.corners == 1) rows.mean_offset = std::remove_const_t<T>(0.5);
  return rows;
}

template <class Real>
diff::InputGradients<Real> input_rows_of(const QsInputGradients& given) {
  return {rows_of<Real>(given.means),     rows_of<Real>(given.scales),
          rows_of<Real>(given.rotations), rows_of<Real>(given.covariances),
          rows_of<Real>(given.opacities), sh_rows_of<Real>(given.sh, given.sh_rest)};
}

template <class Real>
diff::GaussianInputs<Real> inputs_of(const StageCall& call) {
  const QsInputs& given = call.inputs;
  return {static_cast<std::size_t>(call.gaussians),
          rows_of<const Real>(given.means),
          rows_of<const Real>(given.scales),
          rows_of<const Real>(given.rotations),
          rows_of<const Real>(given.covariances),
          rows_of<const Real>(given.opacities),
          sh_rows_of<const Real>(given.sh, given.sh_rest),
          sh_degree_of(call.coefficients),
          rows_of<const Real>(given.channels),
          static_cast<int>(call.channels)};
}

/// The numbers of a checked array of one dimension; none if it is absent.
template <class Real>
std::vector<Real> numbers_in(const QsArray& array) {
  std::vector<Real> numbers(is_absent(array) ? 0 : static_cast<std::size_t>(array.sizes[0]));
  with_type(array, [&](const auto* elements) {
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] = static_cast<Real>(elements[offset_of(array, i)]);
  });
  return numbers;
}

/// Stores value(i, j) in a checked array of up to two dimensions; nothing if it is absent.
template <class Value>
void store_numbers(const QsArray& array, const Value& value) {
  if (is_absent(array)) return;
  const std::int64_t columns = array.dimensions > 1 ? array.sizes[1] : 1;
  with_type(array, [&](auto* elements) {
    for (std::int64_t i = 0; i < array.sizes[0]; ++i)
      for (std::int64_t j = 0; j < columns; ++j)
        elements[offset_of(array, i, j)] =
            static_cast<std::remove_pointer_t<decltype(elements)>>(value(i, j));
  });
}

}  // namespace qs::library
