// SPDX-License-Identifier: MIT
#include "library/check/stage_arguments.h"

#include <limits>

#include "library/check/structs.h"

namespace qs::library {
namespace {

using diff::Rules;

void check_reserved(std::uint32_t reserved, const Where& where) {
  if (reserved != 0) refuse(where / "reserved", "is not 0");
}

bool flag_of(std::uint32_t value, const Where& where) {
  if (value > 1) refuse(where, "is {}", value);
  return value == 1;
}

bool has_third_number(const QsBoundary&) { return false; }
bool has_third_number(const QsBoundaryGradients& given) {
  return given.ndc == 1 && given.means_px.dimensions == 2 && given.means_px.sizes[1] == 3;
}

/// The arrays that QsBoundary and QsBoundaryGradients share.
template <class Struct>
void check_boundary(const ArrayChecks& arrays, const Struct& given, const StageCall& call) {
  const std::int64_t count = call.gaussians;
  const bool has_third = has_third_number(given);
  arrays.optional(given.means_px, "means_px", {count, has_third ? 3 : 2});
  arrays.optional(given.conics, "conics", {count, 3});
  arrays.optional(given.depths, "depths", {count});
  arrays.optional(given.opacities, "opacities", {count});
  if (!call.has_sh())
    arrays.absent(given.colors, "colors", "belongs to sh, but the inputs have channels");
  arrays.optional(given.colors, "colors", {count, 3});
}

/// `coefficients`: 0 for channels.
void check_inputs(const QsInputs& given, const Where& where, const Place& place,
                  std::int64_t& count, std::int64_t& channels, std::int64_t& coefficients) {
  check_reserved(given.reserved, where);
  check_dimensions(given.means, where / "means", 2);
  count = given.means.sizes[0];
  if (count > kMostGaussians)
    refuse(where / "means", "{} Gaussians are more than {}", count, kMostGaussians);
  ArrayChecks{where, kReals, Access::reads, place}.given(given.means, "means", {count, 3});
  if (place.is_gpu() && given.means.type != QS_FLOAT32)
    refuse(where / "means", "has elements of type float64, which only the CPU computes");
  const ArrayChecks arrays{where, 1u << given.means.type, Access::reads, place};
  if (is_absent(given.covariances)) {
    arrays.given(given.scales, "scales", {count, 3});
    arrays.given(given.rotations, "rotations", {count, 4});
  } else {
    arrays.given(given.covariances, "covariances", {count, 6});
    arrays.absent(given.scales, "scales", "is given, and so are covariances");
    arrays.absent(given.rotations, "rotations", "is given, and so are covariances");
  }
  arrays.given(given.opacities, "opacities", {count});
  if (is_absent(given.channels)) {
    coefficients = arrays.sh(given.sh, "sh", given.sh_rest, "sh_rest", count);
    channels = 3;
  } else {
    arrays.absent(given.sh, "sh", "is given, and so are channels");
    arrays.absent(given.sh_rest, "sh_rest", "is given, and so are channels");
    check_dimensions(given.channels, where / "channels", 2);
    coefficients = 0;
    channels = given.channels.sizes[1];
    if (channels < 1 || channels > diff::kMostChannels)
      refuse(where / "channels", "{} channels are not between 1 and {}", channels,
             diff::kMostChannels);
    arrays.given(given.channels, "channels", {count, channels});
  }
  arrays.optional_small(given.background, "background", {channels});
  ArrayChecks{where, kReals, Access::reads, place}.optional_small(given.position, "position", {3});
}

Rules rules_of(const QsRules& given, const Where& where) {
  Rules rules;
  if (given.far_depth != 0) rules.far_depth = given.far_depth;
  rules.dilation = given.dilation_px2;
  rules.splat_scale = given.splat_scale;
  rules.compensation_floor = given.compensation_floor;
  rules.alpha_max = given.alpha_max;
  rules.radius_clip = given.radius_clip_px;
  const diff::SlopeBounds slopes{{given.slope_low[0], given.slope_low[1]},
                                 {given.slope_high[0], given.slope_high[1]}};
  if (slopes.low != glm::dvec2(0) || slopes.high != glm::dvec2(0)) rules.slopes = slopes;
  rules.antialiased = flag_of(given.antialiased, where / "antialiased");
  rules.normalises_rotations =
      !flag_of(given.keeps_rotation_length, where / "keeps_rotation_length");
  rules.zero_color_passes = flag_of(given.zero_color_passes, where / "zero_color_passes");
  rules.alpha_max_passes = !flag_of(given.alpha_max_blocks, where / "alpha_max_blocks");
  rules.stops_at_equal = flag_of(given.stops_at_equal, where / "stops_at_equal");
  static_assert(static_cast<int>(RadiusRule::inria) == QS_RADII_INRIA);
  static_assert(static_cast<int>(RadiusRule::gsplat_1_4) == QS_RADII_GSPLAT_1_4);
  static_assert(static_cast<int>(RadiusRule::gsplat_1_5) == QS_RADII_GSPLAT_1_5);
  if (given.radius_rule > QS_RADII_GSPLAT_1_5)
    refuse(where / "radius_rule", "is {}", given.radius_rule);
  rules.radius_rule = static_cast<RadiusRule>(given.radius_rule);
  return rules;
}

}  // namespace

StageCall::StageCall(const char* function, const QsInputs* of_inputs, const QsCamera* of_camera,
                     const QsRules* of_rules)
    : name(function),
      inputs(read_struct(of_inputs, where("inputs"))),
      place{inputs.means.memory, inputs.means.device, "means"} {
  check_inputs(inputs, where("inputs"), place, gaussians, channels, coefficients);
  view.camera = camera_of(of_camera, where("camera"));
  const QsRules usual = QS_RULES;
  const QsRules given = read_struct(of_rules == nullptr ? &usual : of_rules, where("rules"));
  view.rules = rules_of(given, where("rules"));
  view.rules.near_depth = view.camera.near_depth;
  view.mode = mode_of(given.cull, where("rules") / "cull");
  view.sh_degree = given.sh_degree;
  if (!is_absent(inputs.position) && inputs.position.memory == QS_MEMORY_HOST) {
    const std::vector<double> at = numbers_in<double>(inputs.position);
    view.position = glm::dvec3(at[0], at[1], at[2]);
  }
  view.check(name);
}

QsBoundary boundary_of(const StageCall& call, const QsBoundary* boundary) {
  if (boundary == nullptr) return {};
  const Where where = call.where("boundary");
  const QsBoundary given = read_struct(boundary, where);
  flag_of(given.corners, where / "corners");
  check_boundary({where, call.real(), Access::writes, call.place}, given, call);
  const ArrayChecks of_radii{where, 1u << QS_INT32, Access::writes, call.place};
  const bool has_one = given.radii.dimensions == 1;
  if (has_one && call.view.rules.radius_rule == RadiusRule::gsplat_1_5)
    refuse(where / "radii", "has 1 dimension, but the rule has a radius for each axis");
  if (has_one)
    of_radii.given(given.radii, "radii", {call.gaussians});
  else
    of_radii.optional(given.radii, "radii", {call.gaussians, 2});
  return given;
}

QsBlended blended_of(const StageCall& call, const QsBlended* pictures, const char* argument,
                     Access access) {
  const Where where = call.where(argument);
  const QsBlended given = read_struct(pictures, where);
  check_reserved(given.reserved, where);
  const ArrayChecks arrays{where, call.real(), access, call.place};
  const std::int64_t width = call.view.camera.width, height = call.view.camera.height;
  arrays.optional(given.color, "color", {height, width, call.channels});
  arrays.optional(given.alpha, "alpha", {height, width});
  arrays.optional(given.depth, "depth", {height, width});
  arrays.optional(given.inverse_depth, "inverse_depth", {height, width});
  return given;
}

QsBoundaryGradients boundary_gradients_of(const StageCall& call, const QsBoundaryGradients* given,
                                          Access access) {
  const ArrayChecks arrays{call.where("by_boundary"), call.real(), access, call.place};
  QsBoundaryGradients by = read_struct(given, arrays.where);
  if (flag_of(by.ndc, arrays.where / "ndc") && access == Access::reads)
    refuse(arrays.where / "ndc", "is 1, but derivatives that are read are by pixels");
  check_boundary(arrays, by, call);
  if (access == Access::reads) {
    by.channels = by.absolute_px = by.background = {};
    return by;
  }
  if (call.has_sh())
    arrays.absent(by.channels, "channels", "belongs to channels, but the inputs have sh");
  arrays.optional(by.channels, "channels", {call.gaussians, call.channels});
  arrays.optional(by.absolute_px, "absolute_px", {call.gaussians, 2});
  arrays.optional_small(by.background, "background", {call.channels});
  return by;
}

QsInputGradients input_gradients_of(const StageCall& call, const QsInputGradients* given) {
  const ArrayChecks arrays{call.where("by_inputs"), call.real(), Access::writes, call.place};
  const Where& where = arrays.where;
  const QsInputGradients by = read_struct(given, where);
  check_reserved(by.reserved, where);
  const std::int64_t count = call.gaussians;
  arrays.optional(by.means, "means", {count, 3});
  if (is_absent(call.inputs.covariances)) {
    arrays.absent(by.covariances, "covariances", "belongs to covariances, which are not given");
  } else {
    arrays.absent(by.scales, "scales", "belongs to scales, which are not given");
    arrays.absent(by.rotations, "rotations", "belongs to rotations, which are not given");
  }
  arrays.optional(by.scales, "scales", {count, 3});
  arrays.optional(by.rotations, "rotations", {count, 4});
  arrays.optional(by.covariances, "covariances", {count, 6});
  arrays.optional(by.opacities, "opacities", {count});
  if (!call.has_sh()) {
    arrays.absent(by.sh, "sh", "belongs to sh, but the inputs have channels");
    arrays.absent(by.sh_rest, "sh_rest", "belongs to sh, but the inputs have channels");
  } else if (!is_absent(by.sh) || !is_absent(by.sh_rest)) {
    const std::int64_t coefficients = arrays.sh(by.sh, "sh", by.sh_rest, "sh_rest", count);
    if (coefficients != call.coefficients)
      refuse(where / "sh", "has {} coefficients, but the inputs have {}", coefficients,
             call.coefficients);
  }
  const ArrayChecks of_pose{where, kReals, Access::writes, call.place};
  of_pose.optional_small(by.view_from_world, "view_from_world", {3, 4});
  of_pose.optional_small(by.position, "position", {3});
  return by;
}

}  // namespace qs::library
