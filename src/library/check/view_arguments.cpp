// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <glm/gtc/type_ptr.hpp>
#include <glm/matrix.hpp>

#include "io/camera/camera_formats.h"
#include "io/camera/colmap.h"
#include "io/camera/lens_views.h"
#include "library/check/stage_arguments.h"
#include "library/check/structs.h"
#include "raster/kernel/tile_grid.h"

namespace qs::library {
namespace {

constexpr int kLongestSide = 65535;  // pixels
constexpr std::string_view kOrthographic = "ORTHOGRAPHIC";

void check_side(int pixels, const Where& where) {
  if (pixels < 1 || pixels > kLongestSide)
    refuse(where, "{} pixels are not between 1 and {}", pixels, kLongestSide);
}

double in_range(double value, double low, double high, const Where& where) {
  if (!(value >= low && value <= high))
    refuse(where, "{:.6g} is not between {:g} and {:g}", value, low, high);
  return value;
}

// The intrinsics by the model. Parameters that it does not have are 0.
void set_model(DrawnCamera& drawn, const QsCamera& given, const Where& where) {
  const std::string name(given.model, strnlen(given.model, sizeof(given.model)));
  const bool is_parallel = name == kOrthographic;
  const LensModel* const model = find_lens_model(name);
  if (!is_parallel && model == nullptr)
    refuse(where / "model", "'{}' is no camera model of COLMAP, and not {}", name, kOrthographic);
  for (const double value :
       {given.focal_px[0], given.focal_px[1], given.center_px[0], given.center_px[1]})
    if (value != 0)
      refuse(where / "model", "{} has its parameters, so focal_px and center_px must be 0", name);
  const auto count = static_cast<std::size_t>(is_parallel ? 1 : model->parameters());
  if (given.parameter_count != count)
    refuse(where / "parameters", "{} has {} of them, but {} are given", name, count,
           given.parameter_count);
  const std::span used = std::span(given.parameters).first(count);
  Camera& camera = drawn.camera;
  if (is_parallel) {
    drawn.height = in_range(used[0], 1e-12, 1e12, where / "parameters");
    camera.focal_px = glm::dvec2(camera.height / drawn.height);
    camera.center_px = 0.5 * glm::dvec2(camera.width - 1, camera.height - 1);
    return;
  }
  const Lens lens = checked_lens(colmap_lens({*model,
                                              static_cast<std::uint64_t>(camera.width),
                                              static_cast<std::uint64_t>(camera.height),
                                              {used.begin(), used.end()}},
                                             where.text()),
                                 where.text());
  camera.focal_px = lens.focal_px;
  camera.center_px = lens.center_px;
  if (distorts(lens)) drawn.lens = lens;
}

DrawnCamera checked_camera(const QsCamera& given, const Where& where) {
  if (given.reserved != 0 || given.reserved2 != 0) refuse(where / "reserved", "is not 0");
  check_side(given.width, where / "width");
  check_side(given.height, where / "height");
  DrawnCamera drawn;
  Camera& result = drawn.camera;
  result.view_from_world = glm::transpose(glm::make_mat3x4(given.view_from_world));
  result.focal_px = {given.focal_px[0], given.focal_px[1]};
  result.center_px = {given.center_px[0], given.center_px[1]};
  result.width = given.width;
  result.height = given.height;
  result.near_depth = given.near_depth;
  const double error = rotation_error(glm::dmat3(result.view_from_world));
  if (!(error < kMaxRotationError))
    refuse(where / "view_from_world", "its rotation is not a rotation matrix (off by {:.2g})",
           error);
  if (given.model[0] != 0)
    set_model(drawn, given, where);
  else if (given.parameter_count != 0 ||
           std::ranges::any_of(given.parameters, [](double value) { return value != 0; }))
    refuse(where / "model", "is empty, but there are parameters");
  else if (!(given.focal_px[0] > 0 && given.focal_px[1] > 0))
    refuse(where / "focal_px", "{:.6g} and {:.6g} are not above 0", given.focal_px[0],
           given.focal_px[1]);
  if (!(given.near_depth >= 0)) refuse(where / "near_depth", "{:.6g} is below 0", given.near_depth);
  check_camera(result, where.text());
  return drawn;
}

}  // namespace

std::shared_ptr<const LensView> DrawnCamera::view() const {
  if (is_pinhole()) return nullptr;
  return std::make_shared<const LensView>(lens ? photograph_view(*lens) : parallel_view(height));
}

DrawnCamera drawn_camera_of(const QsCamera* camera, const Where& where) {
  const QsCamera given = read_struct(camera, where);
  try {
    return checked_camera(given, where);
  } catch (const Error& error) {
    throw Error(ErrorKind::usage, error.what());
  }
}

Camera camera_of(const QsCamera* camera, const Where& where) {
  const DrawnCamera drawn = drawn_camera_of(camera, where);
  if (!drawn.is_pinhole())
    refuse(where / "model", "{} is drawn by qs_render() alone, and this takes a pinhole camera",
           drawn.lens ? drawn.lens->model->name : kOrthographic);
  return drawn.camera;
}

QsCamera camera_struct(const DrawnCamera& drawn) {
  const Camera& camera = drawn.camera;
  QsCamera result{};
  result.width = camera.width;
  result.height = camera.height;
  std::copy_n(glm::value_ptr(glm::transpose(camera.view_from_world)), 12, result.view_from_world);
  result.near_depth = camera.near_depth;
  for (int axis = 0; axis < 2 && drawn.is_pinhole(); ++axis) {
    result.focal_px[axis] = camera.focal_px[axis];
    result.center_px[axis] = camera.center_px[axis];
  }
  if (drawn.is_pinhole()) return result;
  copy_text(drawn.lens ? drawn.lens->model->name : kOrthographic, result.model,
            sizeof(result.model));
  const std::vector<double> parameters =
      drawn.lens ? colmap_parameters(*drawn.lens) : std::vector{drawn.height};
  result.parameter_count = static_cast<std::uint32_t>(parameters.size());
  std::ranges::copy(parameters, result.parameters);
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
    const Where where{function, "camera"};
    DrawnCamera given = drawn_camera_of(camera, where);
    check_side(width, {function, "width"});
    check_side(height, {function, "height"});
    given.camera = given.camera.resized(width, height);
    if (given.lens) {
      given.lens->size_px = {width, height};
      given.lens->focal_px = given.camera.focal_px;
      given.lens->center_px = given.camera.center_px;
    }
    QsCamera resized = camera_struct(given);
    resized.size = sizeof(resized);
    drawn_camera_of(&resized, where);  // throws
    write_struct(resized, camera, where);
  });
}
