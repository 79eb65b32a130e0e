// SPDX-License-Identifier: MIT
//
// Views of the scenes of stage_scenes.h through the C interface: all arguments of the
// differentiable rasterizer and its results.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "library/opened_scene.h"
#include "support/stage_scenes.h"

namespace qs::test {

using quadsplat::array_of;
using quadsplat::sized;

/// The memory of frames. It may refuse a kind.
class Blocks {
 public:
  QsMemory memory() {
    auto memory = sized<QsMemory>();
    memory.user = this;
    memory.allocate = [](void* user, std::uint64_t bytes, std::uint32_t kind) {
      return static_cast<Blocks*>(user)->allocate(bytes, kind);
    };
    return memory;
  }

  std::vector<std::uint32_t> kinds;  ///< asked for, in order
  std::uint32_t refused = 99;
  std::size_t offset = 0;  ///< added to the pointers

 private:
  struct alignas(16) Unit {
    std::byte bytes[16];
  };
  void* allocate(std::uint64_t bytes, std::uint32_t kind) {
    kinds.push_back(kind);
    if (kind == refused) return nullptr;
    const std::size_t units = bytes / sizeof(Unit) + 2;
    blocks_.emplace_back(new Unit[units]);
    std::memset(blocks_.back().get(), 0xa5, units * sizeof(Unit));
    return blocks_.back()[0].bytes + offset;
  }
  std::vector<std::unique_ptr<Unit[]>> blocks_;
};

inline QsRules c_rules(const DrawnView& view) {
  const diff::Rules& rules = view.rules;
  QsRules result = QS_RULES;
  result.sh_degree = view.sh_degree;
  result.cull = mode_name(view.mode);
  if (std::isfinite(rules.far_depth)) result.far_depth = rules.far_depth;
  result.dilation_px2 = rules.dilation;
  result.splat_scale = rules.splat_scale;
  result.compensation_floor = rules.compensation_floor;
  result.alpha_max = rules.alpha_max;
  result.radius_clip_px = rules.radius_clip;
  if (rules.slopes) {
    for (int axis = 0; axis < 2; ++axis) {
      result.slope_low[axis] = rules.slopes->low[axis];
      result.slope_high[axis] = rules.slopes->high[axis];
    }
  }
  result.antialiased = rules.antialiased ? 1 : 0;
  result.keeps_rotation_length = rules.normalises_rotations ? 0 : 1;
  result.zero_color_passes = rules.zero_color_passes ? 1 : 0;
  result.alpha_max_blocks = rules.alpha_max_passes ? 0 : 1;
  result.stops_at_equal = rules.stops_at_equal ? 1 : 0;
  result.radius_rule = static_cast<std::uint32_t>(rules.radius_rule);
  return result;
}

inline QsCamera camera_of(const DrawnView& view) {
  QsCamera camera = c_camera(view.camera);
  camera.near_depth = view.rules.near_depth;
  return camera;
}

template <class Real>
QsBlended c_pictures(PictureValues<Real>& values) {
  const std::int64_t width = values.width, height = values.height;
  auto pictures = sized<QsBlended>();
  pictures.color = array_of(values.color.data(), {height, width, values.channel_count});
  pictures.color.strides[0] = width;
  pictures.color.strides[1] = 1;
  pictures.color.strides[2] = width * height;
  pictures.alpha = array_of(values.alpha.data(), {height, width});
  pictures.depth = array_of(values.depth.data(), {height, width});
  pictures.inverse_depth = array_of(values.inverse_depth.data(), {height, width});
  return pictures;
}

/// The boundary's arrays of QsBoundary and QsBoundaryGradients.
template <class Struct, class Real>
Struct c_boundary(BoundaryValues<Real>& values, bool has_sh) {
  const auto count = static_cast<std::int64_t>(values.depth.size());
  auto boundary = sized<Struct>();
  boundary.means_px = array_of(values.mean_px.data(), {count, 2});
  boundary.conics = array_of(values.conic.data(), {count, 3});
  boundary.depths = array_of(values.depth.data(), {count});
  boundary.opacities = array_of(values.opacity.data(), {count});
  if (has_sh) boundary.colors = array_of(values.color.data(), {count, 3});
  return boundary;
}

/// Sets the arrays that inputs and their gradients share.
template <class Struct, class Real>
void set_inputs(Struct& to, StageScene<Real>& scene) {
  const auto count = static_cast<std::int64_t>(scene.size());
  to.means = array_of(scene.means.data(), {count, 3});
  if (scene.has_covariances) {
    to.covariances = array_of(scene.covariances.data(), {count, 6});
  } else {
    to.scales = array_of(scene.scales.data(), {count, 3});
    to.rotations = array_of(scene.rotations.data(), {count, 4});
  }
  to.opacities = array_of(scene.opacities.data(), {count});
  if (!scene.has_channels)
    to.sh = array_of(scene.sh.data(), {count, sh_coefficient_count(scene.sh_degree), 3});
}

/// Another place for the arrays of a call.
class Placement {
 public:
  virtual ~Placement() = default;
  virtual void place(QsArray& array) = 0;
  virtual void give_back() = 0;  ///< the results, to the arrays' first places
  virtual QsMemory memory() = 0;
  virtual void* stream() { return nullptr; }
  virtual const QsMemory* temporary() { return nullptr; }

  /// All arrays of a struct, which follow each other behind its first 8 bytes.
  template <class Struct>
  void place(Struct& of) {
    auto* const arrays = reinterpret_cast<QsArray*>(&of.size + 2);
    for (std::size_t i = 0; i < (sizeof(Struct) - 8) / sizeof(QsArray); ++i) place(arrays[i]);
  }
};

/// A view of a scene with all arguments, and its results.
template <class Real>
struct Drawing {
  StageScene<Real> scene;
  std::vector<Real> background;
  std::array<double, 3> position{};
  QsInputs inputs = sized<QsInputs>();
  QsCamera camera;
  QsRules rules;
  PictureValues<Real> pictures;
  BoundaryValues<Real> boundary;
  std::vector<std::int32_t> radii;
  Blocks blocks;
  QsStageFrame frame = sized<QsStageFrame>();
  Placement* placement = nullptr;  ///< null: everything is in host memory
  bool with_depth = true;          ///< false: neither depth is drawn
  bool wants_boundary = true;      ///< false: backward() has no derivatives by the boundary

  Drawing(const DrawnView& view, const StageScene<Real>& given)
      : scene(given),
        camera(camera_of(view)),
        rules(c_rules(view)),
        pictures(view.camera, given.channel_count),
        boundary(given.size(), given.channel_count),
        radii(2 * given.size()) {
    for (int c = 0; c < scene.channel_count; ++c)
      background.push_back(static_cast<Real>(0.2 + 0.13 * c));
    const auto count = static_cast<std::int64_t>(scene.size());
    set_inputs(inputs, scene);
    if (scene.has_channels)
      inputs.channels = array_of(scene.channels.data(), {count, scene.channel_count});
    inputs.background = array_of(background.data(), {scene.channel_count});
    if (view.position) {
      position = {view.position->x, view.position->y, view.position->z};
      inputs.position = array_of(position.data(), {3});
    }
  }
  Drawing(const Drawing&) = delete;

  void forward(quadsplat::Context& context, bool in_one_call) {
    const QsMemory memory = placement != nullptr ? placement->memory() : blocks.memory();
    QsInputs in = inputs;
    auto to = c_boundary<QsBoundary>(boundary, !scene.has_channels);
    to.radii = array_of(radii.data(), {static_cast<std::int64_t>(scene.size()), 2});
    QsBlended drawn = wanted(pictures);
    place(in, to, drawn);
    if (in_one_call) {
      quadsplat::check(qs_forward, context.get(), &in, &camera, &rules, &memory, &to, &drawn,
                       &frame);
    } else {
      quadsplat::check(qs_project, context.get(), &in, &camera, &rules, &memory, &to, &frame);
      quadsplat::check(qs_blend, context.get(), &in, &camera, &rules, &memory, &drawn, &frame);
    }
    if (placement != nullptr) placement->give_back();
  }

  /// Of a loss with these weights.
  StageGradients<Real> backward(quadsplat::Context& context, PictureValues<Real>& weights,
                                bool in_one_call) {
    StageGradients<Real> result{scene, BoundaryValues<Real>(scene.size(), scene.channel_count), {}};
    const auto count = static_cast<std::int64_t>(scene.size());
    auto by_boundary = c_boundary<QsBoundaryGradients>(result.boundary, !scene.has_channels);
    if (scene.has_channels)
      by_boundary.channels = array_of(result.by.channels.data(), {count, scene.channel_count});
    by_boundary.absolute_px = array_of(result.boundary.absolute_px.data(), {count, 2});
    by_boundary.background = array_of(result.boundary.background.data(), {scene.channel_count});
    if (!wants_boundary) by_boundary = sized<QsBoundaryGradients>();
    auto by_inputs = sized<QsInputGradients>();
    set_inputs(by_inputs, result.by);
    std::array<double, 12> matrix{};
    std::array<double, 3> by_position{};
    by_inputs.view_from_world = array_of(matrix.data(), {3, 4});
    by_inputs.position = array_of(by_position.data(), {3});
    QsInputs in = inputs;
    QsBlended by = wanted(weights);
    place(in, by_boundary, by, by_inputs);
    if (in_one_call) {
      quadsplat::check(qs_backward, context.get(), &in, &camera, &rules, &frame, &by, &by_boundary,
                       &by_inputs);
    } else {
      quadsplat::check(qs_blend_backward, context.get(), &in, &camera, &rules, &frame, &by,
                       &by_boundary);
      quadsplat::check(qs_project_backward, context.get(), &in, &camera, &rules, &frame,
                       &by_boundary, &by_inputs);
    }
    if (placement != nullptr) placement->give_back();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        result.pose.view_from_world[column][row] =
            matrix[static_cast<std::size_t>(4 * row + column)];
      }
      result.pose.position[row] = by_position[static_cast<std::size_t>(row)];
    }
    return result;
  }

 private:
  QsBlended wanted(PictureValues<Real>& values) const {
    QsBlended result = c_pictures(values);
    if (!with_depth) result.depth = result.inverse_depth = {};
    return result;
  }
  template <class... Structs>
  void place(QsInputs& in, Structs&... structs) {
    if (placement == nullptr) return;
    placement->place(in);
    (placement->place(structs), ...);
    in.stream = placement->stream();
    in.temporary = placement->temporary();
  }
};

}  // namespace qs::test
