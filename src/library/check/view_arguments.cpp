// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <string>

#include "io/camera/camera_formats.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"
#include "raster/kernel/tile_grid.h"

namespace qs::library {
namespace {

constexpr int kLongestSide = 65535;  // pixels

void check_side(int pixels, const Where& where) {
  if (pixels < 1 || pixels > kLongestSide)
    refuse(where, "{} pixels are not between 1 and {}", pixels, kLongestSide);
}

double in_range(double value, double low, double high, const Where& where) {
  if (!(value >= low && value <= high))
    refuse(where, "{:.6g} is not between {:g} and {:g}", value, low, high);
  return value;
}

}  // namespace

Camera camera_of(const QsCamera* camera, const Where& where) {
  const QsCamera given = read_struct(camera, where);
  if (given.reserved != 0) refuse(where / "reserved", "is not 0");
  check_side(given.width, where / "width");
  check_side(given.height, where / "height");
  Camera result;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      result.view_from_world[column][row] = given.view_from_world[4 * row + column];
  result.focal_px = {given.focal_px[0], given.focal_px[1]};
  result.center_px = {given.center_px[0], given.center_px[1]};
  result.width = given.width;
  result.height = given.height;
  result.near_depth = given.near_depth;
  const double error = rotation_error(glm::dmat3(result.view_from_world));
  if (!(error < kMaxRotationError))
    refuse(where / "view_from_world", "its rotation is not a rotation matrix (off by {:.2g})",
           error);
  if (!(given.focal_px[0] > 0 && given.focal_px[1] > 0))
    refuse(where / "focal_px", "{:.6g} and {:.6g} are not above 0", given.focal_px[0],
           given.focal_px[1]);
  if (!(given.near_depth >= 0)) refuse(where / "near_depth", "{:.6g} is below 0", given.near_depth);
  try {
    check_camera(result, where.text());
  } catch (const Error& error_of_values) {
    throw Error(ErrorKind::usage, error_of_values.what());
  }
  return result;
}

QsCamera camera_struct(const Camera& camera) {
  QsCamera result{};
  result.width = camera.width;
  result.height = camera.height;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      result.view_from_world[4 * row + column] = camera.view_from_world[column][row];
  for (int axis = 0; axis < 2; ++axis) {
    result.focal_px[axis] = camera.focal_px[axis];
    result.center_px[axis] = camera.center_px[axis];
  }
  result.near_depth = camera.near_depth;
  return result;
}

CullMode mode_of(const char* name, const Where& where) {
  if (name == nullptr) return default_mode();
  const CullMode mode = find_culler(name);
  if (mode >= 0) return mode;
  std::string names;
  for (CullMode known = 0; known <= mode_count(); ++known)
    names += fmt::format("{}{}", known == 0 ? "" : ", ", mode_name(known));
  refuse(where, "'{}' is none of {}", name, names);
}

RenderSettings settings_of(const QsSettings* settings, const Where& where) {
  if (settings == nullptr) return {};
  const QsSettings given = read_struct(settings, where);
  if (given.reserved != 0) refuse(where / "reserved", "is not 0");
  if (given.pipeline > QS_PIPELINE_CLASSIC) refuse(where / "pipeline", "is {}", given.pipeline);
  if (given.antialiased > QS_ANTIALIASED_OFF)
    refuse(where / "antialiased", "is {}", given.antialiased);
  if (given.sh_degree < 0 || given.sh_degree > kMaxShDegree)
    refuse(where / "sh_degree", "{} is not between 0 and {}", given.sh_degree, kMaxShDegree);
  if (std::ranges::find(kTileSizes, given.tile_px) == kTileSizes.end())
    refuse(where / "tile_px", "{} is not 8, 16 or 32", given.tile_px);
  RenderSettings result;
  result.mode = mode_of(given.cull, where / "cull");
  result.pipeline = given.pipeline == QS_PIPELINE_FAST ? Pipeline::fast : Pipeline::classic;
  result.sh_degree = given.sh_degree;
  result.splat_scale = static_cast<float>(
      in_range(static_cast<double>(given.splat_scale), 1e-6, 1e6, where / "splat_scale"));
  for (int c = 0; c < 3; ++c) {
    if (!std::isfinite(given.background[c])) refuse(where / "background", "is not finite");
    result.background[c] = given.background[c];
  }
  if (given.antialiased != QS_ANTIALIASED_AS_TRAINED)
    result.antialiased = given.antialiased == QS_ANTIALIASED_ON;
  result.dilation = in_range(given.dilation_px2, 0, 1e6, where / "dilation_px2");
  result.tile_px = given.tile_px;
  return result;
}

}  // namespace qs::library

using namespace qs::library;

int32_t qs_camera_resize(QsCamera* camera, int32_t width, int32_t height, char* message) {
  return library::call(__func__, message, [&](const char* function) {
    const Camera given = camera_of(camera, {function, "camera"});
    check_side(width, {function, "width"});
    check_side(height, {function, "height"});
    write_struct(camera_struct(given.resized(width, height)), camera, {function, "camera"});
  });
}
