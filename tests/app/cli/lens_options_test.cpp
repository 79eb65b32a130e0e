// SPDX-License-Identifier: MIT
// --lens and its options in render, film and bench.
#include <fstream>
#include <iterator>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;
using testing::Not;

class LensOptionsTest : public testing::Test {
 protected:
  void SetUp() override {
    test::write_scene(test::surrounding_cloud(500, 1, 11), scene_);
    test::write_cameras({test::front_camera(64, 48)}, folder_ / "cameras.json");
  }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  ProgramRun run(const std::string& command, std::vector<std::string> options) const {
    options.insert(options.begin(), {command, scene_, "--backend", "cpu"});
    return run_quadsplat(options);
  }

  TemporaryFolder folder_;
  std::string scene_ = path("scene.ply");
};

TEST_F(LensOptionsTest, that_do_not_fit_together_are_usage_errors) {
  const struct {
    std::vector<std::string> options;
    const char* said;
  } cases[] = {
      {{"--lens", "fishy"}, "--lens: 'fishy' is none of pinhole, equirectangular"},
      {{"--fov", "180"}, "--fov is of --lens fisheye and equirectangular"},
      {{"--lens", "orthographic", "--height", "3", "--fov", "90"}, "--fov is of --lens fisheye"},
      {{"--lens", "equirectangular", "--fov", "200"}, "has a --fov of 180 or 360 degrees"},
      {{"--lens", "orthographic"}, "need each other"},
      {{"--lens", "fisheye", "--height", "2"}, "need each other"},
      {{"--level"}, "--level needs a --lens"},
      {{"--lens", "equirectangular", "--stereo", "over-under", "--eye-distance", "1"},
       "--stereo over-under needs --lens equirectangular --fov 180"},
      {{"--lens", "equirectangular", "--fov", "180", "--stereo", "over-under"},
       "--stereo over-under and --eye-distance UNITS need each other"},
      {{"--lens", "fisheye", "--eye-distance", "1"}, "need each other"},
      {{"--lens", "equirectangular", "--size", "64x48"},
       "is twice as wide as high: such as 2048x1024, but --size is 64x48"},
      {{"--lens", "equirectangular", "--fov", "180", "--size", "64x32"},
       "of 180 degrees is as wide as high: such as 1024x1024, but --size is 64x32"},
      {{"--lens", "equirectangular", "--fov", "180", "--stereo", "over-under", "--eye-distance",
        "1", "--size", "64x64"},
       "with two eyes is half as wide as high: such as 1024x2048, but --size is 64x64"},
      {{"--lens", "fisheye", "--occlusion", "on"}, "--occlusion on leaves out nothing"},
      {{"--lens", "OPENCV,64,48,50"}, "OPENCV needs WIDTH,HEIGHT and 8 parameters, but 3 numbers"},
      {{"--lens", "NONE,64,48,50"}, "there is no camera model 'NONE'"},
      {{"--lens", "SIMPLE_FISHEYE,64,48,x,1,1"}, "--lens: 'x' is not"},
  };
  for (const auto& [options, said] : cases) {
    SCOPED_TRACE(said);
    const ProgramRun bench = run("bench", options);
    EXPECT_EQ(bench.exit_code, 1);
    EXPECT_THAT(bench.err, HasSubstr(said));
    std::vector<std::string> with_output = options;
    with_output.insert(with_output.end(), {"--output", path("out.png")});
    const ProgramRun render = run("render", with_output);
    EXPECT_EQ(render.exit_code, 1);
    EXPECT_THAT(render.err, HasSubstr(said));
  }
  const ProgramRun heat =
      run("render", {"--lens", "fisheye", "--heatmap", "missed", "--output", path("out.png")});
  EXPECT_THAT(heat.err, HasSubstr("--heatmap missed compares the lists of one picture"));
  const ProgramRun film =
      run("film", {"--lens", "equirectangular", "--size", "30x10", "--output", path("film")});
  EXPECT_THAT(film.err, HasSubstr("film: --lens equirectangular is twice as wide as high"));
}

TEST_F(LensOptionsTest, of_lenses_with_impossible_numbers_name_them) {
  for (const auto& [lens, said] :
       {std::pair{"SIMPLE_FISHEYE,64,48,-5,1,1", "the focal length is not above 0"},
        {"FOV,64,48,50,50,1,1,7", "omega is 7"},
        {"SIMPLE_FISHEYE,0,48,5,1,1", "a picture of 0 x 48 pixels"},
        {"EQUIRECTANGULAR,64,40", "is not twice as wide as high"}}) {
    const ProgramRun render = run("render", {"--lens", lens, "--output", path("out.png")});
    EXPECT_NE(render.exit_code, 0);
    EXPECT_THAT(render.err, HasSubstr(said)) << lens;
  }
}

TEST_F(LensOptionsTest, make_pictures_of_every_lens) {
  const struct {
    std::vector<std::string> options;
    glm::ivec2 size;
    const char* text;
    bool is_panorama;
  } cases[] = {
      {{"--lens", "pinhole"}, {64, 48}, "", false},
      {{"--lens", "equirectangular", "--size", "64x32"},
       {64, 32},
       "lens equirectangular of 360 degrees (numbers are sums over its faces, 24 all round)",
       true},
      {{"--lens", "equirectangular", "--fov", "180", "--size", "32x32", "--level"},
       {32, 32},
       "lens equirectangular of 180 degrees, level",
       true},
      {{"--lens", "equirectangular", "--fov", "180", "--stereo", "over-under", "--eye-distance",
        "0.1", "--size", "32x64"},
       {32, 64},
       "for eyes 0.1 apart",
       false},
      {{"--lens", "fisheye", "--fov", "220"}, {64, 48}, "lens fisheye of 220 degrees", false},
      {{"--lens", "orthographic", "--height", "8", "--level"},
       {64, 48},
       "lens orthographic, 8 units high, level",
       false},
      {{"--lens", "OPENCV_FISHEYE,128,96,60,60,64,48,0.01,0,0,0"},
       {128, 96},
       "lens OPENCV_FISHEYE,128,96,60,60,64,48,0.01,0,0,0 (",
       false},
      {{"--lens", "OPENCV_FISHEYE,128,96,60,60,64,48,0.01,0,0,0", "--size", "64x48"},
       {64, 48},
       "lens OPENCV_FISHEYE",
       false},
      {{"--lens", "EQUIRECTANGULAR,128,64", "--size", "64x32"},
       {64, 32},
       "lens EQUIRECTANGULAR",
       false},
  };
  for (const auto& [given, size, text, is_panorama] : cases) {
    SCOPED_TRACE(text);
    std::vector<std::string> options = given;
    options.insert(options.end(), {"--output", path("out.png"), "--stats", path("stats.json")});
    const ProgramRun render = run("render", options);
    ASSERT_EQ(render.exit_code, 0) << render.err;
    EXPECT_THAT(render.err, HasSubstr(text));
    const Image image = read_image(path("out.png"));
    EXPECT_EQ(glm::ivec2(image.width, image.height), size);
    float most = 0;
    for (const float value : image.values) most = std::max(most, value);
    EXPECT_GT(most, 0.1f);
    EXPECT_EQ(test::content_of(path("out.png")).find("GPano") != std::string::npos, is_panorama);
    EXPECT_THAT(test::content_of(path("stats.json")), HasSubstr(text));
    options = given;
    options.insert(options.end(),
                   {"--picture", "depth", "--overwrite", "--output", path("depth.npy")});
    ASSERT_EQ(run("render", options).exit_code, 0);
    options = given;
    options.insert(options.end(), {"--cull", "quadbox", "--frames", "1", "--psnr"});
    const ProgramRun bench = run("bench", options);
    ASSERT_EQ(bench.exit_code, 0) << bench.err;
    EXPECT_THAT(bench.out, HasSubstr(text));
  }
}

TEST_F(LensOptionsTest, have_heat_maps_of_their_faces) {
  for (const char* quantity : {"pairs", "evaluated", "false-positive"}) {
    SCOPED_TRACE(quantity);
    const ProgramRun heat =
        run("render", {"--lens", "fisheye", "--fov", "220", "--size", "320x240", "--heatmap",
                       quantity, "--overwrite", "--output", path("heat.png")});
    ASSERT_EQ(heat.exit_code, 0) << heat.err;
    EXPECT_GT(read_image(path("heat.png")).height, 240) << "there is a legend";
  }
}

TEST_F(LensOptionsTest, are_those_of_the_chosen_camera_of_a_file) {
  std::ofstream(folder_ / "cameras.txt") << "1 SIMPLE_FISHEYE 60 60 19.1 30 30\n"
                                            "2 SIMPLE_FISHEYE 60 60 99 30 30\n";
  std::ofstream(folder_ / "images.txt") << "1 1 0 0 0 0 0 3 1 a.png\n\n2 1 0 0 0 0 0 3 2 b.png\n\n";
  const std::string lens = "SIMPLE_FISHEYE,60,60,19.1,30,30";
  const struct {
    std::vector<std::string> options;
    bool is_own;
  } cases[] = {
      {{"--camera-index", "0"}, true},  {{"--camera-index", "0", "--lens", "pinhole"}, false},
      {{"--camera-index", "1"}, false}, {{"--camera-index", "0,1"}, false},
      {{"--all-cameras"}, false},       {{}, false}};
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    SCOPED_TRACE(i);
    std::vector<std::string> options = {"--cameras", path("images.txt"), "--output",
                                        path(std::to_string(i) + ".pfm")};
    options.insert(options.end(), cases[i].options.begin(), cases[i].options.end());
    const ProgramRun render = run("render", options);
    ASSERT_EQ(render.exit_code, 0) << render.err;
    const auto says = HasSubstr("camera 0 (a) is drawn through its lens, --lens " + lens +
                                "; --lens pinhole draws its front face");
    if (cases[i].is_own)
      EXPECT_THAT(render.err, says);
    else
      EXPECT_THAT(render.err, Not(says));
  }
  ASSERT_EQ(run("render",
                {"--cameras", path("images.txt"), "--lens", lens, "--output", path("given.pfm")})
                .exit_code,
            0);
  EXPECT_EQ(test::content_of(path("0.pfm")), test::content_of(path("given.pfm")));
  EXPECT_NE(test::content_of(path("0.pfm")), test::content_of(path("1.pfm")));
}

TEST_F(LensOptionsTest, have_the_size_of_a_panorama_without_a_size) {
  const ProgramRun render =
      run("render", {"--lens", "equirectangular", "--output", path("out.png")});
  ASSERT_EQ(render.exit_code, 0) << render.err;
  EXPECT_EQ(read_image(path("out.png")).width, 2048);
  EXPECT_EQ(read_image(path("out.png")).height, 1024);
}

TEST_F(LensOptionsTest, make_films_whose_pictures_are_panoramas) {
  const ProgramRun film = run("film", {"--lens", "equirectangular", "--size", "64x32", "--seconds",
                                       "0.1", "--level", "--output", path("film")});
  ASSERT_EQ(film.exit_code, 0) << film.err;
  EXPECT_THAT(film.err, HasSubstr("lens equirectangular of 360 degrees, level"));
  EXPECT_THAT(test::content_of(path("film/frame_00001.png")), HasSubstr("GPano"));
  const ProgramRun gif = run("film", {"--lens", "equirectangular", "--size", "64x32", "--seconds",
                                      "0.1", "--output", path("film.gif")});
  if (gif.exit_code == 0) {  // with ffmpeg
    EXPECT_THAT(gif.err, HasSubstr("players do not show it as a panorama"));
  }
}

}  // namespace
}  // namespace qs
