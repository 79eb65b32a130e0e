// SPDX-License-Identifier: MIT
//
// A camera from the matrices that trainers have.
#include <algorithm>
#include <array>
#include <cmath>

#include "library/check/arrays.h"
#include "library/check/context.h"
#include "library/check/gpu_arrays.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"

using namespace qs::library;

namespace {

using Matrix = std::array<std::array<double, 4>, 4>;  // rows

/// The numbers of a checked array of up to 4 x 4. Waits for an array on a GPU.
Matrix matrix_of(const QsArray& array, HostCopies& copies) {
  const QsArray host = copies.of(array);
  Matrix rows{};
  with_type(host, [&](const auto* elements) {
    for (std::int64_t i = 0; i < host.sizes[0]; ++i)
      for (std::int64_t j = 0; j < host.sizes[1]; ++j)
        rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] =
            static_cast<double>(elements[offset_of(host, i, j)]);
  });
  return rows;
}

/// The principal point in normalised device coordinates, of clip = P view. Throws Error(usage).
std::array<double, 2> offset_of_clip(const Matrix& view, const Matrix& clip,
                                     const double (&tangents)[2], const Where& where) {
  // clip = P view with view = (R t; 0 1): P is clip (R^T  -R^T t; 0 1), row by row.
  Matrix lens{};
  double reach = 0;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 3; ++column)
      for (int k = 0; k < 3; ++k) lens[row][column] += clip[row][k] * view[column][k];
    lens[row][3] = clip[row][3];
    for (int k = 0; k < 3; ++k) lens[row][3] -= lens[row][k] * view[k][3];
  }
  for (int k = 0; k < 3; ++k) reach = std::max(reach, std::abs(view[k][3]));
  const auto is_zero = [](double value, double tolerance) { return std::abs(value) < tolerance; };
  const double far = 1e-3 * (1 + reach);
  const bool is_perspective =
      is_zero(lens[0][0] * tangents[0] - 1, 1e-3) && is_zero(lens[1][1] * tangents[1] - 1, 1e-3) &&
      is_zero(lens[0][1], 1e-3) && is_zero(lens[1][0], 1e-3) && is_zero(lens[3][0], 1e-3) &&
      is_zero(lens[3][1], 1e-3) && is_zero(lens[3][2] - 1, 1e-3) && is_zero(lens[0][3], far) &&
      is_zero(lens[1][3], far) && is_zero(lens[3][3], far);
  if (!is_perspective)
    refuse(where, "is not the view times a perspective projection with the given fields of view");
  const auto exact = [](double value) { return std::abs(value) < 1e-5 ? 0 : value; };
  return {exact(lens[0][2]), exact(lens[1][2])};
}

void check_small(const QsArray& array, const Where& where, std::int64_t rows,
                 std::int64_t columns) {
  const Place place{array.memory, array.device, ""};
  check_array(array, where, {rows, columns}, kReals, Access::reads, place);
}

}  // namespace

int32_t qs_camera_of_matrices(QsContext* context, const QsMatrices* matrices, QsCamera* camera,
                              char* message) {
  return library::call(__func__, message, "context", context, [&](const char* function) {
    const Where where{function, "matrices"}, of_camera{function, "camera"};
    const QsMatrices given = read_struct(matrices, where);
    QsCamera made = read_struct(camera, of_camera);
    if (given.is_clip > 1) refuse(where / "is_clip", "is {}", given.is_clip);
    const bool has_last = given.view.dimensions == 2 && given.view.sizes[0] == 4;
    check_small(given.view, where / "view", has_last ? 4 : 3, 4);
    check_small(given.lens, where / "lens", given.is_clip ? 4 : 3, given.is_clip ? 4 : 3);
    const bool has_position = given.at != nullptr;
    if (has_position)
      check_array(given.position, where / "position", {3}, kReals, Access::reads,
                  {given.position.memory, given.position.device, ""});
    const Use use(*context->context, {function, "context"});
    for (const auto& [array, name] :
         {std::pair{&given.view, "view"}, {&given.lens, "lens"}, {&given.position, "position"}})
      if (array->memory == QS_MEMORY_CUDA) use.require_gpu(array->device, where / name);
    HostCopies copies(use, given.stream);
    const Matrix view = matrix_of(given.view, copies), lens = matrix_of(given.lens, copies);
    if (has_last)
      for (int column = 0; column < 4; ++column)
        if (!(std::abs(view[3][column] - (column == 3 ? 1 : 0)) <= 1e-6))
          refuse(where / "view",
                 "has the last row {:g}, {:g}, {:g}, {:g} instead of 0, 0, 0, 1: it "
                 "may be transposed",
                 view[3][0], view[3][1], view[3][2], view[3][3]);
    for (int i = 0; i < 12; ++i) made.view_from_world[i] = view[i / 4][i % 4];
    if (given.is_clip) {
      const auto offset = offset_of_clip(view, lens, given.half_fov, where / "lens");
      const int sizes[] = {made.width, made.height};
      for (int axis = 0; axis < 2; ++axis) {
        const double size = sizes[axis], tangent = given.half_fov[axis];
        made.focal_px[axis] = tangent > 0 ? size / (2 * tangent) : 0;
        made.center_px[axis] = ((offset[static_cast<std::size_t>(axis)] + 1) * size - 1) / 2;
      }
    } else {
      if (lens[0][1] != 0) refuse(where / "lens", "has a skew, which quadsplat does not have");
      for (int axis = 0; axis < 2; ++axis) {
        made.focal_px[axis] = lens[axis][axis];
        made.center_px[axis] = lens[axis][2] - 0.5;
      }
    }
    if (has_position) {
      QsArray row = given.position;  // as 1 x 3
      row.dimensions = 2;
      row.sizes[0] = 1;
      row.sizes[1] = 3;
      row.strides[1] = row.strides[0];
      const Matrix at = matrix_of(row, copies);
      std::copy_n(at[0].begin(), 3, given.at);
    }
    camera_of(&made, of_camera);
    write_struct(made, camera, of_camera);
  });
}
