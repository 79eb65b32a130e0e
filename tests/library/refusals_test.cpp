// SPDX-License-Identifier: MIT
// Every wrong argument is refused with one sentence that names it, and nothing is written.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>

#include "library/opened_scene.h"
#include "support/scenes.h"

namespace qs {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A scene, a camera and requests that work, to be spoilt one member at a time.
class LibraryRefusals : public testing::Test {
 protected:
  LibraryRefusals() {
    settings_ = QS_SETTINGS;
    picture_ = test::picture_of(results_, camera_);
    camera_.focal_px[0] = 35;
    camera_.focal_px[1] = 34;
  }

  std::string render() {
    return test::sentence_of(
        [&] { quadsplat::check(qs_render, scene_.get(), &camera_, one_, &settings_, &picture_); });
  }
  std::string rendering(const std::function<void()>& spoil) {
    const auto camera = camera_;
    const auto settings = settings_;
    const auto picture = picture_;
    spoil();
    const std::string sentence = render();
    camera_ = camera;
    settings_ = settings;
    picture_ = picture;
    return sentence;
  }
  std::string wrapping(const std::function<void(QsGaussians&)>& spoil) {
    QsGaussians given = gaussians_;
    spoil(given);
    QsSceneHandle* scene = scene_.get();
    const std::string sentence =
        test::sentence_of([&] { quadsplat::check(qs_scene_wrap, context_.get(), &given, &scene); });
    EXPECT_EQ(scene == nullptr, !sentence.empty());
    if (scene != scene_.get()) qs_scene_close(scene);
    return sentence;
  }

  const std::uint64_t one_ = 1;
  GaussianCloud cloud_ = test::random_cloud(5, 1, 1);
  quadsplat::Context context_ = test::cpu(1);
  quadsplat::Scene scene_ = context_.wrap(test::gaussians_of(cloud_));
  QsCamera camera_ = test::c_camera(test::front_camera(40, 30));
  test::Results results_;
  QsSettings settings_;
  QsPicture picture_;
  test::CloudArrays gaussians_{cloud_};
};

TEST_F(LibraryRefusals, of_contexts) {
  QsContext* context = nullptr;
  const auto opening = [&](std::uint32_t backend, int device, int threads) {
    return test::sentence_of(
        [&] { quadsplat::check(qs_context_open, backend, device, threads, &context); });
  };
  EXPECT_EQ(opening(3, 0, 1),
            "qs_context_open: backend: 3 is none of QS_BACKEND_AUTO, _CPU and _CUDA");
  EXPECT_EQ(opening(QS_BACKEND_CPU, -2, 1), "qs_context_open: device: is -2");
  EXPECT_EQ(opening(QS_BACKEND_CPU, 0, -1),
            "qs_context_open: threads: -1 is not between 0 and 1024");
  EXPECT_EQ(opening(QS_BACKEND_CPU, 0, 1025),
            "qs_context_open: threads: 1025 is not between 0 and 1024");
  EXPECT_EQ(context, nullptr);
  char message[QS_MESSAGE_BYTES];
  EXPECT_EQ(qs_context_open(QS_BACKEND_CPU, 0, 1, nullptr, message), QS_USAGE);
  EXPECT_STREQ(message, "qs_context_open: context: is null");
}

TEST_F(LibraryRefusals, of_a_backend_that_is_missing) {
  auto report = quadsplat::sized<QsReport>();
  quadsplat::check(qs_report, &report, nullptr, std::uint64_t{0});
  EXPECT_GE(report.threads, 1u);
  quadsplat::Context best;
  if (report.first_gpu >= 0) {
    EXPECT_STREQ(report.cuda_problem, "");
    EXPECT_EQ(best.backend(), QS_BACKEND_CUDA);
    GTEST_SKIP() << "this machine has a GPU";
  }
  EXPECT_EQ(best.backend(), QS_BACKEND_CPU);
  EXPECT_STRNE(report.cuda_problem, "");
  EXPECT_EQ(test::sentence_of([] { quadsplat::Context context(QS_BACKEND_CUDA); }, QS_DEVICE)
                .find("backend cuda: "),
            0u);
}

TEST_F(LibraryRefusals, of_null_pointers) {
  char message[QS_MESSAGE_BYTES];
  std::uint64_t count = 0;
  QsSceneHandle* scene = nullptr;
  QsCameras* cameras = nullptr;
  auto facts = quadsplat::sized<QsSceneFacts>();
  auto comparison = quadsplat::sized<QsComparison>();
  auto lists = quadsplat::sized<QsLists>();
  auto mode = quadsplat::sized<QsMode>();
  const std::string path = test::plush().string();
  QsContext* const context = context_.get();
  const auto expect = [&](std::int32_t result, const char* sentence) {
    EXPECT_EQ(result, QS_USAGE) << sentence;
    EXPECT_STREQ(message, sentence);
  };
  expect(qs_scene_load(nullptr, path.c_str(), nullptr, &scene, message),
         "qs_scene_load: context: is null");
  expect(qs_scene_load(context, nullptr, nullptr, &scene, message), "qs_scene_load: path: is null");
  expect(qs_scene_load(context, path.c_str(), nullptr, nullptr, message),
         "qs_scene_load: scene: is null");
  expect(qs_scene_wrap(nullptr, &gaussians_, &scene, message), "qs_scene_wrap: context: is null");
  expect(qs_scene_wrap(context, nullptr, &scene, message), "qs_scene_wrap: gaussians: is null");
  expect(qs_scene_wrap(context, &gaussians_, nullptr, message), "qs_scene_wrap: scene: is null");
  expect(qs_scene_facts(nullptr, &facts, message), "qs_scene_facts: scene: is null");
  expect(qs_scene_facts(scene_.get(), nullptr, message), "qs_scene_facts: facts: is null");
  expect(qs_cameras_open(nullptr, &cameras, &count, message), "qs_cameras_open: path: is null");
  expect(qs_cameras_open(path.c_str(), nullptr, &count, message),
         "qs_cameras_open: cameras: is null");
  expect(qs_cameras_open(path.c_str(), &cameras, nullptr, message),
         "qs_cameras_open: count: is null");
  expect(qs_cameras_get(nullptr, 0, &camera_, nullptr, message),
         "qs_cameras_get: cameras: is null");
  expect(qs_camera_resize(nullptr, 1, 1, message), "qs_camera_resize: camera: is null");
  expect(qs_render(nullptr, &camera_, 1, nullptr, &picture_, message), "qs_render: scene: is null");
  expect(qs_render(scene_.get(), nullptr, 1, nullptr, &picture_, message),
         "qs_render: cameras[0]: is null");
  expect(qs_render(scene_.get(), &camera_, 1, nullptr, nullptr, message),
         "qs_render: pictures[0]: is null");
  expect(qs_lists(nullptr, &camera_, nullptr, &lists, message), "qs_lists: scene: is null");
  expect(qs_lists(scene_.get(), nullptr, nullptr, &lists, message), "qs_lists: camera: is null");
  expect(qs_lists(scene_.get(), &camera_, nullptr, nullptr, message), "qs_lists: lists: is null");
  expect(qs_count_modes(nullptr, &camera_, nullptr, nullptr, 0, &count, message),
         "qs_count_modes: scene: is null");
  expect(qs_count_modes(scene_.get(), &camera_, nullptr, nullptr, 1, &count, message),
         "qs_count_modes: counts: is null");
  expect(qs_select(nullptr, "{}", nullptr, nullptr, message), "qs_select: scene: is null");
  expect(qs_select(scene_.get(), nullptr, nullptr, nullptr, message), "qs_select: edits: is null");
  const std::int32_t pixel[2] = {0, 0};
  QsSurfacePoint point;
  expect(qs_measure(nullptr, &camera_, nullptr, pixel, 1, &point, message),
         "qs_measure: scene: is null");
  expect(qs_measure(scene_.get(), nullptr, nullptr, pixel, 1, &point, message),
         "qs_measure: camera: is null");
  expect(qs_measure(scene_.get(), &camera_, nullptr, nullptr, 1, &point, message),
         "qs_measure: pixels: is null");
  expect(qs_measure(scene_.get(), &camera_, nullptr, pixel, 1, nullptr, message),
         "qs_measure: points: is null");
  expect(qs_convert(nullptr, "a.ply", nullptr, message), "qs_convert: scene: is null");
  expect(qs_convert(scene_.get(), nullptr, nullptr, message), "qs_convert: path: is null");
  const QsArray none{};
  expect(qs_compare(nullptr, &none, &none, &comparison, message), "qs_compare: context: is null");
  expect(qs_compare(context, nullptr, &none, &comparison, message), "qs_compare: a: is null");
  expect(qs_compare(context, &none, nullptr, &comparison, message), "qs_compare: b: is null");
  expect(qs_compare(context, &none, &none, nullptr, message), "qs_compare: comparison: is null");
  expect(qs_report(nullptr, nullptr, 0, message), "qs_report: report: is null");
  expect(qs_mode(0, nullptr, nullptr, message), "qs_mode: mode: is null");
  expect(qs_scene_load(context, "", nullptr, &scene, message), "qs_scene_load: path: is empty");
  expect(qs_cameras_open("", &cameras, &count, message), "qs_cameras_open: path: is empty");
  expect(qs_convert(scene_.get(), "", nullptr, message), "qs_convert: path: is empty");
  // Without a buffer for the sentence, and functions that allow null.
  EXPECT_EQ(qs_mode(0, nullptr, nullptr, nullptr), QS_USAGE);
  EXPECT_EQ(qs_mode(0, &mode, nullptr, nullptr), QS_OK);
  qs_context_close(nullptr);
  qs_scene_close(nullptr);
  qs_cameras_close(nullptr);
  qs_stop(nullptr);
  EXPECT_EQ(qs_context_backend(nullptr), 0u);
}

TEST_F(LibraryRefusals, of_cameras) {
  EXPECT_EQ(render(), "");
  const struct {
    std::function<void()> spoil;
    const char* sentence;
  } cases[] = {
      {[&] { camera_.width = 0; }, "width: 0 pixels are not between 1 and 65535"},
      {[&] { camera_.height = -3; }, "height: -3 pixels are not between 1 and 65535"},
      {[&] { camera_.width = 65536; }, "width: 65536 pixels are not between 1 and 65535"},
      {[&] { camera_.reserved = 1; }, "reserved: is not 0"},
      {[&] { camera_.focal_px[0] = 0; }, "focal_px: 0 and 34 are not above 0"},
      {[&] { camera_.focal_px[1] = kNaN; }, "focal_px: 35 and nan are not above 0"},
      {[&] { camera_.near_depth = -0.5; }, "near_depth: -0.5 is below 0"},
      {[&] { camera_.near_depth = kNaN; }, "near_depth: nan is below 0"},
      {[&] { camera_.view_from_world[0] = 2; },
       "view_from_world: its rotation is not a rotation matrix (off by 3)"},
      {[&] { camera_.view_from_world[5] = kNaN; },
       "view_from_world: its rotation is not a rotation matrix (off by nan)"},
      {[&] { camera_.size = 12; },
       "size: is 12: set it to the size of the struct, 320 bytes in this library"},
  };
  for (const auto& one : cases) {
    EXPECT_EQ(rendering(one.spoil), std::string("qs_render: cameras[0].") + one.sentence);
  }
  EXPECT_EQ(rendering([&] {
              camera_.view_from_world[3] = 1e16;
            }).find("qs_render: cameras[0]: its position"),
            0u);
  EXPECT_EQ(rendering([&] { camera_.center_px[0] = kNaN; }).find("qs_render: cameras[0]: nan for"),
            0u);
  EXPECT_EQ(render(), "");
  EXPECT_EQ(test::sentence_of([&] { quadsplat::check(qs_camera_resize, &camera_, 0, 5); }),
            "qs_camera_resize: width: 0 pixels are not between 1 and 65535");
  EXPECT_EQ(camera_.width, 40);
}

TEST_F(LibraryRefusals, of_cameras_with_a_model) {
  const auto with = [&](const std::string& model, const std::vector<double>& parameters) {
    return [this, model, parameters] { test::set_model(camera_, model, parameters); };
  };
  const struct {
    std::function<void()> spoil;
    const char* sentence;
  } cases[] = {
      {with("FISH", {}), "].model: 'FISH' is no camera model of COLMAP, and not ORTHOGRAPHIC"},
      {with(std::string(32, 'x'), {}), "].model: 'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx' is no camera"},
      {with("opencv", {}), "].model: 'opencv' is no camera model"},
      {with("OPENCV_FISHEYE", {30, 30, 20, 15, 0, 0, 0}),
       "].parameters: OPENCV_FISHEYE has 8 of them, but 7 are given"},
      {with("FISHEYE", {30, 30, 20, 15, 0}), "].parameters: FISHEYE has 4 of them, but 5 are"},
      {with("ORTHOGRAPHIC", {}), "].parameters: ORTHOGRAPHIC has 1 of them, but 0 are given"},
      {with("ORTHOGRAPHIC", {0}), "].parameters: 0 is not between 1e-12 and 1e+12"},
      {with("ORTHOGRAPHIC", {kNaN}), "].parameters: nan is not between"},
      {with("FISHEYE", {-30, 30, 20, 15}), "]: the focal length is not above 0"},
      {with("FISHEYE", {30, kNaN, 20, 15}), "]: a parameter is not finite"},
      {with("FOV", {30, 30, 20, 15, 4}), "]: omega is 4"},
      {with("EQUIRECTANGULAR", {40, 20}), "]: the parameters of EQUIRECTANGULAR are 40 x 20, but"},
      {with("EQUIRECTANGULAR", {40, 30}), "]: a panorama of 40 x 30 pixels is not twice as wide"},
      {[&] { std::strcpy(camera_.model, "FISHEYE"); },
       "].model: FISHEYE has its parameters, so focal_px and center_px must be 0"},
      {[&] { camera_.parameter_count = 1; }, "].model: is empty, but there are parameters"},
      {[&] { camera_.parameters[0] = 1; }, "].model: is empty, but there are parameters"},
      {[&] { camera_.reserved2 = 1; }, "].reserved: is not 0"},
      {with("FISHEYE", {30, 30, 20, 15}),
       "qs_render: pictures[0]: a camera with the model FISHEYE is drawn by several pictures, so "
       "evaluated, pairs and used must be absent"},
  };
  for (const auto& [spoil, sentence] : cases) {
    const std::string said = rendering(spoil);
    EXPECT_NE(said.find(sentence), std::string::npos) << said << " instead of " << sentence;
    EXPECT_EQ(said.rfind("qs_render: ", 0), 0u);
  }
  test::set_model(camera_, "FISHEYE", {30, 30, 20, 15});
  auto lists = quadsplat::sized<QsLists>();
  const char* const kPinhole =
      "camera.model: FISHEYE is drawn by qs_render() alone, and this takes a pinhole camera";
  EXPECT_EQ(test::sentence_of(
                [&] { quadsplat::check(qs_lists, scene_.get(), &camera_, nullptr, &lists); }),
            std::string("qs_lists: ") + kPinhole);
  EXPECT_EQ(test::sentence_of([&] { scene_.count_modes(camera_); }),
            std::string("qs_count_modes: ") + kPinhole);
  EXPECT_EQ(test::sentence_of([&] {
              scene_.measure(camera_, {{1, 1}});
            }),
            std::string("qs_measure: ") + kPinhole);
  test::set_model(camera_, "EQUIRECTANGULAR", {40, 20});
  camera_.height = 20;
  EXPECT_EQ(test::sentence_of([&] { quadsplat::check(qs_camera_resize, &camera_, 50, 20); }),
            "qs_camera_resize: camera: a panorama of 50 x 20 pixels is not twice as wide as high");
  EXPECT_EQ(camera_.width, 40);
}

TEST_F(LibraryRefusals, of_settings) {
  const struct {
    std::function<void()> spoil;
    const char* sentence;
  } cases[] = {
      {[&] { settings_.pipeline = 2; }, "pipeline: is 2"},
      {[&] { settings_.antialiased = 3; }, "antialiased: is 3"},
      {[&] { settings_.sh_degree = -1; }, "sh_degree: -1 is not between 0 and 3"},
      {[&] { settings_.sh_degree = 4; }, "sh_degree: 4 is not between 0 and 3"},
      {[&] { settings_.tile_px = 0; }, "tile_px: 0 is not 8, 16 or 32"},
      {[&] { settings_.splat_scale = 0; }, "splat_scale: 0 is not between 1e-06 and 1e+06"},
      {[&] { settings_.splat_scale = static_cast<float>(kNaN); },
       "splat_scale: nan is not between 1e-06 and 1e+06"},
      {[&] { settings_.dilation_px2 = -1; }, "dilation_px2: -1 is not between 0 and 1e+06"},
      {[&] { settings_.background[2] = static_cast<float>(kNaN); }, "background: is not finite"},
      {[&] { settings_.reserved = 9; }, "reserved: is not 0"},
      {[&] { settings_.cull = "quad"; },
       "cull: 'quad' is none of reference, 3dgs, adr, dualbox, quadbox-naive, quadbox, exact, "
       "snugbox, accutile, flashgs, stopthepop, faster-gs"},
      {[&] { settings_.size = 0; },
       "size: is 0: set it to the size of the struct, 56 bytes in this library"},
  };
  for (const auto& one : cases) {
    EXPECT_EQ(rendering(one.spoil), std::string("qs_render: settings.") + one.sentence);
  }
  EXPECT_EQ(rendering([&] { settings_.cull = "reference"; }),
            "qs_render: pictures[0]: mode reference has no tile lists, so pairs and used must be "
            "absent");
}

TEST_F(LibraryRefusals, of_pictures) {
  static float other[4];
  const struct {
    std::function<void()> spoil;
    const char* sentence;
  } cases[] = {
      {[&] { picture_.color.sizes[0] = 40; },
       "color: has 40 x 40 x 3 elements instead of 30 x 40 x 3"},
      {[&] { picture_.color.sizes[2] = 4; },
       "color: has 30 x 40 x 4 elements instead of 30 x 40 x 3"},
      {[&] { picture_.color.dimensions = 2; }, "color: has 2 dimensions instead of 3"},
      {[&] { picture_.color.dimensions = 7; }, "color: has 7 dimensions instead of 3"},
      {[&] { picture_.alpha.sizes[1] = -1; }, "alpha: its size of dimension 1 is -1"},
      {[&] { picture_.alpha.data = nullptr; }, "alpha: its data is null"},
      {[&] { picture_.depth.data = reinterpret_cast<char*>(other) + 2; },
       "depth: its data is not aligned to its elements of 4 bytes"},
      {[&] { picture_.depth.type = QS_UINT8; },
       "depth: has elements of type uint8 instead of float32"},
      {[&] { picture_.color.type = QS_FLOAT64; },
       "color: has elements of type float64 instead of float32 or uint8"},
      {[&] { picture_.pairs.type = QS_FLOAT32; },
       "pairs: has elements of type float32 instead of int32 or uint32 or int64 or uint64"},
      {[&] { picture_.color.type = 7; }, "color: its type 7 is unknown"},
      {[&] { picture_.color.memory = QS_MEMORY_CUDA; },
       "alpha: is in host memory, but color is in the memory of GPU 0"},
      {[&] { picture_.pairs.memory = QS_MEMORY_CUDA; },
       "pairs: is in the memory of a GPU, but this array must be in host memory"},
      {[&] { picture_.color.memory = 2; }, "color: its memory 2 is unknown"},
      {[&] { picture_.color.strides[1] = 0; },
       "color: its stride of dimension 1 is 0, so that elements would be overwritten"},
      {[&] { picture_.color.strides[0] = std::int64_t{1} << 62; },
       "color: its sizes and strides reach beyond 64 bits"},
      {[&] { picture_.color.strides[0] = std::numeric_limits<std::int64_t>::min(); },
       "color: its sizes and strides reach beyond 64 bits"},
      {[&] { picture_.used.sizes[0] = 3; }, "used: has 3 x 3 elements instead of 2 x 3"},
      {[&] { picture_.reserved = 1; }, "reserved: is not 0"},
  };
  for (const auto& one : cases)
    EXPECT_EQ(rendering(one.spoil), std::string("qs_render: pictures[0].") + one.sentence);
  QsCounts counts{};
  EXPECT_EQ(rendering([&] { picture_.counts = &counts; }),
            "qs_render: pictures[0].size: is 0: set it to the size of the struct, 120 bytes in "
            "this library");
}

TEST_F(LibraryRefusals, write_nothing_even_into_the_views_before) {
  std::vector<QsCamera> cameras = {camera_, camera_};
  cameras[1].width = 0;
  std::fill(results_.color.begin(), results_.color.end(), 8.0f);
  const std::vector<QsPicture> pictures = {picture_, picture_};
  EXPECT_EQ(test::sentence_of([&] { scene_.render(cameras, pictures); }),
            "qs_render: cameras[1].width: 0 pixels are not between 1 and 65535");
  EXPECT_EQ(results_.color, std::vector<float>(results_.color.size(), 8.0f));
}

TEST_F(LibraryRefusals, of_gaussians) {
  EXPECT_EQ(wrapping([](QsGaussians&) {}), "");
  const struct {
    std::function<void(QsGaussians&)> spoil;
    const char* sentence;
  } cases[] = {
      {[](QsGaussians& g) { g.is_activated = 2; }, "is_activated: is 2"},
      {[](QsGaussians& g) { g.colors_are = 2; }, "colors_are: is 2"},
      {[](QsGaussians& g) { g.antialiased = 2; }, "antialiased: is 2"},
      {[](QsGaussians& g) { g.means = {}; }, "means: is absent: it needs 2 dimensions"},
      {[](QsGaussians& g) { g.means.sizes[0] = -5; }, "means: its size of dimension 0 is -5"},
      {[](QsGaussians& g) { g.means.sizes[0] = std::int64_t{1} << 31; },
       "means: 2147483648 Gaussians are more than 2147483647"},
      {[](QsGaussians& g) { g.means.sizes[1] = 2; }, "means: has 5 x 2 elements instead of 5 x 3"},
      {[](QsGaussians& g) { g.scales.sizes[0] = 4; },
       "scales: has 4 x 3 elements instead of 5 x 3"},
      {[](QsGaussians& g) { g.rotations.sizes[1] = 3; },
       "rotations: has 5 x 3 elements instead of 5 x 4"},
      {[](QsGaussians& g) { g.opacities.dimensions = 2; },
       "opacities: has 2 dimensions instead of 1"},
      {[](QsGaussians& g) { g.opacities.type = QS_UINT8; },
       "opacities: has elements of type uint8 instead of float32 or float64"},
      {[](QsGaussians& g) { g.colors.sizes[1] = 5; },
       "colors: 5 coefficients of spherical harmonics are not 1, 4, 9 or 16"},
      {[](QsGaussians& g) { g.colors.sizes[2] = 1; },
       "colors: has 5 x 4 x 1 elements instead of 5 x 4 x 3"},
      {[](QsGaussians& g) { g.colors_are = QS_COLORS_RGB; },
       "colors: has 3 dimensions instead of 2"},
      {[](QsGaussians& g) { g.rest = g.colors; },
       "colors: has 4 coefficients instead of the DC alone"},
      {[](QsGaussians& g) {
         g.colors_are = QS_COLORS_RGB;
         g.rest = g.colors;
       },
       "rest: belongs to spherical harmonics, but the colours are RGB"},
      {[](QsGaussians& g) { g.means.memory = QS_MEMORY_CUDA; },
       "scales: is in host memory, but means is in the memory of GPU 0"},
      {[](QsGaussians& g) { g.size = 543; },
       "size: is 543: set it to the size of the struct, 552 bytes in this library"},
  };
  for (const auto& one : cases)
    EXPECT_EQ(wrapping(one.spoil), std::string("qs_scene_wrap: gaussians.") + one.sentence);
}

TEST_F(LibraryRefusals, of_conversions) {
  const auto converting = [&](const std::function<void(QsConversion&)>& spoil) {
    QsConversion conversion = QS_CONVERSION;
    spoil(conversion);
    return test::sentence_of([&] { scene_.convert("never_written.ply", conversion); });
  };
  EXPECT_EQ(converting([](QsConversion& c) { c.overwrite = 2; }),
            "qs_convert: conversion.overwrite: is 2");
  EXPECT_EQ(converting([](QsConversion& c) { c.sh_degree = 4; }),
            "qs_convert: conversion.sh_degree: 4 is not between 0 and 3");
  EXPECT_EQ(converting([](QsConversion& c) { c.reserved = 1; }),
            "qs_convert: conversion.reserved: is not 0");
  EXPECT_EQ(converting([](QsConversion& c) { c.reserved2 = 1; }),
            "qs_convert: conversion.reserved2: is not 0");
  EXPECT_EQ(converting([](QsConversion& c) { c.drops_floaters = 2; }),
            "qs_convert: conversion.drops_floaters: is 2");
  EXPECT_EQ(converting([](QsConversion& c) { c.crop_low[1] = 1; }),
            "qs_convert: conversion.crop_low: 1 is not at most crop_high 0 and finite");
  EXPECT_EQ(converting([](QsConversion& c) { c.crop_high[2] = static_cast<float>(kNaN); }),
            "qs_convert: conversion.crop_low: 0 is not at most crop_high nan and finite");
  EXPECT_EQ(converting([](QsConversion& c) {
              for (int axis = 0; axis < 3; ++axis) c.crop_low[axis] = c.crop_high[axis] = 1e9f;
            }),
            "qs_convert: conversion: leaves out all 5 Gaussians");
  EXPECT_EQ(converting([](QsConversion& c) { c.format = "obj"; }),
            "never_written.ply: cannot write 'obj'; writable are: compressed.ply, ply, spz, "
            "spz-v4, splat, sog, glb, usda, usdz");
  EXPECT_FALSE(std::filesystem::exists("never_written.ply"));
}

TEST_F(LibraryRefusals, of_comparisons) {
  std::vector<float> values(12 * 9 * 3);
  std::vector<std::uint8_t> mask(12 * 9);
  const auto comparing = [&](const std::function<void(QsArray&, QsArray&, QsComparison&)>& spoil) {
    QsArray a = quadsplat::array_of(values.data(), {9, 12, 3}), b = a;
    auto comparison = quadsplat::sized<QsComparison>();
    comparison.metrics = QS_METRIC_SSIM;
    comparison.ssim = -5;
    spoil(a, b, comparison);
    const std::string sentence = test::sentence_of(
        [&] { quadsplat::check(qs_compare, context_.get(), &a, &b, &comparison); });
    EXPECT_EQ(comparison.ssim == -5, !sentence.empty());
    return sentence;
  };
  EXPECT_EQ(comparing([](QsArray&, QsArray&, QsComparison&) {}), "");
  EXPECT_EQ(comparing([](QsArray& a, QsArray&, QsComparison&) { a.sizes[0] = 0; }),
            "qs_compare: a: has no pixel: it is 12 x 0");
  EXPECT_EQ(comparing([](QsArray& a, QsArray&, QsComparison&) {
              a.sizes[0] = a.sizes[1] = std::int64_t{1} << 40;
            }),
            "qs_compare: a: 1099511627776 x 1099511627776 pixels are too many");
  EXPECT_EQ(comparing([](QsArray&, QsArray& b, QsComparison&) { b.sizes[0] = 8; }),
            "qs_compare: b: has 8 x 12 x 3 elements instead of 9 x 12 x 3");
  EXPECT_EQ(comparing([](QsArray& a, QsArray&, QsComparison&) { a.sizes[2] = 1; }),
            "qs_compare: a: has 9 x 12 x 1 elements instead of 9 x 12 x 3");
  EXPECT_EQ(comparing([](QsArray& a, QsArray&, QsComparison&) { a.dimensions = 0; }),
            "qs_compare: a: is absent: it needs 3 dimensions");
  EXPECT_EQ(comparing([](QsArray&, QsArray&, QsComparison& c) { c.metrics = 0; }),
            "qs_compare: comparison.metrics: 0 is no sum of QS_METRIC_...");
  EXPECT_EQ(comparing([](QsArray&, QsArray&, QsComparison& c) { c.metrics = 64; }),
            "qs_compare: comparison.metrics: 64 is no sum of QS_METRIC_...");
  EXPECT_EQ(comparing([](QsArray&, QsArray&, QsComparison& c) { c.ssim_border = 2; }),
            "qs_compare: comparison.ssim_border: is 2");
  EXPECT_EQ(comparing([](QsArray&, QsArray&, QsComparison& c) { c.ssim_border = QS_BORDER_CROP; }),
            "qs_compare: comparison.ssim_border: QS_BORDER_CROP needs 11 pixels along each side, "
            "not 12 x 9");
  EXPECT_EQ(comparing([&](QsArray&, QsArray&, QsComparison& c) {
              c.metrics = QS_METRIC_FLIP;
              c.mask = quadsplat::array_of(mask.data(), {9, 12});
            }),
            "qs_compare: comparison.mask: belongs to QS_METRIC_PSNR and QS_METRIC_SSIM alone");
}

TEST_F(LibraryRefusals, of_messages_that_are_too_long_are_cut_between_characters) {
  std::string path;
  while (path.size() < 300) path += "\u00e9";
  char message[QS_MESSAGE_BYTES + 1];
  std::memset(message, 'x', sizeof(message));
  QsSceneHandle* scene = nullptr;
  EXPECT_EQ(qs_scene_load(context_.get(), path.c_str(), nullptr, &scene, message), QS_INPUT);
  EXPECT_EQ(message[QS_MESSAGE_BYTES], 'x');
  EXPECT_EQ(std::string(message), path.substr(0, 254));
}

TEST_F(LibraryRefusals, leave_an_empty_message_after_success) {
  char message[QS_MESSAGE_BYTES] = "old";
  EXPECT_EQ(qs_render(scene_.get(), &camera_, 1, nullptr, &picture_, message), QS_OK);
  EXPECT_STREQ(message, "");
}

}  // namespace
}  // namespace qs
