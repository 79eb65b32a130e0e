// SPDX-License-Identifier: MIT
// The passes of the differentiable rasterizer on the GPU: against the passes of the CPU.
#include <algorithm>
#include <cmath>
#include <limits>

#include "support/error_of.h"
#include "support/gpu.h"
#include "support/gpu_stage_scenes.h"

namespace qs {
namespace {

using diff::DrawnView;
using diff::Rows;
using test::BoundaryValues;
using test::GpuArray;
using test::GpuBoundary;
using test::GpuScene;
using test::GpuStageFrame;
using test::off_centre_view;
using test::PictureValues;
using test::pool;
using test::stage_scene;
using test::StageFrame;
using test::StageGradients;
using test::StageScene;
using test::with_channels;

class CudaStages : public test::GpuTest {};

/// The lists of the CPU's frame in the form that copy_lists() returns.
cuda::diff::ListCopies lists_of(const test::ProjectedFrame<float>& frame, std::size_t count) {
  const auto view = frame.view();
  cuda::diff::ListCopies lists;
  for (const std::uint64_t begin : frame.lists.begin)
    lists.begin.push_back(static_cast<std::uint32_t>(begin));
  lists.tile_counts.resize(count);
  for (std::size_t pair = 0; pair < view.pairs; ++pair) {
    lists.gaussians.push_back(view.gaussians[view.listed[pair]]);
    ++lists.tile_counts[lists.gaussians.back()];
  }
  lists.projected = frame.projected;
  return lists;
}

/// Projects on both sides, and expects equal lists, rows of the boundary and radii. Colours may
/// differ by rounding. Returns the number of pairs.
std::size_t expect_equal_projections(const DrawnView& view, const StageScene<float>& scene) {
  const std::size_t count = scene.size();
  test::ProjectedFrame<float> frame;
  BoundaryValues<float> expected(count);
  std::vector<std::int32_t> expected_radii(2 * count);
  project<float>(view, scene.inputs(), {pool()}, frame, expected.rows(),
                 Rows<std::int32_t>::packed(expected_radii.data(), 2));
  const GpuScene inputs(scene);
  const GpuBoundary boundary(count);
  const GpuArray<std::int32_t> radii(2 * count);
  GpuStageFrame on_gpu;
  on_gpu.project(view, inputs.inputs(), boundary.rows(),
                 Rows<std::int32_t>::packed(radii.data(), 2));
  const auto lists = copy_lists(on_gpu.frame, {});
  const auto expected_lists = lists_of(frame, count);
  EXPECT_EQ(lists.begin, expected_lists.begin);
  EXPECT_EQ(lists.gaussians, expected_lists.gaussians);
  EXPECT_EQ(lists.tile_counts, expected_lists.tile_counts);
  EXPECT_EQ(lists.projected, expected_lists.projected);
  EXPECT_EQ(radii.values(), expected_radii);
  const BoundaryValues<float> values = boundary.values();
  EXPECT_EQ(values.mean_px, expected.mean_px);
  EXPECT_EQ(values.conic, expected.conic);
  EXPECT_EQ(values.depth, expected.depth);
  EXPECT_EQ(values.opacity, expected.opacity);
  for (std::size_t k = 0; k < expected.color.size(); ++k)
    EXPECT_NEAR(values.color[k], expected.color[k], 1e-6f) << k;
  return expected_lists.gaussians.size();
}

TEST_F(CudaStages, list_and_project_as_the_cpu_in_every_mode) {
  const StageScene<float> scene = stage_scene<float>(500, 22);
  for (const CullMode mode : test::tiled_modes()) {
    for (const bool antialiased : {false, true}) {
      SCOPED_TRACE(testing::Message() << mode_name(mode) << (antialiased ? ", antialiased" : ""));
      DrawnView view = off_centre_view();
      view.mode = mode;
      view.rules.antialiased = antialiased;
      EXPECT_GT(expect_equal_projections(view, scene), 500u);
    }
  }
}

TEST_F(CudaStages, list_and_project_as_the_cpu_by_every_rule) {
  StageScene<float> scene = stage_scene<float>(300, 23);
  for (std::size_t k = 0; k < 40; ++k) scene.rotations[k] *= 1.5f;
  for (std::size_t i = 0; i < 40; ++i)
    scene.opacities[i] = 0.002f + 0.0001f * static_cast<float>(i);
  const auto expect_equal = [&](const char* what, const auto& change) {
    SCOPED_TRACE(what);
    DrawnView view = off_centre_view();
    change(view);
    EXPECT_GT(expect_equal_projections(view, scene), 0u);
  };
  expect_equal("planes", [](DrawnView& view) {
    view.rules.near_depth = 1.5;
    view.rules.far_depth = 3.5;
  });
  expect_equal("dilation and scale", [](DrawnView& view) {
    view.rules.dilation = 0.1;
    view.rules.splat_scale = 1.7;
  });
  expect_equal("floor of the compensation", [](DrawnView& view) {
    view.rules.antialiased = true;
    view.rules.compensation_floor = 0.3;
  });
  expect_equal("slopes", [](DrawnView& view) {
    view.rules.slopes = diff::SlopeBounds{{-0.2, -0.1}, {0.1, 0.3}};
  });
  expect_equal("lengths of rotations",
               [](DrawnView& view) { view.rules.normalises_rotations = false; });
  expect_equal("degree of colours", [](DrawnView& view) { view.sh_degree = 1; });
  for (const RadiusRule rule :
       {RadiusRule::inria, RadiusRule::gsplat_1_4, RadiusRule::gsplat_1_5}) {
    for (const double clip : {0.0, 6.0}) {
      expect_equal("radii", [&](DrawnView& view) {
        view.mode = default_mode();
        view.rules.radius_rule = rule;
        view.rules.radius_clip = clip;
      });
    }
  }
}

TEST_F(CudaStages, list_and_project_inputs_of_all_kinds_as_the_cpu) {
  StageScene<float> covariances = stage_scene<float>(300, 24);
  covariances.has_covariances = true;
  EXPECT_GT(expect_equal_projections(off_centre_view(), covariances), 300u);
  for (const int channels : {1, 3, 32}) {
    expect_equal_projections(off_centre_view(),
                             with_channels(stage_scene<float>(100, 24), channels));
  }
  EXPECT_EQ(expect_equal_projections(off_centre_view(), StageScene<float>()), 0u);
  DrawnView pixel = off_centre_view(1, 1);
  pixel.camera.center_px = {0, 0};
  EXPECT_GT(expect_equal_projections(pixel, stage_scene<float>(50, 26)), 0u);
}

// Bit patterns that no comparison orders, and the largest numbers.
TEST_F(CudaStages, do_not_project_numbers_that_are_not_finite) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(),
                  kInf = std::numeric_limits<float>::infinity(),
                  kMax = std::numeric_limits<float>::max();
  for (const int kind : {0, 1, 2}) {
    StageScene<float> scene = stage_scene<float>(40, 25);
    if (kind == 2) scene = with_channels(scene, 4);
    scene.has_covariances = kind == 1;
    std::size_t next = 0;
    scene.for_each_array([&](const char*, int numbers, std::vector<float>& values) {
      for (const float bad : {kNan, kInf, -kInf, kMax, -kMax}) {
        values[next * static_cast<std::size_t>(numbers)] = bad;
        next = (next + 1) % 40;
      }
    });
    EXPECT_GT(expect_equal_projections(off_centre_view(), scene), 0u);
  }
}

TEST_F(CudaStages, read_and_write_arrays_with_strides_in_place) {
  const DrawnView view = off_centre_view();
  const StageScene<float> scene = stage_scene<float>(60, 27);
  const std::size_t count = scene.size();
  const GpuScene packed(scene);
  const GpuBoundary boundary(count);
  GpuStageFrame frame, other;
  frame.project(view, packed.inputs(), boundary.rows());
  // A row of the records: mean, scale, rotation, opacity; the coefficients of colour by channel.
  std::vector<float> records(11 * count), planes(48 * count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) records[11 * i + k] = scene.means[3 * i + k];
    for (std::size_t k = 0; k < 3; ++k) records[11 * i + 3 + k] = scene.scales[3 * i + k];
    for (std::size_t k = 0; k < 4; ++k) records[11 * i + 6 + k] = scene.rotations[4 * i + k];
    records[11 * i + 10] = scene.opacities[i];
    for (std::size_t k = 0; k < 16; ++k) {
      for (std::size_t c = 0; c < 3; ++c)
        planes[(16 * c + k) * count + i] = scene.sh[48 * i + 3 * k + c];
    }
  }
  const GpuArray<float> device_records(records), device_planes(planes);
  const auto stride = static_cast<std::ptrdiff_t>(count);
  diff::GaussianInputs<float> in = packed.inputs();
  float* const at = device_records.data();
  in.means = {at, 11, 1};
  in.scales = {at + 3, 11, 1};
  in.rotations = {at + 6, 11, 1};
  in.opacities = {at + 10, 11, 1};
  in.sh = {{device_planes.data(), 1, 16 * stride},
           {device_planes.data() + count, 1, 16 * stride},
           stride};
  const GpuArray<float> means(2 * count);
  const GpuArray<std::int32_t> radii(count);
  diff::Boundary<float> out;
  out.mean_px = {means.data(), 1, stride};
  other.project(view, in, out, {radii.data(), 1, 0});
  EXPECT_EQ(copy_lists(other.frame, {}).gaussians, copy_lists(frame.frame, {}).gaussians);
  const auto columns = means.values(), rows = boundary.values().mean_px;
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(columns[i], rows[2 * i]);
    EXPECT_EQ(columns[count + i], rows[2 * i + 1]);
  }
}

// ---- both passes

/// Expects that values agree up to `tolerance` times the largest expected one.
void expect_close(const char* what, const std::vector<float>& values,
                  const std::vector<float>& expected, double tolerance) {
  ASSERT_EQ(values.size(), expected.size()) << what;
  double scale = 0;
  for (const float value : expected) scale = std::max(scale, std::abs(static_cast<double>(value)));
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_NEAR(values[i], expected[i], tolerance * scale + 1e-7) << what << " " << i;
}

void expect_close(const StageGradients<float>& gradients, const StageGradients<float>& expected,
                  double tolerance) {
  const auto &by = gradients.by, &expected_by = expected.by;
  expect_close("means", by.means, expected_by.means, tolerance);
  if (by.has_covariances) {
    expect_close("covariances", by.covariances, expected_by.covariances, tolerance);
  } else {
    expect_close("scales", by.scales, expected_by.scales, tolerance);
    expect_close("rotations", by.rotations, expected_by.rotations, tolerance);
  }
  expect_close("opacities", by.opacities, expected_by.opacities, tolerance);
  expect_close(by.has_channels ? "channels" : "coefficients", by.has_channels ? by.channels : by.sh,
               by.has_channels ? expected_by.channels : expected_by.sh, tolerance);
  const auto &boundary = gradients.boundary, &expected_boundary = expected.boundary;
  expect_close("means on the image", boundary.mean_px, expected_boundary.mean_px, tolerance);
  expect_close("conics", boundary.conic, expected_boundary.conic, tolerance);
  expect_close("depths", boundary.depth, expected_boundary.depth, tolerance);
  expect_close("blended opacities", boundary.opacity, expected_boundary.opacity, tolerance);
  expect_close("colours", boundary.color, expected_boundary.color, tolerance);
  expect_close("absolute", boundary.absolute_px, expected_boundary.absolute_px, tolerance);
  expect_close("background", boundary.background, expected_boundary.background, tolerance);
  const auto numbers = [](const diff::PoseGradient& pose) {
    std::vector<float> all;
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 3; ++row)
        all.push_back(static_cast<float>(pose.view_from_world[column][row]));
    }
    return all;
  };
  expect_close("pose", numbers(gradients.pose), numbers(expected.pose), tolerance);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(gradients.pose.position[k], expected.pose.position[k],
                tolerance * (1 + std::abs(expected.pose.position[k])));
  }
}

constexpr double kPictureTolerance = 5e-5, kGradientTolerance = 3e-4;

/// Draws on both sides, and expects pictures and gradients that agree within rounding.
void expect_equal_stages(const DrawnView& view, const StageScene<float>& scene) {
  const auto weights = PictureValues<float>::random(view.camera, scene.channel_count);
  StageFrame<float> frame;
  const PictureValues<float> expected = frame.draw(view, scene, pool());
  GpuStageFrame on_gpu;
  const PictureValues<float> pictures = on_gpu.draw(view, scene);
  expect_close("colour", pictures.color, expected.color, kPictureTolerance);
  expect_close("alpha", pictures.alpha, expected.alpha, kPictureTolerance);
  expect_close("depth", pictures.depth, expected.depth, kPictureTolerance);
  expect_close("inverse depth", pictures.inverse_depth, expected.inverse_depth, kPictureTolerance);
  auto cpu_weights = weights;
  expect_close(on_gpu.gradients(view, scene, weights),
               frame.gradients(view, scene, cpu_weights.pictures()), kGradientTolerance);
  // Without depths in the frame; three channels have kernels of their own.
  GpuStageFrame flat;
  flat.with_depth = false;
  const PictureValues<float> flat_pictures = flat.draw(view, scene);
  EXPECT_EQ(flat_pictures.color, pictures.color);
  EXPECT_EQ(flat_pictures.alpha, pictures.alpha);
  const auto all = cpu_weights.pictures();
  expect_close(flat.gradients(view, scene, weights),
               frame.gradients(view, scene, {all.color, all.alpha, {}, {}}), kGradientTolerance);
  expect_close(flat.gradients(view, scene, weights, false),
               frame.gradients(view, scene, {all.color, {}, {}, {}}), kGradientTolerance);
}

TEST_F(CudaStages, draw_and_go_back_as_the_cpu) {
  for (const bool antialiased : {false, true}) {
    DrawnView view = off_centre_view();
    view.rules.antialiased = antialiased;
    expect_equal_stages(view, stage_scene<float>(200, 31));
    StageScene<float> covariances = stage_scene<float>(200, 32);
    covariances.has_covariances = true;
    view.mode = default_mode();
    expect_equal_stages(view, covariances);
  }
}

TEST_F(CudaStages, draw_and_go_back_with_any_number_of_channels_as_the_cpu) {
  for (const int channels : {1, 2, 3, 5, 9, 32}) {
    SCOPED_TRACE(channels);
    expect_equal_stages(off_centre_view(), with_channels(stage_scene<float>(100, 33), channels));
  }
}

TEST_F(CudaStages, draw_and_go_back_by_every_rule_as_the_cpu) {
  StageScene<float> scene = stage_scene<float>(150, 34);
  for (std::size_t i = 0; i < 150; i += 2) scene.opacities[i] = 0.999f;  // saturates pixels
  for (std::size_t i = 0; i < 30; ++i) scene.sh[48 * i] = -3;            // clamped colours
  const auto expect_equal = [&](const char* what, const auto& change) {
    SCOPED_TRACE(what);
    DrawnView view = off_centre_view();
    change(view.rules);
    expect_equal_stages(view, scene);
  };
  expect_equal("defaults", [](diff::Rules&) {});
  expect_equal("alpha", [](diff::Rules& rules) {
    rules.alpha_max = 0.9;
    rules.alpha_max_passes = false;
    rules.stops_at_equal = true;
  });
  expect_equal("slopes", [](diff::Rules& rules) {
    rules.slopes = diff::SlopeBounds{{-0.2, -0.1}, {0.1, 0.3}};
  });
  expect_equal("lengths and scale", [](diff::Rules& rules) {
    rules.normalises_rotations = false;
    rules.splat_scale = 1.3;
    rules.zero_color_passes = true;
  });
}

TEST_F(CudaStages, of_no_gaussians_and_of_one_pixel_draw_and_go_back_as_the_cpu) {
  expect_equal_stages(off_centre_view(), StageScene<float>());
  DrawnView pixel = off_centre_view(1, 1);
  pixel.camera.center_px = {0, 0};
  expect_equal_stages(pixel, stage_scene<float>(50, 26));
}

TEST_F(CudaStages, give_no_gradient_to_numbers_that_are_not_finite) {
  StageScene<float> scene = stage_scene<float>(30, 25);
  const DrawnView view = off_centre_view();
  scene.means[3 * 7] = std::numeric_limits<float>::quiet_NaN();
  scene.opacities[9] = std::numeric_limits<float>::infinity();
  GpuStageFrame frame;
  frame.draw(view, scene);
  const auto gradients = frame.gradients(view, scene, PictureValues<float>::random(view.camera, 3));
  for (const float value : gradients.by.means) EXPECT_TRUE(std::isfinite(value));
  for (const std::size_t bad : {7u, 9u}) {
    EXPECT_EQ(gradients.by.opacities[bad], 0);
    EXPECT_EQ(gradients.by.means[3 * bad], 0);
  }
}

/// All bits that a frame gives. Covariances that are not given keep their inputs.
std::vector<double> bits_of(const DrawnView& view, const StageScene<float>& scene,
                            bool with_depth) {
  GpuStageFrame frame;
  frame.with_depth = with_depth;
  const PictureValues<float> pictures = frame.draw(view, scene);
  auto bits =
      frame.gradients(view, scene, PictureValues<float>::random(view.camera, scene.channel_count))
          .numbers();
  for (const auto* picture :
       {&pictures.color, &pictures.alpha, &pictures.depth, &pictures.inverse_depth})
    bits.insert(bits.end(), picture->begin(), picture->end());
  return bits;
}

TEST_F(CudaStages, have_the_same_bits_twice_and_in_all_lossless_modes) {
  DrawnView view = off_centre_view();
  const auto expect_equal = [&](const StageScene<float>& scene, bool with_depth) {
    view.mode = find_culler("adr");
    const auto expected = bits_of(view, scene, with_depth);
    EXPECT_EQ(bits_of(view, scene, with_depth), expected) << "a second time";
    for (const CullMode mode : test::tiled_modes()) {
      if (!row_of(mode).lossless) continue;
      view.mode = mode;
      EXPECT_EQ(bits_of(view, scene, with_depth), expected) << mode_name(mode);
    }
  };
  expect_equal(stage_scene<float>(400, 35), true);
  expect_equal(stage_scene<float>(400, 35), false);
  expect_equal(with_channels(stage_scene<float>(300, 36), 5), true);
}

TEST_F(CudaStages, of_several_frames_wait_for_their_backward_passes) {
  const StageScene<float> scene = stage_scene<float>(200, 37);
  const DrawnView first = off_centre_view(), second = off_centre_view(71, 20);
  const auto weights = PictureValues<float>::random(first.camera, 3);
  const auto other_weights = PictureValues<float>::random(second.camera, 3);
  const auto alone = [&](const DrawnView& view, const PictureValues<float>& by) {
    GpuStageFrame frame;
    frame.draw(view, scene);
    return frame.gradients(view, scene, by).numbers();
  };
  GpuStageFrame frame, other;
  frame.draw(first, scene);
  other.draw(second, scene);
  const auto expected = alone(first, weights);
  EXPECT_EQ(other.gradients(second, scene, other_weights).numbers(), alone(second, other_weights));
  EXPECT_EQ(frame.gradients(first, scene, weights).numbers(), expected);
  EXPECT_EQ(frame.gradients(first, scene, weights).numbers(), expected) << "a second time";
}

TEST_F(CudaStages, refuse_inputs_that_do_not_fit_together) {
  const StageScene<float> scene = stage_scene<float>(3, 38);
  const GpuScene inputs(scene);
  const DrawnView view = off_centre_view();
  GpuStageFrame frame;
  frame.draw(view, scene);
  diff::BlendInput<float> in = frame.input(view, inputs.inputs());
  in.size.width = 3;
  EXPECT_EQ(test::error_of([&] { blend(in, {}, false, frame.frame); }),
            "blend: the frame has 45 x 35 pixels and 3 channels, not 3 x 35 and 3");
  EXPECT_EQ(test::error_of([&] { blend_backward(in, frame.frame, {}, {}, nullptr, {}); }),
            "blend_backward: the frame has 45 x 35 pixels and 3 channels, not 3 x 35 and 3");
  auto fewer = inputs.inputs();
  fewer.count = 2;
  EXPECT_EQ(
      test::error_of([&] { project_backward(view, fewer, frame.frame, {}, {}, nullptr, {}); }),
      "project_backward: the frame has 3 Gaussians, the inputs have 2");
}

}  // namespace
}  // namespace qs
