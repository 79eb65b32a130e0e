// SPDX-License-Identifier: MIT
// The differentiable rasterizer through the C interface: the bits of learn/diff/cpu, frames in
// the caller's memory that wait for their backward passes, arrays of any strides, and refusals.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>
#include <memory>
#include <numeric>
#include <thread>

#include "library/stage_drawing.h"
#include "support/differences.h"

namespace qs {
namespace {

using diff::DrawnView;
using quadsplat::array_of;
using quadsplat::sized;
using test::Blocks;
using test::BoundaryValues;
using test::c_boundary;
using test::c_pictures;
using test::c_rules;
using test::camera_of;
using test::Drawing;
using test::PictureValues;
using test::sentence_of;
using test::set_inputs;
using test::stage_scene;
using test::StageFrame;
using test::StageGradients;
using test::StageScene;

static_assert(sizeof(QsInputs) == 904 && offsetof(QsInputs, temporary) == 896);
static_assert(sizeof(QsRules) == 120 && offsetof(QsRules, radius_rule) == 116);
static_assert(sizeof(QsMemory) == 24 && offsetof(QsMemory, allocate) == 16);
static_assert(sizeof(QsStageFrame) == 80 && offsetof(QsStageFrame, device) == 76);
static_assert(sizeof(QsBoundary) == 536 && offsetof(QsBoundary, radii) == 448);
static_assert(sizeof(QsBlended) == 360 && offsetof(QsBlended, inverse_depth) == 272);
static_assert(sizeof(QsBoundaryGradients) == 712 &&
              offsetof(QsBoundaryGradients, background) == 624);
static_assert(sizeof(QsInputGradients) == 800 && offsetof(QsInputGradients, position) == 712);

// ---- equality

template <class Real>
void expect_bits_of_the_stages(const DrawnView& view, const StageScene<Real>& scene) {
  StageFrame<Real> frame;
  const PictureValues<Real> pictures = frame.draw(view, scene);
  BoundaryValues<Real> boundary(scene.size(), scene.channel_count);
  std::vector<std::int32_t> radii(2 * scene.size());
  test::ProjectedFrame<Real> again;
  cpu::diff::project<Real>(view, scene.inputs(), {test::pool(1)}, again, boundary.rows(),
                           diff::Rows<std::int32_t>::packed(radii.data(), 2));
  auto weights = PictureValues<Real>::random(view.camera, scene.channel_count);
  const std::vector<double> gradients = frame.gradients(view, scene, weights.pictures()).numbers();
  for (const bool in_one_call : {true, false}) {
    for (const int threads : {1, 3}) {
      quadsplat::Context context = test::cpu(threads);
      Drawing<Real> drawing(view, scene);
      drawing.forward(context, in_one_call);
      EXPECT_TRUE(drawing.pictures == pictures);
      EXPECT_TRUE(drawing.boundary == boundary);
      EXPECT_EQ(drawing.radii, radii);
      EXPECT_EQ(drawing.frame.pairs, frame.frame.lists.pairs());
      EXPECT_GT(drawing.frame.pairs, 0u);
      EXPECT_EQ(drawing.frame.listed, frame.frame.visible.count);
      EXPECT_EQ(drawing.backward(context, weights, true).numbers(), gradients);
      EXPECT_EQ(drawing.backward(context, weights, false).numbers(), gradients) << "a second time";
    }
  }
}

TEST(LibraryStages, have_the_bits_of_the_stages_for_inputs_of_all_kinds) {
  const DrawnView view = test::off_centre_view();
  StageScene<float> scene = stage_scene<float>(5000, 31);  // more than a chunk of Gaussians
  expect_bits_of_the_stages(view, scene);
  expect_bits_of_the_stages(view, stage_scene<double>(200, 32));
  scene.has_covariances = true;
  expect_bits_of_the_stages(view, scene);
  for (const int channels : {1, 3, 5, 32})
    expect_bits_of_the_stages(view, test::with_channels(stage_scene<float>(300, 33), channels));
}

TEST(LibraryStages, draw_for_callers_whose_structs_have_no_members_for_a_gpu) {
  const DrawnView view = test::off_centre_view();
  const StageScene<float> scene = stage_scene<float>(50, 39);
  Drawing<float> usual(view, scene), older(view, scene);
  older.inputs.size = offsetof(QsInputs, stream);
  older.frame.size = offsetof(QsStageFrame, memory);
  older.frame.memory = 7;  // behind the end of the caller's struct
  quadsplat::Context context = test::cpu();
  usual.forward(context, true);
  older.forward(context, true);
  EXPECT_TRUE(older.pictures == usual.pictures);
  EXPECT_EQ(older.frame.memory, 7u);
  auto weights = PictureValues<float>::random(view.camera, 3);
  EXPECT_EQ(older.backward(context, weights, true).numbers(),
            usual.backward(context, weights, true).numbers());
}

TEST(LibraryStages, take_all_rules) {
  const StageScene<float> scene = stage_scene<float>(300, 34);
  const std::function<void(DrawnView&)> changes[] = {
      [](DrawnView& v) { v.position.reset(); },
      [](DrawnView& v) { v.sh_degree = 1; },
      [](DrawnView& v) { v.mode = find_culler("adr"); },
      [](DrawnView& v) { v.rules.near_depth = 2.4; },
      [](DrawnView& v) { v.rules.far_depth = 4; },
      [](DrawnView& v) { v.rules.dilation = 0.1; },
      [](DrawnView& v) { v.rules.splat_scale = 1.5; },
      [](DrawnView& v) { v.rules.antialiased = true; },
      [](DrawnView& v) {
        v.rules.antialiased = true;
        v.rules.dilation = 40;
        v.rules.compensation_floor = 0.1;
      },
      [](DrawnView& v) {
        v.rules.slopes = diff::SlopeBounds{{-0.15, -0.2}, {0.1, 0.05}};
      },
      [](DrawnView& v) { v.rules.normalises_rotations = false; },
      [](DrawnView& v) { v.rules.alpha_max = 0.4; },
      [](DrawnView& v) { v.rules.radius_clip = 4; },
      [](DrawnView& v) { v.rules.radius_rule = RadiusRule::gsplat_1_4; },
      [](DrawnView& v) { v.rules.radius_rule = RadiusRule::gsplat_1_5; },
  };
  quadsplat::Context context = test::cpu();
  const auto result_of = [&](const DrawnView& view) {
    Drawing<float> drawing(view, scene);
    drawing.forward(context, true);
    auto weights = PictureValues<float>::random(view.camera, 3);
    std::vector<double> numbers = drawing.backward(context, weights, true).numbers();
    numbers.insert(numbers.end(), drawing.radii.begin(), drawing.radii.end());
    return numbers;
  };
  const std::vector<double> usual = result_of(test::off_centre_view());
  for (std::size_t i = 0; i < std::size(changes); ++i) {
    SCOPED_TRACE(i);
    DrawnView view = test::off_centre_view();
    changes[i](view);
    EXPECT_NE(result_of(view), usual) << "the rule has an effect";
    expect_bits_of_the_stages(view, scene);
  }
  DrawnView view = test::off_centre_view();
  view.rules.alpha_max = 0.4;
  const std::vector<double> clamped = result_of(view);
  view.rules.alpha_max_passes = false;
  EXPECT_NE(result_of(view), clamped);
  expect_bits_of_the_stages(view, scene);
}

/// Gaussians on the line of sight of the pixel in the middle of 17 x 17, front to back.
constexpr std::size_t kMiddle = 8 * 17 + 8;

DrawnView straight_view() {
  DrawnView view;
  view.camera.focal_px = {30, 30};
  view.camera.center_px = {8, 8};
  view.camera.width = view.camera.height = 17;
  return view;
}

template <class Real>
StageScene<Real> in_a_line(const std::vector<Real>& opacities, Real coefficient) {
  StageScene<Real> scene;
  scene.sh_degree = 0;
  for (const Real opacity : opacities) {
    scene.means.insert(scene.means.end(), {0, 0, static_cast<Real>(3 + scene.size())});
    scene.scales.insert(scene.scales.end(), 3, Real(0.5));
    scene.rotations.insert(scene.rotations.end(), {1, 0, 0, 0});
    scene.opacities.push_back(opacity);
    scene.sh.insert(scene.sh.end(), 3, coefficient);
  }
  return scene;
}

TEST(LibraryStages, pass_the_gradient_of_black_if_asked_to) {
  quadsplat::Context context = test::cpu(1);
  DrawnView view = straight_view();
  PictureValues<double> weights(view.camera, 3);
  weights.color[kMiddle] = 1;
  for (const bool passes : {false, true}) {
    view.rules.zero_color_passes = passes;
    Drawing<double> drawing(view, in_a_line<double>({0.5}, -0.5 / kSh0));
    drawing.forward(context, true);
    ASSERT_EQ(drawing.boundary.color[0], 0);
    EXPECT_EQ(drawing.backward(context, weights, true).by.sh[0] != 0, passes);
  }
}

TEST(LibraryStages, stop_at_the_least_transmittance_if_asked_to) {
  // Two opacities that leave exactly 1e-4.
  const auto second = [](float first) { return 1 - kTransmittanceMin / (1 - first); };
  float front = 0.98f;
  while ((1 - front) * (1 - second(front)) != kTransmittanceMin && front > 0.9f)
    front = std::nextafter(front, 0.0f);
  const float behind = second(front);
  ASSERT_EQ((1 - front) * (1 - behind), kTransmittanceMin);
  quadsplat::Context context = test::cpu(1);
  DrawnView view = straight_view();
  for (const bool stops : {false, true}) {
    view.rules.alpha_max = 0.999;
    view.rules.stops_at_equal = stops;
    Drawing<float> drawing(view, in_a_line<float>({front, behind}, 1));
    drawing.forward(context, true);
    EXPECT_EQ(drawing.pictures.alpha[kMiddle], stops ? front : 1 - kTransmittanceMin);
  }
}

TEST(LibraryStages, have_usual_rules_if_there_are_none) {
  const StageScene<float> scene = stage_scene<float>(200, 36);
  DrawnView view;
  view.camera = test::off_centre_view().camera;
  StageFrame<float> frame;
  frame.background = {0, 0, 0};
  const PictureValues<float> expected = frame.draw(view, scene);
  quadsplat::Context context = test::cpu();
  Drawing<float> drawing(view, scene);
  drawing.inputs.background = {};
  const QsMemory memory = drawing.blocks.memory();
  const QsBlended pictures = c_pictures(drawing.pictures);
  const QsRules usual = quadsplat::default_rules();
  for (const QsRules* rules : {static_cast<const QsRules*>(nullptr), &usual}) {
    quadsplat::check(qs_forward, context.get(), &drawing.inputs, &drawing.camera, rules, &memory,
                     nullptr, &pictures, &drawing.frame);
    EXPECT_TRUE(drawing.pictures == expected);
  }
}

// ---- frames

TEST(LibraryStages, of_several_frames_wait_for_backward_passes_in_any_order_and_thread) {
  const StageScene<float> scene = stage_scene<float>(500, 37);
  const DrawnView views[] = {test::off_centre_view(), test::off_centre_view(71, 20),
                             test::off_centre_view(33, 90)};
  std::vector<std::unique_ptr<Drawing<float>>> drawings;
  std::vector<std::vector<double>> expected;
  quadsplat::Context context = test::cpu();
  for (const DrawnView& view : views) {
    drawings.push_back(std::make_unique<Drawing<float>>(view, scene));
    drawings.back()->forward(context, true);
    StageFrame<float> frame;
    frame.draw(view, scene);
    auto weights = PictureValues<float>::random(view.camera, 3);
    expected.push_back(frame.gradients(view, scene, weights.pictures()).numbers());
  }
  const auto expect_gradients = [&](std::size_t i, quadsplat::Context& with) {
    auto weights = PictureValues<float>::random(views[i].camera, 3);
    EXPECT_EQ(drawings[i]->backward(with, weights, true).numbers(), expected[i]) << i;
  };
  expect_gradients(2, context);
  expect_gradients(0, context);
  std::thread([&] { expect_gradients(1, context); }).join();
  quadsplat::Context other = test::cpu(3);
  std::thread here([&] { expect_gradients(0, other); });  // both read the same frame
  expect_gradients(0, context);
  here.join();
}

TEST(LibraryStages, of_four_threads_have_the_same_bits) {
  const StageScene<float> scene = stage_scene<float>(500, 42);
  const DrawnView view = test::off_centre_view(71, 50);
  StageFrame<float> frame;
  frame.draw(view, scene);
  auto random = PictureValues<float>::random(view.camera, 3);
  const std::vector<double> expected = frame.gradients(view, scene, random.pictures()).numbers();
  std::atomic<int> equal = 0;
  std::vector<std::thread> threads;
  for (int thread = 0; thread < 4; ++thread) {
    threads.emplace_back([&, thread] {
      quadsplat::Context context = test::cpu(1 + thread % 3);
      auto weights = PictureValues<float>::random(view.camera, 3);
      for (int i = 0; i < 5; ++i) {
        Drawing<float> drawing(view, scene);
        drawing.forward(context, i % 2 == 0);
        equal += drawing.backward(context, weights, i % 2 == 1).numbers() == expected ? 1 : 0;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(equal, 20);
}

TEST(LibraryStages, take_frames_whose_memory_was_moved) {
  const DrawnView view = test::off_centre_view();
  const StageScene<float> scene = stage_scene<float>(300, 38);
  quadsplat::Context context = test::cpu();
  Drawing<float> drawing(view, scene);
  std::vector<std::pair<void*, std::uint64_t>> blocks;
  auto memory = sized<QsMemory>();
  memory.user = &blocks;
  memory.allocate = [](void* user, std::uint64_t bytes, std::uint32_t) {
    void* const block = std::aligned_alloc(16, bytes);
    static_cast<std::vector<std::pair<void*, std::uint64_t>>*>(user)->emplace_back(block, bytes);
    return block;
  };
  const QsBlended pictures = c_pictures(drawing.pictures);
  quadsplat::check(qs_forward, context.get(), &drawing.inputs, &drawing.camera, &drawing.rules,
                   &memory, nullptr, &pictures, &drawing.frame);
  auto weights = PictureValues<float>::random(view.camera, 3);
  const std::vector<double> expected = drawing.backward(context, weights, true).numbers();
  ASSERT_EQ(blocks.size(), 3u);
  void** pointers[] = {&drawing.frame.per_gaussian, &drawing.frame.per_pair,
                       &drawing.frame.per_pixel};
  std::vector<std::vector<std::max_align_t>> moved;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [block, bytes] = blocks[i];
    EXPECT_EQ(*pointers[i], block);
    moved.emplace_back(bytes / sizeof(std::max_align_t) + 1);
    std::memcpy(moved.back().data(), block, bytes);
    std::memset(block, 0, bytes);
    std::free(block);
    *pointers[i] = moved.back().data();
  }
  EXPECT_EQ(drawing.backward(context, weights, true).numbers(), expected);
}

TEST(LibraryStages, blend_a_projected_frame_again) {
  const DrawnView view = test::off_centre_view();
  quadsplat::Context context = test::cpu();
  Drawing<float> drawing(view, test::with_channels(stage_scene<float>(200, 39), 4));
  drawing.forward(context, false);
  auto weights = PictureValues<float>::random(view.camera, 4);
  const PictureValues<float> first = drawing.pictures;
  const std::vector<double> expected = drawing.backward(context, weights, true).numbers();
  const QsStageFrame kept = drawing.frame;
  drawing.background = {1, 1, 1, 1};
  const QsMemory memory = drawing.blocks.memory();
  const QsBlended pictures = c_pictures(drawing.pictures);
  quadsplat::check(qs_blend, context.get(), &drawing.inputs, &drawing.camera, &drawing.rules,
                   &memory, &pictures, &drawing.frame);
  EXPECT_FALSE(drawing.pictures == first);
  EXPECT_EQ(drawing.frame.per_gaussian, kept.per_gaussian);
  drawing.frame = kept;
  drawing.background = {0.2f, 0.33f, 0.46f, 0.59f};
  EXPECT_EQ(drawing.backward(context, weights, true).numbers(), expected);
}

// ---- counts of pixels

/// The same by the formulas of the boundary, one pixel at a time.
std::vector<std::int32_t> counted(const Drawing<double>& drawing, double behind) {
  const BoundaryValues<double>& at = drawing.boundary;
  const std::size_t count = at.depth.size();
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return static_cast<float>(at.depth[a]) < static_cast<float>(at.depth[b]);
  });
  std::vector<std::int32_t> result(count);
  for (int y = 0; y < drawing.camera.height; ++y) {
    for (int x = 0; x < drawing.camera.width; ++x) {
      double transmittance = 1;
      for (const std::size_t i : order) {
        const double dx = x - at.mean_px[2 * i], dy = y - at.mean_px[2 * i + 1];
        const double* const conic = &at.conic[3 * i];
        const double power = -(conic[0] * dx * dx + conic[2] * dy * dy) / 2 - conic[1] * dx * dy;
        const double alpha = std::min(0.99, at.opacity[i] * std::exp(power));
        if (power > 0 || alpha < 1.0 / 255) continue;
        transmittance *= 1 - alpha;
        if (transmittance < 1e-4) break;
        if (transmittance > behind) ++result[i];
      }
    }
  }
  return result;
}

TEST(LibraryStages, count_the_pixels_of_gaussians) {
  DrawnView view = test::off_centre_view();
  view.mode = find_culler("exact");
  for (const int threads : {1, 3}) {
    quadsplat::Context context = test::cpu(threads);
    Drawing<double> drawing(view, stage_scene<double>(60, 41));
    drawing.forward(context, false);
    std::vector<std::int32_t> found(120, -7);
    QsArray counts = array_of(found.data(), {60});
    counts.strides[0] = 2;
    for (const double behind : {0.0, 0.5, 0.9}) {
      quadsplat::check(qs_count_pixels, context.get(), &drawing.inputs, &drawing.camera,
                       &drawing.rules, &drawing.frame, behind, &counts);
      const std::vector<std::int32_t> expected = counted(drawing, behind);
      EXPECT_GT(*std::max_element(expected.begin(), expected.end()), 10);
      for (std::size_t i = 0; i < 60; ++i) {
        EXPECT_EQ(found[2 * i], expected[i]) << i << ' ' << behind;
        EXPECT_EQ(found[2 * i + 1], -7);
      }
    }
  }
}

TEST(LibraryStages, count_the_pixels_of_no_gaussians) {
  quadsplat::Context context = test::cpu();
  Drawing<float> drawing(test::off_centre_view(), stage_scene<float>(0, 41));
  drawing.forward(context, true);
  const QsArray counts = array_of(static_cast<std::int32_t*>(nullptr), {0});
  quadsplat::check(qs_count_pixels, context.get(), &drawing.inputs, &drawing.camera, &drawing.rules,
                   &drawing.frame, 0.5, &counts);
}

TEST(LibraryStages, ask_for_memory_by_its_lifetime) {
  const DrawnView view = test::off_centre_view();
  const StageScene<float> scene = stage_scene<float>(50, 40);
  quadsplat::Context context = test::cpu();
  const char* const names[] = {"qs_forward", "qs_project", "qs_blend"};
  Drawing<float> usual(view, scene);
  usual.forward(context, false);
  EXPECT_EQ(usual.blocks.kinds, (std::vector<std::uint32_t>{QS_HELD_PER_GAUSSIAN, QS_HELD_PER_PAIR,
                                                            QS_HELD_PER_PIXEL}));
  for (const std::uint32_t kind : {QS_HELD_PER_GAUSSIAN, QS_HELD_PER_PAIR, QS_HELD_PER_PIXEL}) {
    for (const bool in_one_call : {true, false}) {
      Drawing<float> drawing(view, scene);
      drawing.blocks.refused = kind;
      const char* const call = names[in_one_call ? 0 : kind == QS_HELD_PER_PIXEL ? 2 : 1];
      const std::string sentence =
          sentence_of([&] { drawing.forward(context, in_one_call); }, QS_DEVICE);
      EXPECT_EQ(sentence.find(std::string(call) + ": memory.allocate: returned null for "), 0u)
          << sentence;
      EXPECT_EQ(drawing.frame.per_pixel, nullptr);
      if (std::string(call) != "qs_blend") {
        EXPECT_EQ(drawing.frame.per_gaussian, nullptr);
      }
      // The context works, and so does the rest of the frame.
      drawing.blocks.refused = 99;
      drawing.forward(context, in_one_call);
      EXPECT_TRUE(drawing.pictures == usual.pictures);
    }
  }
  Drawing<float> drawing(view, scene);
  drawing.blocks.offset = 8;
  EXPECT_EQ(sentence_of([&] { drawing.forward(context, true); }),
            "qs_forward: memory.allocate: returned memory that is not aligned to 16 bytes");
}

TEST(LibraryStages, of_no_gaussians_draw_the_background) {
  const DrawnView view = test::off_centre_view(20, 9);
  quadsplat::Context context = test::cpu();
  for (const int channels : {0, 3, 7}) {  // 0: spherical harmonics
    StageScene<float> scene = stage_scene<float>(0, 41);
    if (channels > 0) scene = test::with_channels(scene, channels);
    Drawing<float> drawing(view, scene);
    EXPECT_EQ(drawing.inputs.means.data, nullptr);
    for (const bool in_one_call : {true, false}) {
      drawing.forward(context, in_one_call);
      EXPECT_EQ(drawing.frame.pairs, 0u);
      for (std::size_t i = 0; i < drawing.pictures.color.size(); ++i)
        ASSERT_EQ(drawing.pictures.color[i], drawing.background[i / 180]);
      auto weights = PictureValues<float>::random(view.camera, scene.channel_count);
      const auto gradients = drawing.backward(context, weights, in_one_call);
      double sum = 0;
      for (std::size_t i = 0; i < 180; ++i) sum += static_cast<double>(weights.color[i]);
      EXPECT_NEAR(static_cast<double>(gradients.boundary.background[0]), sum, 1e-4);
      EXPECT_EQ(gradients.pose.position, glm::dvec3(0));
    }
  }
}

// ---- strides

/// Values of an array, spread over memory with other strides; the elements between are 7.
class Spread {
 public:
  /// `order`: dimensions from the innermost to the outermost.
  Spread(const QsArray& array, std::initializer_list<std::uint32_t> order) : array_(array) {
    std::int64_t stride = 2;
    for (const std::uint32_t dimension : order) {
      array_.strides[dimension] = stride;
      stride *= array.sizes[dimension] + 1;
    }
    values_.assign(static_cast<std::size_t>(stride), 7.0f);
    array_.data = values_.data();
    copy(array, array_);
  }
  const QsArray& array() const { return array_; }
  /// Copies the elements back, and expects that the others are still 7.
  void gather(const QsArray& to) {
    copy(array_, to);
    const std::vector<float> sevens(
        static_cast<std::size_t>(to.sizes[0] * to.sizes[1] * to.sizes[2] + 1), 7.0f);
    QsArray fill = to;
    fill.data = const_cast<float*>(sevens.data());
    std::fill(std::begin(fill.strides), std::end(fill.strides), 0);
    copy(fill, array_);
    EXPECT_EQ(values_, std::vector<float>(values_.size(), 7.0f));
  }

 private:
  static void copy(const QsArray& from, const QsArray& to) {
    const auto size = [&](std::uint32_t d) { return d < to.dimensions ? to.sizes[d] : 1; };
    const auto at = [](const QsArray& array, std::int64_t i, std::int64_t j, std::int64_t k) {
      return static_cast<float*>(array.data) + i * array.strides[0] + j * array.strides[1] +
             k * array.strides[2];
    };
    for (std::int64_t i = 0; i < size(0); ++i)
      for (std::int64_t j = 0; j < size(1); ++j)
        for (std::int64_t k = 0; k < size(2); ++k) *at(to, i, j, k) = *at(from, i, j, k);
  }
  QsArray array_;
  std::vector<float> values_;
};

TEST(LibraryStages, read_and_write_arrays_of_any_strides) {
  const DrawnView view = test::off_centre_view();
  quadsplat::Context context = test::cpu();
  Drawing<float> usual(view, stage_scene<float>(300, 42)), drawing(view, usual.scene);
  usual.forward(context, true);
  auto weights = PictureValues<float>::random(view.camera, 3);
  const auto expected = usual.backward(context, weights, true);

  // Inputs: planes of numbers, and coefficients with their DC apart.
  QsInputs& in = drawing.inputs;
  Spread means(in.means, {0, 1}), scales(in.scales, {1, 0}), rotations(in.rotations, {0, 1}),
      opacities(in.opacities, {0}), background(in.background, {0});
  QsArray dc = in.sh, rest = in.sh;
  dc.sizes[1] = 1;
  rest.sizes[1] = 15;
  rest.data = static_cast<float*>(in.sh.data) + 3;
  Spread first(dc, {0, 2, 1}), others(rest, {1, 0, 2});
  in.means = means.array();
  in.scales = scales.array();
  in.rotations = rotations.array();
  in.opacities = opacities.array();
  in.background = background.array();
  in.sh = first.array();
  in.sh_rest = others.array();
  // Pictures: upside down.
  const QsMemory memory = drawing.blocks.memory();
  QsBlended pictures = c_pictures(drawing.pictures);
  pictures.alpha.data = drawing.pictures.alpha.data() + (test::kHeight - 1) * test::kWidth;
  pictures.alpha.strides[0] = -test::kWidth;
  Spread color(pictures.color, {2, 1, 0});
  const QsArray planes = std::exchange(pictures.color, color.array());
  quadsplat::check(qs_forward, context.get(), &in, &drawing.camera, &drawing.rules, &memory,
                   nullptr, &pictures, &drawing.frame);
  color.gather(planes);
  EXPECT_EQ(drawing.pictures.color, usual.pictures.color);
  for (int y = 0; y < test::kHeight; ++y) {
    for (int x = 0; x < test::kWidth; ++x) {
      ASSERT_EQ(drawing.pictures
                    .alpha[static_cast<std::size_t>((test::kHeight - 1 - y) * test::kWidth + x)],
                usual.pictures.alpha[static_cast<std::size_t>(y * test::kWidth + x)]);
    }
  }

  // Gradients.
  StageGradients<float> result{usual.scene, BoundaryValues<float>(300, 3), {}};
  auto by_inputs = sized<QsInputGradients>();
  set_inputs(by_inputs, result.by);
  const QsInputGradients packed = by_inputs;
  dc.data = result.by.sh.data();
  rest.data = result.by.sh.data() + 3;
  Spread by_means(packed.means, {0, 1}), by_rotations(packed.rotations, {0, 1}),
      by_opacities(packed.opacities, {0}), by_first(dc, {2, 0, 1}), by_others(rest, {0, 1, 2});
  by_inputs.means = by_means.array();
  by_inputs.rotations = by_rotations.array();
  by_inputs.opacities = by_opacities.array();
  by_inputs.sh = by_first.array();
  by_inputs.sh_rest = by_others.array();
  std::array<float, 24> matrix{};
  by_inputs.view_from_world = array_of(matrix.data(), {3, 4});
  by_inputs.view_from_world.strides[0] = 2;  // columns apart
  by_inputs.view_from_world.strides[1] = 6;
  const QsBlended by = c_pictures(weights);
  quadsplat::check(qs_backward, context.get(), &in, &drawing.camera, &drawing.rules, &drawing.frame,
                   &by, nullptr, &by_inputs);
  by_means.gather(packed.means);
  by_rotations.gather(packed.rotations);
  by_opacities.gather(packed.opacities);
  by_first.gather(dc);
  by_others.gather(rest);
  EXPECT_EQ(result.by.means, expected.by.means);
  EXPECT_EQ(result.by.scales, expected.by.scales);
  EXPECT_EQ(result.by.rotations, expected.by.rotations);
  EXPECT_EQ(result.by.opacities, expected.by.opacities);
  EXPECT_EQ(result.by.sh, expected.by.sh);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_EQ(matrix[static_cast<std::size_t>(2 * row + 6 * column)],
                static_cast<float>(expected.pose.view_from_world[column][row]));
    }
  }
}

TEST(LibraryStages, take_derivatives_that_are_one_number_for_all_pixels) {
  const DrawnView view = test::off_centre_view();
  quadsplat::Context context = test::cpu();
  Drawing<float> drawing(view, stage_scene<float>(100, 43));
  drawing.forward(context, true);
  PictureValues<float> weights(view.camera, 3);
  for (auto* values : {&weights.color, &weights.alpha, &weights.depth, &weights.inverse_depth})
    std::fill(values->begin(), values->end(), 0.5f);
  const auto expected = drawing.backward(context, weights, true);
  QsBlended by = c_pictures(weights);
  float half = 0.5f;
  for (QsArray* array : {&by.color, &by.alpha, &by.depth, &by.inverse_depth}) {
    array->data = &half;
    std::fill(std::begin(array->strides), std::end(array->strides), 0);
  }
  StageGradients<float> result{drawing.scene, BoundaryValues<float>(100, 3), {}};
  auto by_inputs = sized<QsInputGradients>();
  set_inputs(by_inputs, result.by);
  quadsplat::check(qs_backward, context.get(), &drawing.inputs, &drawing.camera, &drawing.rules,
                   &drawing.frame, &by, nullptr, &by_inputs);
  EXPECT_EQ(result.by.means, expected.by.means);
  EXPECT_EQ(result.by.sh, expected.by.sh);
}

// ---- differences

TEST(LibraryStages, have_gradients_that_equal_differences_in_double_precision) {
  constexpr double kStep = 1e-6;
  const DrawnView view = test::off_centre_view();
  quadsplat::Context context = test::cpu(1);
  Drawing<double> drawing(view, stage_scene<double>(16, 5));
  auto weights = PictureValues<double>::random(view.camera, 3);
  drawing.forward(context, true);
  StageGradients<double> gradients = drawing.backward(context, weights, true);
  const auto difference = [&](double& value) {
    const double before = value;
    const auto loss = [&](double moved) {
      value = moved;
      drawing.blocks = Blocks();
      drawing.forward(context, true);
      return drawing.pictures.dot(weights);
    };
    const double result = (loss(before + kStep) - loss(before - kStep)) / (2 * kStep);
    value = before;
    return result;
  };
  const auto expect = [&](const char* name, double* values, const std::vector<double>& gradient,
                          std::size_t stride = 1) {
    double scale = 0;
    for (const double value : gradient) scale = std::max(scale, std::abs(value));
    EXPECT_GT(scale, 0) << name;
    for (std::size_t i = 0; i < gradient.size(); i += stride)
      EXPECT_NEAR(gradient[i], difference(values[i]), 2e-6 * scale) << name << " " << i;
  };
  expect("mean", drawing.scene.means.data(), gradients.by.means);
  expect("scale", drawing.scene.scales.data(), gradients.by.scales);
  expect("rotation", drawing.scene.rotations.data(), gradients.by.rotations);
  expect("opacity", drawing.scene.opacities.data(), gradients.by.opacities);
  expect("coefficient", drawing.scene.sh.data(), gradients.by.sh, 13);
  expect("background", drawing.background.data(), gradients.boundary.background);
  std::vector<double> by_matrix, by_position;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      by_matrix.push_back(gradients.pose.view_from_world[column][row]);
    by_position.push_back(gradients.pose.position[row]);
  }
  expect("matrix", drawing.camera.view_from_world, by_matrix);
  expect("position", drawing.position.data(), by_position);
}

// ---- refusals

/// Calls that work, to be spoilt one argument at a time.
class LibraryStageRefusals : public testing::Test {
 protected:
  LibraryStageRefusals() {
    memory = drawing.blocks.memory();
    boundary = c_boundary<QsBoundary>(drawing.boundary, true);
    boundary.radii = array_of(drawing.radii.data(), {5, 2});
    pictures = c_pictures(drawing.pictures);
    by_pictures = c_pictures(weights);
    by_boundary = c_boundary<QsBoundaryGradients>(gradients.boundary, true);
    by_boundary.absolute_px = array_of(gradients.boundary.absolute_px.data(), {5, 2});
    by_boundary.background = array_of(gradients.boundary.background.data(), {3});
    by_inputs = sized<QsInputGradients>();
    set_inputs(by_inputs, gradients.by);
    by_inputs.view_from_world = array_of(matrix, {3, 4});
    by_inputs.position = array_of(matrix + 12, {3});
    drawing.forward(context, true);
  }

  enum Call { project, blend, forward, blend_backward, project_backward, backward };
  std::string call(Call which) {
    return sentence_of([&] {
      QsContext* const c = use_null_context ? nullptr : context.get();
      const QsInputs* const in = &drawing.inputs;
      const QsCamera* const camera = &drawing.camera;
      const QsRules* const rules = &drawing.rules;
      QsStageFrame* const frame = &drawing.frame;
      using quadsplat::check;
      if (which == project) check(qs_project, c, in, camera, rules, &memory, &boundary, frame);
      if (which == blend) check(qs_blend, c, in, camera, rules, &memory, &pictures, frame);
      if (which == forward)
        check(qs_forward, c, in, camera, rules, &memory, &boundary, &pictures, frame);
      if (which == blend_backward)
        check(qs_blend_backward, c, in, camera, rules, frame, &by_pictures, &by_boundary);
      if (which == project_backward)
        check(qs_project_backward, c, in, camera, rules, frame, &by_boundary, &by_inputs);
      if (which == backward)
        check(qs_backward, c, in, camera, rules, frame, &by_pictures, &by_boundary, &by_inputs);
    });
  }

  struct Case {
    Call which;
    std::function<void()> spoil;
    const char* sentence;
  };
  /// Every case is refused, and leaves the arguments of the next as they were.
  void expect_refusals(const std::vector<Case>& cases) {
    const auto in = drawing.inputs;
    const auto camera = drawing.camera;
    const auto rules = drawing.rules;
    const auto frame = drawing.frame;
    const auto kept =
        std::make_tuple(memory, boundary, pictures, by_pictures, by_boundary, by_inputs);
    for (const Case& one : cases) {
      one.spoil();
      EXPECT_EQ(call(one.which), one.sentence);
      drawing.inputs = in;
      drawing.camera = camera;
      drawing.rules = rules;
      drawing.frame = frame;
      std::tie(memory, boundary, pictures, by_pictures, by_boundary, by_inputs) = kept;
    }
    for (const Call which : {forward, project, blend, blend_backward, project_backward, backward})
      EXPECT_EQ(call(which), "") << which;
  }

  quadsplat::Context context = test::cpu(1);
  bool use_null_context = false;
  DrawnView view = test::off_centre_view(40, 30);
  Drawing<float> drawing{view, stage_scene<float>(5, 44)};
  PictureValues<float> weights{view.camera, 3};
  StageGradients<float> gradients{drawing.scene, BoundaryValues<float>(5, 3), {}};
  double matrix[15] = {};
  double doubles[1000] = {};
  float floats[1000] = {};
  QsMemory memory;
  QsBoundary boundary;
  QsBlended pictures, by_pictures;
  QsBoundaryGradients by_boundary;
  QsInputGradients by_inputs;
};

TEST_F(LibraryStageRefusals, of_inputs) {
  QsInputs& in = drawing.inputs;
  expect_refusals({
      {forward, [&] { in.size = 0; },
       "qs_forward: inputs.size: is 0: set it to the size of the struct, 904 bytes in this "
       "library"},
      {forward, [&] { in.reserved = 1; }, "qs_forward: inputs.reserved: is not 0"},
      {project, [&] { in.means = {}; },
       "qs_project: inputs.means: is absent: it needs 2 dimensions"},
      {project, [&] { in.means.sizes[0] = std::int64_t{1} << 31; },
       "qs_project: inputs.means: 2147483648 Gaussians are more than 2147483647"},
      {project, [&] { in.means.type = QS_UINT8; },
       "qs_project: inputs.means: has elements of type uint8 instead of float32 or float64"},
      {project, [&] { in.means.type = 12; }, "qs_project: inputs.means: its type 12 is unknown"},
      {project, [&] { in.means.memory = QS_MEMORY_CUDA; },
       "qs_project: inputs.scales: is in host memory, but means is in the memory of GPU 0"},
      {forward, [&] { in.opacities.memory = QS_MEMORY_CUDA; },
       "qs_forward: inputs.opacities: is in the memory of GPU 0, but means is in host memory"},
      {blend, [&] { in.means.data = nullptr; }, "qs_blend: inputs.means: its data is null"},
      {forward, [&] { in.scales.sizes[0] = 4; },
       "qs_forward: inputs.scales: has 4 x 3 elements instead of 5 x 3"},
      {forward,
       [&] {
         in.scales = array_of(doubles, {5, 3});
       },
       "qs_forward: inputs.scales: has elements of type float64 instead of float32"},
      {forward, [&] { in.rotations = {}; },
       "qs_forward: inputs.rotations: is absent: it needs 2 dimensions"},
      {forward,
       [&] {
         in.covariances = array_of(floats, {5, 6});
       },
       "qs_forward: inputs.scales: is given, and so are covariances"},
      {forward,
       [&] {
         in.covariances = array_of(floats, {5, 6});
         in.scales = {};
       },
       "qs_forward: inputs.rotations: is given, and so are covariances"},
      {forward,
       [&] {
         in.covariances = array_of(floats, {5, 3});
         in.scales = in.rotations = {};
       },
       "qs_forward: inputs.covariances: has 5 x 3 elements instead of 5 x 6"},
      {forward,
       [&] {
         in.opacities = array_of(floats, {5, 1});
       },
       "qs_forward: inputs.opacities: has 2 dimensions instead of 1"},
      {forward, [&] { in.opacities.strides[0] = std::int64_t{1} << 62; },
       "qs_forward: inputs.opacities: its sizes and strides reach beyond 64 bits"},
      {forward, [&] { in.sh = {}; }, "qs_forward: inputs.sh: is absent: it needs 3 dimensions"},
      {forward, [&] { in.sh.sizes[1] = 5; },
       "qs_forward: inputs.sh: 5 coefficients of spherical harmonics are not 1, 4, 9 or 16"},
      {forward, [&] { in.sh_rest = in.sh; },
       "qs_forward: inputs.sh: has 16 coefficients instead of the DC alone"},
      {forward,
       [&] {
         in.channels = array_of(floats, {5, 3});
       },
       "qs_forward: inputs.sh: is given, and so are channels"},
      {forward,
       [&] {
         in.sh = {};
         in.channels = array_of(floats, {5, 33});
       },
       "qs_forward: inputs.channels: 33 channels are not between 1 and 32"},
      {forward,
       [&] {
         in.sh = {};
         in.channels = array_of(floats, {5, 0});
       },
       "qs_forward: inputs.channels: 0 channels are not between 1 and 32"},
      {forward, [&] { in.background = array_of(floats, {4}); },
       "qs_forward: inputs.background: has 4 elements instead of 3"},
      {forward, [&] { in.position = array_of(floats, {2}); },
       "qs_forward: inputs.position: has 2 elements instead of 3"},
      {forward, [&] { drawing.position[1] = std::nan(""); },
       "qs_forward: the camera has a number that is not finite"},
      {forward,
       [&] {
         drawing.position[1] = 0;
         drawing.camera.width = 0;
       },
       "qs_forward: camera.width: 0 pixels are not between 1 and 65535"},
      {backward, [&] { drawing.camera.height = 0; },
       "qs_backward: camera.height: 0 pixels are not between 1 and 65535"},
      {forward, [&] { drawing.camera.height = 40000; },
       "qs_forward: the picture has 40 x 40000 pixels; both sides must be 1 to 32768"},
      {forward, [&] { drawing.camera.view_from_world[0] = 2; },
       "qs_forward: camera.view_from_world: its rotation is not a rotation matrix (off by 3)"},
  });
}

TEST_F(LibraryStageRefusals, of_rules) {
  QsRules& rules = drawing.rules;
  const auto refused = [&](std::function<void()> spoil, const char* sentence) {
    return Case{forward, std::move(spoil), sentence};
  };
  expect_refusals({
      refused([&] { rules.cull = "reference"; },
              "qs_forward: the culling mode must be a mode that lists tiles"),
      refused([&] { rules.sh_degree = 4; }, "qs_forward: the degree of colour must be 0 to 3"),
      refused([&] { rules.far_depth = 0.1; },
              "qs_forward: the far plane must be behind the near plane"),
      refused([&] { rules.dilation_px2 = -1; }, "qs_forward: the dilation must be 0 or more"),
      refused([&] { rules.splat_scale = 0; }, "qs_forward: the scale of splats must be above 0"),
      refused([&] { rules.compensation_floor = 2; },
              "qs_forward: the lower bound of the compensation must be 0 to 1"),
      refused([&] { rules.alpha_max = 1; },
              "qs_forward: the largest alpha must be above 0 and below 1"),
      refused([&] { rules.radius_clip_px = -1; },
              "qs_forward: the smallest radius must be 0 or more"),
      refused([&] { rules.slope_low[0] = 1; },
              "qs_forward: a bound of slopes is above its upper one"),
      refused([&] { rules.antialiased = 2; }, "qs_forward: rules.antialiased: is 2"),
      refused([&] { rules.keeps_rotation_length = 2; },
              "qs_forward: rules.keeps_rotation_length: is 2"),
      refused([&] { rules.zero_color_passes = 2; }, "qs_forward: rules.zero_color_passes: is 2"),
      refused([&] { rules.alpha_max_blocks = 2; }, "qs_forward: rules.alpha_max_blocks: is 2"),
      refused([&] { rules.stops_at_equal = 2; }, "qs_forward: rules.stops_at_equal: is 2"),
      refused([&] { rules.radius_rule = 3; }, "qs_forward: rules.radius_rule: is 3"),
  });
  rules.cull = "none";
  EXPECT_EQ(call(forward).find("qs_forward: rules.cull: 'none' is none of reference, "), 0u);
}

TEST_F(LibraryStageRefusals, of_results) {
  expect_refusals({
      {forward, [&] { memory.allocate = nullptr; }, "qs_forward: memory.allocate: is null"},
      {blend, [&] { memory.reserved = 1; }, "qs_blend: memory.reserved: is not 0"},
      {project, [&] { boundary.corners = 2; }, "qs_project: boundary.corners: is 2"},
      {project, [&] { boundary.means_px.sizes[1] = 3; },
       "qs_project: boundary.means_px: has 5 x 3 elements instead of 5 x 2"},
      {project, [&] { boundary.conics.strides[0] = 0; },
       "qs_project: boundary.conics: its stride of dimension 0 is 0, so that elements would be "
       "overwritten"},
      {forward, [&] { boundary.depths = array_of(doubles, {5}); },
       "qs_forward: boundary.depths: has elements of type float64 instead of float32"},
      {forward, [&] { boundary.radii.type = QS_FLOAT32; },
       "qs_forward: boundary.radii: has elements of type float32 instead of int32"},
      {forward, [&] { boundary.radii.memory = QS_MEMORY_CUDA; },
       "qs_forward: boundary.radii: is in the memory of GPU 0, but means is in host memory"},
      {forward,
       [&] {
         boundary.radii = array_of(drawing.radii.data(), {5});
         drawing.rules.radius_rule = QS_RADII_GSPLAT_1_5;
       },
       "qs_forward: boundary.radii: has 1 dimension, but the rule has a radius for each axis"},
      {blend, [&] { pictures.color.sizes[2] = 4; },
       "qs_blend: pictures.color: has 30 x 40 x 4 elements instead of 30 x 40 x 3"},
      {forward, [&] { pictures.reserved = 1; }, "qs_forward: pictures.reserved: is not 0"},
      {forward, [&] { pictures.alpha.strides[1] = 0; },
       "qs_forward: pictures.alpha: its stride of dimension 1 is 0, so that elements would be "
       "overwritten"},
      {forward, [&] { pictures.depth.type = QS_UINT8; },
       "qs_forward: pictures.depth: has elements of type uint8 instead of float32"},
      {backward, [&] { by_pictures.inverse_depth.sizes[0] = 29; },
       "qs_backward: by_pictures.inverse_depth: has 29 x 40 elements instead of 30 x 40"},
      {blend_backward, [&] { by_pictures.color.memory = QS_MEMORY_CUDA; },
       "qs_blend_backward: by_pictures.color: is in the memory of GPU 0, but means is in host "
       "memory"},
      {blend_backward,
       [&] {
         by_boundary.channels = array_of(floats, {5, 3});
       },
       "qs_blend_backward: by_boundary.channels: belongs to channels, but the inputs have sh"},
      {backward, [&] { by_boundary.absolute_px.sizes[0] = 6; },
       "qs_backward: by_boundary.absolute_px: has 6 x 2 elements instead of 5 x 2"},
      {backward, [&] { by_boundary.background.sizes[0] = 1; },
       "qs_backward: by_boundary.background: has 1 elements instead of 3"},
      {backward, [&] { by_boundary.ndc = 2; }, "qs_backward: by_boundary.ndc: is 2"},
      {project_backward, [&] { by_boundary.ndc = 1; },
       "qs_project_backward: by_boundary.ndc: is 1, but derivatives that are read are by pixels"},
      {project_backward, [&] { by_boundary.colors.sizes[1] = 4; },
       "qs_project_backward: by_boundary.colors: has 5 x 4 elements instead of 5 x 3"},
      {backward, [&] { by_inputs.reserved = 1; }, "qs_backward: by_inputs.reserved: is not 0"},
      {backward, [&] { by_inputs.means.strides[0] = 0; },
       "qs_backward: by_inputs.means: its stride of dimension 0 is 0, so that elements would be "
       "overwritten"},
      {backward,
       [&] {
         by_inputs.covariances = array_of(floats, {5, 6});
       },
       "qs_backward: by_inputs.covariances: belongs to covariances, which are not given"},
      {project_backward, [&] { by_inputs.sh.sizes[1] = 4; },
       "qs_project_backward: by_inputs.sh: has 4 coefficients, but the inputs have 16"},
      {backward, [&] { by_inputs.view_from_world.sizes[0] = 4; },
       "qs_backward: by_inputs.view_from_world: has 4 x 4 elements instead of 3 x 4"},
      {backward, [&] { by_inputs.position.type = QS_INT32; },
       "qs_backward: by_inputs.position: has elements of type int32 instead of float32 or "
       "float64"},
  });
}

TEST_F(LibraryStageRefusals, of_results_for_inputs_that_are_not_given) {
  drawing.inputs.scales = drawing.inputs.rotations = drawing.inputs.sh = {};
  drawing.inputs.covariances = array_of(drawing.scene.covariances.data(), {5, 6});
  drawing.inputs.channels = array_of(floats, {5, 3});
  boundary.colors = by_boundary.colors = {};
  by_inputs.scales = by_inputs.rotations = by_inputs.sh = {};
  ASSERT_EQ(call(forward), "");
  const QsArray colors = array_of(floats, {5, 3});
  expect_refusals({
      {forward, [&] { boundary.colors = colors; },
       "qs_forward: boundary.colors: belongs to sh, but the inputs have channels"},
      {project_backward, [&] { by_boundary.colors = colors; },
       "qs_project_backward: by_boundary.colors: belongs to sh, but the inputs have channels"},
      {backward, [&] { by_inputs.scales = colors; },
       "qs_backward: by_inputs.scales: belongs to scales, which are not given"},
      {backward,
       [&] {
         by_inputs.rotations = array_of(floats, {5, 4});
       },
       "qs_backward: by_inputs.rotations: belongs to rotations, which are not given"},
      {backward,
       [&] {
         by_inputs.sh = array_of(floats, {5, 1, 3});
       },
       "qs_backward: by_inputs.sh: belongs to sh, but the inputs have channels"},
  });
}

TEST_F(LibraryStageRefusals, of_frames_of_another_forward_call) {
  QsStageFrame& frame = drawing.frame;
  Drawing<float> more(view, stage_scene<float>(6, 44));
  more.forward(context, true);
  Drawing<float> wide(test::off_centre_view(41, 30), drawing.scene);
  wide.forward(context, true);
  Drawing<double> exact(view, stage_scene<double>(5, 44));
  exact.forward(context, true);
  Drawing<float> channels(view, test::with_channels(drawing.scene, 2));
  channels.forward(context, true);
  expect_refusals({
      {backward, [&] { frame = sized<QsStageFrame>(); },
       "qs_backward: frame: is empty: qs_project() fills it"},
      {blend, [&] { frame = sized<QsStageFrame>(); },
       "qs_blend: frame: is empty: qs_project() fills it"},
      {backward, [&] { frame.size = 8; },
       "qs_backward: frame.size: is 8: set it to the size of the struct, 80 bytes in this library"},
      {backward, [&] { frame = more.frame; },
       "qs_backward: frame: belongs to 6 Gaussians, but the inputs have 5"},
      {blend, [&] { frame = more.frame; },
       "qs_blend: frame: belongs to 6 Gaussians, but the inputs have 5"},
      {project_backward, [&] { frame = wide.frame; },
       "qs_project_backward: frame: belongs to 41 x 30 pixels, but the camera has 40 x 30"},
      {blend_backward, [&] { frame = exact.frame; },
       "qs_blend_backward: frame: belongs to arrays of float64"},
      {blend_backward, [&] { frame = channels.frame; },
       "qs_blend_backward: frame: belongs to 2 channels, but the inputs have 3"},
      {backward, [&] { frame.per_pixel = nullptr; },
       "qs_backward: frame: has no pixels: qs_blend() draws them"},
      {backward, [&] { frame.per_pair = nullptr; }, "qs_backward: frame.per_pair: is null"},
      {backward, [&] { frame.per_gaussian = more.frame.per_gaussian; },
       "qs_backward: frame.per_gaussian: does not hold this frame"},
      {backward, [&] { std::swap(frame.per_gaussian, frame.per_pair); },
       "qs_backward: frame.per_gaussian: does not hold this frame"},
      {backward, [&] { frame.per_pixel = wide.frame.per_pixel; },
       "qs_backward: frame.per_pixel: does not hold this frame"},
      {backward, [&] { frame.per_pair = static_cast<char*>(frame.per_pair) + 4; },
       "qs_backward: frame.per_pair: is not aligned to 16 bytes"},
      {backward, [&] { ++frame.pairs; },
       "qs_backward: frame.per_gaussian: does not hold this frame"},
      {backward, [&] { frame.has_depth = 7; },
       "qs_backward: frame.per_pixel: does not hold this frame"},
  });
  // Depths have gradients if they were drawn.
  pictures.depth = pictures.inverse_depth = {};
  ASSERT_EQ(call(forward), "");
  EXPECT_EQ(call(backward),
            "qs_backward: by_pictures.depth: is given, but the frame was drawn without depths");
  by_pictures.depth = {};
  EXPECT_EQ(
      call(blend_backward),
      "qs_blend_backward: by_pictures.inverse_depth: is given, but the frame was drawn without "
      "depths");
  by_pictures.inverse_depth = {};
  EXPECT_EQ(call(backward), "");
}

TEST_F(LibraryStageRefusals, of_null_pointers) {
  use_null_context = true;
  for (const auto& [which, name] : std::initializer_list<std::pair<Call, const char*>>{
           {project, "qs_project"},
           {blend, "qs_blend"},
           {forward, "qs_forward"},
           {blend_backward, "qs_blend_backward"},
           {project_backward, "qs_project_backward"},
           {backward, "qs_backward"}})
    EXPECT_EQ(call(which), std::string(name) + ": context: is null");
  use_null_context = false;
  ASSERT_EQ(call(forward), "");
  char message[QS_MESSAGE_BYTES];
  QsContext* const c = context.get();
  const QsInputs* const in = &drawing.inputs;
  const QsCamera* const camera = &drawing.camera;
  QsStageFrame* const frame = &drawing.frame;
  const auto expect = [&](std::int32_t result, const char* sentence) {
    EXPECT_EQ(result, QS_USAGE) << sentence;
    EXPECT_STREQ(message, sentence);
  };
  expect(qs_blend(c, nullptr, camera, nullptr, &memory, &pictures, frame, message),
         "qs_blend: inputs: is null");
  expect(qs_blend(c, in, nullptr, nullptr, &memory, &pictures, frame, message),
         "qs_blend: camera: is null");
  expect(qs_blend(c, in, camera, nullptr, nullptr, &pictures, frame, message),
         "qs_blend: memory: is null");
  expect(qs_blend(c, in, camera, nullptr, &memory, nullptr, frame, message),
         "qs_blend: pictures: is null");
  expect(qs_blend(c, in, camera, nullptr, &memory, &pictures, nullptr, message),
         "qs_blend: frame: is null");
  expect(qs_project(c, in, camera, nullptr, &memory, nullptr, nullptr, message),
         "qs_project: frame: is null");
  expect(qs_forward(c, in, camera, nullptr, &memory, nullptr, &pictures, nullptr, message),
         "qs_forward: frame: is null");
  expect(qs_blend_backward(c, in, camera, nullptr, frame, nullptr, &by_boundary, message),
         "qs_blend_backward: by_pictures: is null");
  expect(qs_blend_backward(c, in, camera, nullptr, frame, &by_pictures, nullptr, message),
         "qs_blend_backward: by_boundary: is null");
  expect(qs_project_backward(c, in, camera, nullptr, frame, nullptr, &by_inputs, message),
         "qs_project_backward: by_boundary: is null");
  expect(qs_project_backward(c, in, camera, nullptr, frame, &by_boundary, nullptr, message),
         "qs_project_backward: by_inputs: is null");
  expect(qs_backward(c, in, camera, nullptr, nullptr, &by_pictures, nullptr, &by_inputs, message),
         "qs_backward: frame: is null");
  EXPECT_EQ(qs_backward(c, in, camera, nullptr, frame, &by_pictures, nullptr, &by_inputs, message),
            QS_OK);
}

TEST_F(LibraryStageRefusals, of_counts_of_pixels) {
  ASSERT_EQ(call(forward), "");
  std::vector<std::int32_t> numbers(10);
  QsArray counts = array_of(numbers.data(), {5});
  const auto sentence = [&](double behind, const QsArray* to) {
    return sentence_of([&] {
      quadsplat::check(qs_count_pixels, context.get(), &drawing.inputs, &drawing.camera,
                       &drawing.rules, &drawing.frame, behind, to);
    });
  };
  EXPECT_EQ(sentence(0.5, nullptr), "qs_count_pixels: counts: is null");
  EXPECT_EQ(sentence(1, &counts), "qs_count_pixels: behind: 1 is not at least 0 and below 1");
  EXPECT_EQ(sentence(-0.5, &counts), "qs_count_pixels: behind: -0.5 is not at least 0 and below 1");
  EXPECT_EQ(sentence(std::nan(""), &counts),
            "qs_count_pixels: behind: nan is not at least 0 and below 1");
  counts.sizes[0] = 4;
  EXPECT_EQ(sentence(0.5, &counts), "qs_count_pixels: counts: has 4 elements instead of 5");
  counts = array_of(drawing.scene.opacities.data(), {5});
  EXPECT_EQ(sentence(0.5, &counts).find("qs_count_pixels: counts: "), 0u);
  counts = array_of(numbers.data(), {5});
  counts.strides[0] = 0;
  EXPECT_EQ(sentence(0.5, &counts).find("qs_count_pixels: counts: its stride"), 0u);
  drawing.frame = sized<QsStageFrame>();
  EXPECT_EQ(sentence(0.5, &counts), "qs_count_pixels: frame: is empty: qs_project() fills it");
  EXPECT_EQ(numbers, std::vector<std::int32_t>(10));
}

TEST_F(LibraryStageRefusals, write_nothing_but_an_empty_frame) {
  std::fill(drawing.pictures.color.begin(), drawing.pictures.color.end(), 8.0f);
  std::fill(drawing.radii.begin(), drawing.radii.end(), 8);
  pictures.alpha.sizes[0] = 3;
  drawing.blocks.kinds.clear();
  EXPECT_EQ(call(forward), "qs_forward: pictures.alpha: has 3 x 40 elements instead of 30 x 40");
  EXPECT_EQ(drawing.pictures.color, std::vector<float>(drawing.pictures.color.size(), 8.0f));
  EXPECT_EQ(drawing.radii, std::vector<std::int32_t>(10, 8));
  EXPECT_TRUE(drawing.blocks.kinds.empty());
  EXPECT_EQ(drawing.frame.per_gaussian, nullptr);
  EXPECT_EQ(drawing.frame.size, sizeof(QsStageFrame));
}

}  // namespace
}  // namespace qs
