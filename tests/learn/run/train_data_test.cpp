// SPDX-License-Identifier: MIT
// Data sets to train from: the photographs that are read, their sizes, and refused data.
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "learn/run/data_set.h"
#include "learn/run/trainer.h"
#include "raster/scene/place.h"
#include "support/error_of.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::train {
namespace {

using test::error_of;
using testing::ElementsAre;
using testing::HasSubstr;

class TrainData : public testing::Test {
 protected:
  // Ten cameras of 40 x 30 pixels, photographs of all but "b", in gray levels of their number.
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "images");
    std::vector<Camera> cameras;
    for (int i = 9; i >= 0; --i) {
      Camera camera = test::front_camera(40, 30);
      camera.view_from_world[3].x = i;
      camera.name = std::string(1, static_cast<char>('a' + i));
      if (i != 1) write_photograph(camera.name, 40, 30, static_cast<float>(i) / 10);
      cameras.push_back(camera);
    }
    test::write_cameras(cameras, folder_ / "cameras.json");
    options_.data = folder_.path();
  }
  void write_photograph(const std::string& name, int width, int height, float value) {
    Image image(width, height, 3);
    std::fill(image.values.begin(), image.values.end(), value);
    write_image(image, folder_ / "images" / (name + ".pfm"));
  }
  DataSet read() const { return read_data_set(options_, test::pool()); }
  std::string error() const {
    return error_of([this] { read(); }, folder_.path());
  }
  static std::vector<std::string> names(const std::vector<PhotographView>& views) {
    std::vector<std::string> result;
    for (const PhotographView& view : views) result.push_back(view.camera.name);
    return result;
  }

  TemporaryFolder folder_;
  DataOptions options_;
};

TEST_F(TrainData, every_nth_photograph_by_name_is_a_test_view) {
  options_.holdout = 4;
  const DataSet data = read();
  EXPECT_THAT(names(data.test), ElementsAre("a", "f", "j"));
  EXPECT_THAT(names(data.training), ElementsAre("c", "d", "e", "g", "h", "i"));
  EXPECT_EQ(test::without_folder(data.used, folder_.path()),
            "9 of 10 cameras in cameras.json (pinhole), photographs in images, no masks");
  EXPECT_EQ(data.left_out, "left out: 1 camera without a photograph (b)");
  EXPECT_EQ(data.training[1].rgb[0], 77) << "0.3 of 255";
  EXPECT_NEAR(data.training[1].photograph().over({})[7].y, 0.3, 0.002);
  EXPECT_EQ(data.cameras().size(), 9u);
  EXPECT_EQ(data.cameras()[1].camera.name, "c");
  options_.holdout = 0;
  EXPECT_TRUE(read().test.empty());
  EXPECT_EQ(read().training.size(), 9u);
}

TEST_F(TrainData, cameras_follow_the_size_of_the_photographs) {
  options_.resolution_scale = 2;
  const DataSet data = read();
  const Camera full = test::front_camera(40, 30);
  for (const PhotographView& view : data.training) {
    EXPECT_EQ(view.camera.width, 20);
    EXPECT_EQ(view.camera.height, 15);
    EXPECT_EQ(view.rgb.size(), 20u * 15 * 3);
    EXPECT_DOUBLE_EQ(view.camera.focal_px.x, full.focal_px.x / 2);
    EXPECT_DOUBLE_EQ(view.camera.center_px.y, 7);  // the middle stays the middle
  }
}

TEST_F(TrainData, scaled_cameras_see_the_same_rays) {
  Camera camera = test::front_camera(41, 31);
  camera.center_px = {3, 25};
  const Camera half = LensCamera{camera, {}, {}}.scaled(20, 16).camera;
  // The image's corners, in pixels from the corner, have the same slopes.
  for (const double side : {0.0, 1.0}) {
    EXPECT_NEAR((side * 41 - 0.5 - camera.center_px.x) / camera.focal_px.x,
                (side * 20 - 0.5 - half.center_px.x) / half.focal_px.x, 1e-12);
    EXPECT_NEAR((side * 31 - 0.5 - camera.center_px.y) / camera.focal_px.y,
                (side * 16 - 0.5 - half.center_px.y) / half.focal_px.y, 1e-12);
  }
}

TEST_F(TrainData, wide_photographs_are_reduced_unless_a_scale_is_given) {
  std::filesystem::remove_all(folder_ / "images");
  std::filesystem::create_directories(folder_ / "images");
  for (const char* name : {"a", "c"}) write_photograph(name, 2000, 1500, 0.5f);
  EXPECT_EQ(read().test[0].camera.width, 1600);
  EXPECT_EQ(read().test[0].camera.height, 1200);
  options_.resolution_scale = 1;
  EXPECT_EQ(read().test[0].camera.width, 2000);
}

TEST_F(TrainData, transparent_photographs_are_blended_over_the_background) {
  Image image(40, 30, 4);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      image.at(x, y, 0) = 1;
      image.at(x, y, 3) = 0.25f;
    }
  }
  std::filesystem::remove(folder_ / "images/a.pfm");
  write_image(image, folder_ / "images/a.png");
  options_.background = {0, 0, 1};
  const DataSet data = read();
  EXPECT_THAT(std::vector(data.test[0].rgb.begin(), data.test[0].rgb.begin() + 3),
              ElementsAre(64, 0, 191));
}

TEST_F(TrainData, alpha_can_be_kept_to_blend_over_another_background_in_every_iteration) {
  Image image(40, 30, 4);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      image.at(x, y, 1) = 0.6f;
      image.at(x, y, 3) = x < 20 ? 1.0f : 0.2f;
    }
  }
  std::filesystem::remove(folder_ / "images/c.pfm");
  write_image(image, folder_ / "images/c.png");
  options_.keep_alpha = true;
  const DataSet data = read();
  EXPECT_TRUE(data.training[1].alpha.empty()) << "an opaque photograph";
  const auto target = data.training[0].photograph().over({1, 0.5f, 0});
  EXPECT_NEAR(target[3].x, 0, 0.003);
  EXPECT_NEAR(target[3].y, 0.6, 0.003);
  EXPECT_NEAR(target[33].x, 0.8, 0.003);
  EXPECT_NEAR(target[33].y, 0.2 * 0.6 + 0.8 * 0.5, 0.003);
}

class TrainMasks : public TrainData {
 protected:
  // Black but for the columns from `first` on.
  void write_mask(const std::string& name, int first, int width = 40, int height = 30) {
    Image mask(width, height, 1);
    for (int y = 0; y < height; ++y) {
      for (int x = first; x < width; ++x) mask.at(x, y, 0) = 1.0f / 255;
    }
    std::filesystem::create_directories((folder_ / name).parent_path());
    write_image(mask, folder_ / name);
  }
  static std::vector<int> counted_of_row(const PhotographView& view) {
    return {view.mask.begin(), view.mask.begin() + view.camera.width};
  }
};

TEST_F(TrainMasks, are_named_as_the_photograph_with_or_without_its_ending) {
  write_mask("masks/c.pfm.png", 10);
  write_mask("masks/d.png", 20);
  write_mask("masks/e.png", 0);
  const DataSet data = read();
  EXPECT_THAT(data.used, HasSubstr("masks of 3 of 9 photographs in " + folder_.path().string() +
                                   "/masks, the others count as a whole"));
  ASSERT_EQ(data.training[0].mask.size(), 1200u);
  EXPECT_EQ(data.training[0].mask[30 * 40 - 31], 0);
  EXPECT_EQ(data.training[0].mask[30 * 40 - 30], 1);
  EXPECT_EQ(data.training[1].mask[19], 0);
  EXPECT_EQ(data.training[1].mask[20], 1);
  EXPECT_TRUE(data.training[2].mask.empty()) << "every pixel of e counts";
  EXPECT_TRUE(data.training[3].mask.empty()) << "f has no mask";
  EXPECT_NE(data.fingerprint(), [this] {
    std::filesystem::remove(folder_ / "masks/d.png");
    return read().fingerprint();
  }());
}

TEST_F(TrainMasks, transparent_pixels_are_masked_out) {
  Image mask(40, 30, 4);
  std::fill(mask.values.begin(), mask.values.end(), 1.0f);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 10; ++x) mask.at(x, y, 3) = 0;
  std::filesystem::create_directories(folder_ / "masks");
  write_image(mask, folder_ / "masks/c.png");
  EXPECT_THAT(counted_of_row(read().training[0])[9], 0);
  EXPECT_THAT(counted_of_row(read().training[0])[10], 1);
}

TEST_F(TrainMasks, of_another_folder_are_named_by_an_option) {
  write_mask("masks/c.png", 10);
  write_mask("covers/c.png", 20);
  options_.masks = "covers";
  EXPECT_EQ(read().training[0].mask[15], 0);
}

TEST_F(TrainMasks, reduced_pixels_count_only_as_a_whole) {
  write_mask("masks/c.png", 5);
  options_.resolution_scale = 4;
  EXPECT_THAT(counted_of_row(read().training[0]), ElementsAre(0, 0, 1, 1, 1, 1, 1, 1, 1, 1));
}

TEST_F(TrainMasks, that_do_not_fit_are_refused) {
  write_mask("masks/c.png", 5, 20, 15);
  EXPECT_EQ(error(),
            "masks/c.png: a mask of 20 x 15 pixels, but its photograph images/c.pfm has "
            "40 x 30");
  options_.masks = "nothing";
  EXPECT_EQ(error(), "nothing: not a folder of pictures");
  write_mask("covers/z.png", 1);
  options_.masks = "covers";
  EXPECT_EQ(error(), "covers: holds no mask named like one of the photographs of images");
  options_.masks.clear();
  std::filesystem::remove_all(folder_ / "masks");
  write_mask("masks/z.png", 1);
  EXPECT_THAT(read().used, HasSubstr("masks has none that is named like a photograph"));
}

TEST_F(TrainMasks, that_are_black_everywhere_leave_their_photographs_out) {
  const DataSet whole = read();
  for (const char* name : {"d", "i"}) write_mask(fmt::format("masks/{}.png", name), 40);
  const DataSet data = read();
  EXPECT_EQ(names(data.test), names(whole.test)) << "the views of eval --holdout";
  EXPECT_THAT(names(data.training), ElementsAre("c", "e", "f", "g", "h"));
  EXPECT_EQ(test::without_folder(data.used, folder_.path()),
            "7 of 10 cameras in cameras.json (pinhole), photographs in images, masks of 2 of 9 "
            "photographs in masks, the others count as a whole");
  EXPECT_EQ(data.left_out,
            "left out: 1 camera without a photograph (b), 2 photographs without a pixel that "
            "counts");
  ASSERT_EQ(data.warnings.size(), 1u);
  EXPECT_EQ(test::without_folder(data.warnings[0], folder_.path()),
            "masks/d.png: masks out every pixel of images/d.pfm; such photographs are left out");
  for (char name = 'a'; name <= 'j'; ++name) write_mask(fmt::format("masks/{}.png", name), 40);
  EXPECT_EQ(error(),
            "masks/a.png: masks out every pixel of images/a.pfm; such photographs are left out, "
            "and no other is left to train from");
}

// transforms.json with frames of `TrainData`'s photographs, and what it has besides.
class TrainTransforms : public TrainMasks {
 protected:
  void SetUp() override {
    TrainMasks::SetUp();
    std::filesystem::remove(folder_ / "cameras.json");
    options_.holdout = 0;
    for (const char name : {'a', 'c', 'd'})
      file_["frames"].push_back(
          {{"file_path", std::string("images/") + name + ".pfm"},
           {"transform_matrix",
            {{1, 0, 0, name - 'a'}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}}}});
  }
  DataSet read_file() const {
    std::ofstream(folder_ / "transforms.json") << file_;
    return read();
  }
  std::string error_of_file() const {
    std::ofstream(folder_ / "transforms.json") << file_;
    return error();
  }
  std::string used() const { return test::without_folder(read_file().used, folder_.path()); }
  std::vector<std::string> warnings() const {
    std::vector<std::string> result;
    for (const std::string& sentence : read_file().warnings)
      result.push_back(test::without_folder(sentence, folder_.path()));
    return result;
  }

  nlohmann::json file_ = {{"w", 40}, {"h", 30}, {"fl_x", 40}};
};

TEST_F(TrainTransforms, masks_are_those_that_the_file_names) {
  EXPECT_EQ(used(), "3 of 3 cameras in transforms.json (pinhole), photographs in images, no masks");
  write_mask("covers/one.png", 10);
  file_["frames"][1]["mask_path"] = "covers/one.png";
  DataSet data = read_file();
  EXPECT_THAT(data.used, HasSubstr("masks of 1 of 3 photographs as transforms.json names them, the "
                                   "others count as a whole"));
  EXPECT_EQ(data.training[1].mask[9], 0);
  EXPECT_EQ(data.training[1].mask[10], 1);
  EXPECT_TRUE(data.training[0].mask.empty());
  // All frames may share one.
  for (auto& frame : file_["frames"]) frame["mask_path"] = "./covers\\one.png";
  EXPECT_THAT(used(), HasSubstr("3 masks as transforms.json names them"));
  // A folder that the user names counts more.
  write_mask("masks/c.png", 20);
  EXPECT_THAT(used(), HasSubstr("3 masks as transforms.json names them"));
  options_.masks = "masks";
  data = read_file();
  EXPECT_EQ(data.training[1].mask[19], 0);
  EXPECT_TRUE(data.training[0].mask.empty());
  options_.masks.clear();
  std::filesystem::remove(folder_ / "covers/one.png");
  std::filesystem::remove(folder_ / "masks/c.png");
  EXPECT_THAT(error_of_file(),
              HasSubstr("transforms.json: none of the masks that it names exists, such as "));
}

TEST_F(TrainTransforms, points_are_those_that_the_file_names) {
  const auto write_points = [&](const std::string& name, int count) {
    std::ofstream file(folder_ / name);
    file << "ply\nformat ascii 1.0\nelement vertex " << count
         << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    for (int i = 0; i < count; ++i) file << i / 2 << " 0 0\n";
  };
  EXPECT_TRUE(read_file().points.empty());
  write_points("points3d.ply", 2);
  EXPECT_EQ(read_file().points.size(), 1u) << "two at one place";
  EXPECT_EQ(read_file().repeated_points, 1u);
  write_points("cloud.ply", 8);
  file_["ply_file_path"] = "cloud.ply";
  const DataSet data = read_file();
  EXPECT_EQ(data.points.size(), 4u);
  EXPECT_EQ(data.points_file, folder_ / "cloud.ply");
  file_["ply_file_path"] = "missing.ply";
  EXPECT_THAT(
      warnings(),
      testing::Contains("transforms.json: there is no file of points missing.ply, which it names"));
  EXPECT_EQ(read_file().points.size(), 1u);
}

TEST_F(TrainTransforms, masks_and_depth_maps_are_no_photographs) {
  write_mask("masks/a.png", 10);
  std::filesystem::create_directories(folder_ / "depth");
  std::filesystem::rename(folder_ / "images/c.pfm", folder_ / "depth/c.pfm");
  std::filesystem::rename(folder_ / "images/a.pfm", folder_ / "a.pfm");
  std::filesystem::rename(folder_ / "images/d.pfm", folder_ / "d.pfm");
  std::filesystem::remove_all(folder_ / "images");
  const DataSet data = read_file();
  EXPECT_THAT(names(data.training), ElementsAre("a", "d"));
  EXPECT_THAT(data.used, HasSubstr("2 of 3 cameras"));
  EXPECT_FALSE(data.training[0].mask.empty());
}

TEST_F(TrainTransforms, absolute_paths_have_masks_and_leave_nothing_out) {
  write_mask("masks/c.png", 10);
  for (auto& frame : file_["frames"])
    frame["file_path"] = (folder_ / frame["file_path"].get<std::string>()).string();
  const DataSet data = read_file();
  EXPECT_THAT(data.used, HasSubstr("masks of 1 of 3 photographs"));
  EXPECT_THAT(data.left_out, HasSubstr("6 photographs without a camera (e.pfm"));
}

TEST_F(TrainTransforms, a_file_stands_for_its_data_set) {
  write_mask("masks/c.png", 10);
  std::ofstream(folder_ / "points3d.ply")
      << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         "property float z\nend_header\n0 0 0\n";
  const DataSet whole = read_file();
  options_.data = folder_ / "transforms.json";
  const DataSet data = read();
  EXPECT_EQ(data.used, whole.used);
  EXPECT_EQ(data.points.size(), 1u);
  EXPECT_EQ(data.fingerprint(), whole.fingerprint());
}

TEST_F(TrainData, the_folder_of_a_colmap_model_stands_for_its_data_set) {
  std::filesystem::create_directories(folder_ / "sparse/0");
  std::ofstream(folder_ / "sparse/0/cameras.txt") << "1 PINHOLE 40 30 50 50 20 15\n";
  std::ofstream(folder_ / "sparse/0/images.txt")
      << "1 1 0 0 0 0 0 0 1 a.pfm\n\n2 1 0 0 0 1 0 0 1 c.pfm\n\n3 1 0 0 0 2 0 0 1 d.pfm\n\n";
  std::ofstream(folder_ / "points3D.txt") << "1 0 0 4 1 2 3 0\n";
  std::filesystem::remove(folder_ / "cameras.json");
  const DataSet whole = read();
  for (const char* given : {"sparse", "sparse/", "sparse/0", "sparse/0/", "sparse/0/images.txt"}) {
    options_.data = folder_ / given;
    const DataSet data = read();
    EXPECT_EQ(data.fingerprint(), whole.fingerprint()) << given;
    EXPECT_EQ(data.used, whole.used) << given;
    EXPECT_EQ(data.points_file, whole.points_file) << given;
    ASSERT_EQ(data.warnings.size(), whole.warnings.size() + 1) << given;
    EXPECT_THAT(data.warnings[0], HasSubstr("a COLMAP model without photographs; its data set is " +
                                            folder_.path().string()))
        << given;
  }
  options_.data = folder_ / "sparse/0";
  options_.images = "images";
  EXPECT_EQ(read().fingerprint(), whole.fingerprint());
  options_.images = "../../images";
  EXPECT_EQ(read().fingerprint(), whole.fingerprint());
  options_.images.clear();
  std::filesystem::rename(folder_ / "images", folder_ / "sparse/0/images");
  EXPECT_EQ(read().fingerprint(), whole.fingerprint()) << "photographs beside the model";
}

TEST_F(TrainTransforms, photographs_of_other_folders_than_named_are_told) {
  for (auto& frame : file_["frames"]) {
    std::string path = frame["file_path"];
    frame["file_path"] = "cam0/" + path.substr(7);
  }
  EXPECT_THAT(warnings(), ElementsAre("3 photographs found by the file's name alone (cam0/a.pfm is "
                                      "images/a.pfm, cam0/c.pfm is images/c.pfm, cam0/d.pfm is "
                                      "images/d.pfm)"));
}

TEST_F(TrainTransforms, cameras_that_see_no_point_are_told) {
  std::ofstream(folder_ / "points3d.ply")
      << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         "property float z\nend_header\n1000 0 0\n";
  EXPECT_THAT(
      warnings(),
      ElementsAre("points3d.ply: no point of it is seen by 3 of 3 training cameras: they and the "
                  "points are of different frames, or focal lengths or axes are wrong"));
}

TEST_F(TrainTransforms, points_far_from_the_origin_are_not_merged) {
  std::ofstream points(folder_ / "points3d.ply");
  points << "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
            "property double z\nend_header\n";
  for (const char* x : {"5000000.01", "5000000.02", "5000000.02"}) points << x << " 0 0\n";
  points.close();
  for (auto& frame : file_["frames"]) frame["transform_matrix"][0][3] = 5000000.0;
  const DataSet data = read_file();
  EXPECT_EQ(data.points.size(), 2u);
  EXPECT_EQ(data.repeated_points, 1u);
}

TEST_F(TrainTransforms, cameras_and_photographs_that_are_left_out_are_named) {
  file_["frames"].push_back(file_["frames"][0]);
  file_["frames"][3]["file_path"] = "images/z.pfm";
  EXPECT_EQ(used(), "3 of 4 cameras in transforms.json (pinhole), photographs in images, no masks");
  EXPECT_EQ(
      read_file().left_out,
      "left out: 1 camera without a photograph (images/z.pfm), 6 photographs without a camera "
      "(e.pfm, f.pfm, g.pfm, ..)");
  file_["frames"][3] = file_["frames"][0];
  EXPECT_THAT(error_of_file(), HasSubstr("images/a.pfm: one picture for two cameras, both named "
                                         "images/a.pfm"));
  file_["frames"].erase(3);
  file_["frames"][1]["fl_x"] = "NaN";
  EXPECT_THAT(warnings(), ElementsAre("transforms.json: frame 1: fl_x is NaN (images/c.pfm); this "
                                      "camera is left out"));
  EXPECT_EQ(read_file().training.size(), 2u);
}

TEST_F(TrainData, blender_s_files_name_training_and_test_views) {
  std::filesystem::remove_all(folder_ / "images");
  std::filesystem::remove(folder_ / "cameras.json");
  for (const std::string set : {"train", "test"}) {
    std::filesystem::create_directories(folder_ / set);
    std::ofstream file(folder_ / ("transforms_" + set + ".json"));
    file << R"({"camera_angle_x": 0.7, "frames": [)";
    for (int i = 0; i < 2; ++i) {
      Image image(20, 20, 3);
      std::fill(image.values.begin(), image.values.end(), set == "train" ? 0.2f : 0.8f);
      write_image(image, folder_ / set / ("r_" + std::to_string(i) + ".png"));
      file << (i > 0 ? "," : "") << R"({"file_path": "./)" << set << "/r_" << i
           << R"(", "transform_matrix": [[1,0,0,)" << i << R"(],[0,1,0,0],[0,0,1,4],[0,0,0,1]]})";
    }
    file << "]}";
  }
  const DataSet data = read();
  EXPECT_THAT(names(data.training), ElementsAre("train/r_0", "train/r_1"));
  EXPECT_THAT(names(data.test), ElementsAre("test/r_0", "test/r_1"));
  EXPECT_EQ(data.training[1].rgb[0], 51);
  EXPECT_EQ(data.test[1].rgb[0], 204);
}

TEST_F(TrainData, photographs_of_lenses_that_distort_are_undistorted) {
  LensCamera camera = lens_camera(
      {find_lens_model("OPENCV"), {40, 30}, {35, 35}, {20, 14}, {-0.1, 0.05, 0, 0}}, "test");
  camera.camera.name = "a";
  std::ofstream(folder_ / "cameras.json") << format_cameras({camera});
  Image ramp(40, 30, 3);  // the value is the column, so it identifies the source of a pixel
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      for (int c = 0; c < 3; ++c) ramp.at(x, y, c) = static_cast<float>(5 * x) / 255;
    }
  }
  write_image(ramp, folder_ / "images/a.pfm");
  options_.holdout = 0;
  const PhotographView view = read().training.front();
  for (const auto& [x, y] : {std::pair{20, 14}, {3, 4}, {36, 27}}) {
    const glm::dvec2 slope = (glm::dvec2(x, y) - camera.camera.center_px) / camera.camera.focal_px;
    const double column = camera.lens->project({slope, 1}).value().x;
    EXPECT_NEAR(view.rgb[static_cast<std::size_t>(3 * (40 * y + x))], 5 * column, 0.51);
  }
  EXPECT_EQ(view.camera.focal_px, camera.camera.focal_px);
  options_.resolution_scale = 2;
  const PhotographView half = read().training.front();
  ASSERT_TRUE(half.lens);
  EXPECT_DOUBLE_EQ(half.lens->focal_px.x, 17.5);
  EXPECT_DOUBLE_EQ(half.lens->center_px.x, 9.75);
}

// Three photographs of 40 x 40 pixels, a fisheye of 180 degrees from side to side.
class TrainWide : public TrainData {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "images");
    nlohmann::json file = {{"w", 40},
                           {"h", 40},
                           {"fl_x", 12.73},
                           {"is_fisheye", true},
                           {"frames", nlohmann::json::array()}};
    for (int i = 0; i < 3; ++i) {
      const std::string name(1, static_cast<char>('a' + i));
      write_photograph(name, 40, 40, static_cast<float>(i) / 5);
      file["frames"].push_back(
          {{"file_path", "images/" + name + ".pfm"},
           {"transform_matrix", {{1, 0, 0, i}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}}}});
    }
    std::ofstream(folder_ / "transforms.json") << file;
    options_.data = folder_.path();
    options_.holdout = 3;
  }
};

const auto counted_share = [](const PhotographView& view) {
  return view.mask.empty() ? 1.0
                           : static_cast<double>(std::ranges::count(view.mask, 1)) /
                                 static_cast<double>(view.mask.size());
};

TEST_F(TrainWide, photographs_are_divided_into_faces_and_held_out_as_a_whole) {
  const DataSet data = read();
  EXPECT_THAT(names(data.test), ElementsAre("a_front", "a_right", "a_left", "a_up", "a_down"));
  ASSERT_EQ(data.training.size(), 10u);
  EXPECT_EQ(names(data.training)[5], "c_front");
  EXPECT_EQ(test::without_folder(data.used, folder_.path()),
            "3 of 3 cameras in transforms.json (OPENCV_FISHEYE, 5 faces each, 100 % of a "
            "photograph used), photographs in images, no masks");
  for (const PhotographView& view : data.training) {
    SCOPED_TRACE(view.camera.name);
    EXPECT_EQ(view.camera.width, 29) << "2 x 12.73 tan 48 degrees";
    EXPECT_NEAR(counted_share(view), view.lens->face == "front" ? 1.0 : 0.565, 0.001)
        << "from tests/golden/lenses.py";
    const int value = view.camera.name[0] == 'b' ? 51 : 102;
    for (std::size_t i = 0; i < view.rgb.size(); ++i)
      if (view.mask.empty() || view.mask[i / 3] != 0) {
        EXPECT_EQ(view.rgb[i], value) << i;
      }
  }
  EXPECT_EQ(run_facts_of(data, Pace()).views, 10u);
  EXPECT_EQ(run_facts_of(data, Pace()).pixels, 2u * 40 * 40) << "of photographs, not of faces";
  // Left is the side to which x falls.
  const Camera& left = data.training[2].camera;
  EXPECT_NEAR((left.view_from_world * glm::dvec4(-99, 0, 4, 1)).z, 100, 1e-9);
}

TEST_F(TrainWide, masks_and_sizes_of_photographs_hold_for_their_faces) {
  std::filesystem::create_directories(folder_ / "masks");
  Image mask(40, 40, 1);  // the left half is masked out
  for (int y = 0; y < 40; ++y)
    for (int x = 20; x < 40; ++x) mask.at(x, y, 0) = 1;
  write_image(mask, folder_ / "masks/b.png");
  options_.resolution_scale = 2;
  const DataSet data = read();
  EXPECT_THAT(data.used, HasSubstr("masks of 1 of 3 photographs"));
  ASSERT_EQ(data.training.size(), 9u) << "nothing of b_left counts";
  EXPECT_EQ(data.training[0].camera.width, 15);
  // Pixel 16 of 29 is the first that no masked pixel reaches by cubics: 12.73 atan(2 / 13.06)
  // + 19.5 is above 21. Of 15 columns, column 9 is the first without an earlier pixel.
  EXPECT_NEAR(counted_share(data.training[0]), 6.0 / 15, 1e-9);
  EXPECT_EQ(names(data.training)[2], "b_up");
  EXPECT_NEAR(data.training[0].lens->size_px.x, 20, 0.7);
  write_photograph("c", 40, 30, 0);
  EXPECT_EQ(error(),
            "images/c.pfm: 40 x 30 pixels do not have the aspect ratio of its camera, "
            "40 x 40");
}

TEST_F(TrainWide, a_masked_pixel_masks_all_pixels_that_are_interpolated_from_it) {
  std::filesystem::create_directories(folder_ / "masks");
  Image mask(40, 40, 1);
  std::ranges::fill(mask.values, 1.0f);
  mask.at(22, 17, 0) = 0;
  write_image(mask, folder_ / "masks/b.png");
  const DataSet data = read();
  const PhotographView& front = data.training[0];
  ASSERT_EQ(front.camera.name, "b_front");
  ASSERT_FALSE(front.mask.empty());
  const LensCamera camera{front.camera, front.lens};
  for (std::size_t i = 0; i < front.mask.size(); ++i) {
    const glm::dvec2 source = camera.source_of({i % 29, i / 29}).value();
    const bool is_used = std::abs(source.x - 22) < 2 && std::abs(source.y - 17) < 2;
    EXPECT_EQ(front.mask[i], is_used ? 0 : 1) << i;
  }
}

TEST_F(TrainWide, faces_are_read_again_from_cameras_json) {
  const DataSet data = read();
  std::ofstream(folder_ / "cameras.json") << format_cameras(data.cameras());
  const DataSet again = read();
  EXPECT_EQ(again.test.size(), 5u);
  EXPECT_EQ(again.training.size(), 10u);
  EXPECT_THAT(again.used, HasSubstr("(faces of OPENCV_FISHEYE)"));
  std::uint64_t first = 0, second = 0;
  for (const PhotographView& view : data.training) first += view.content_hash();
  for (const PhotographView& view : again.training) second += view.content_hash();
  EXPECT_EQ(first, second) << "the same pixels and masks";
}

TEST_F(TrainData, extent_is_a_tenth_more_than_the_largest_distance_from_the_middle) {
  options_.holdout = 0;  // at x = 0, -2, -3, ..., -9
  const double mean = -44.0 / 9;
  EXPECT_NEAR(read().extent(), -1.1 * mean, 1e-9);
  EXPECT_EQ(extent_of({test::front_camera(4, 4)}), 1) << "a single camera";
}

// Cameras at equal distances on a line, one of them elsewhere.
std::vector<Camera> line_with(double stray, int count) {
  std::vector<Camera> cameras(static_cast<std::size_t>(count), test::front_camera(4, 4));
  for (int i = 0; i < count; ++i) cameras[static_cast<std::size_t>(i)].view_from_world[3].x = -i;
  cameras[1].view_from_world[3] = {0, -stray, 0};
  return cameras;
}

TEST(Outliers, a_camera_far_from_all_others_does_not_count) {
  for (const double stray : {400.0, 5e3, -5e3, 1e6, 1e12}) {
    const std::vector<Camera> cameras = line_with(stray, 30);
    EXPECT_THAT(outliers(cameras), ElementsAre(1));
    EXPECT_LT(extent_of(without_outliers(cameras)), 20);
    EXPECT_GT(extent_of(cameras), std::abs(stray));
  }
  for (const double near : {0.0, 10.0, 60.0}) {
    const std::vector<Camera> cameras = line_with(near, 30);
    EXPECT_THAT(outliers(cameras), testing::IsEmpty());
    EXPECT_EQ(extent_of(without_outliers(cameras)), extent_of(cameras));
  }
  // Several do not count either, but many are a second place.
  struct Row {
    int count;
    std::size_t far;
    bool do_count;
  };
  for (const Row& row : {Row{14, 2, false}, Row{14, 3, false}, Row{14, 4, true}, Row{10, 2, false},
                         Row{10, 3, true}, Row{4, 1, false}, Row{4, 2, true}, Row{30, 3, false},
                         Row{30, 8, true}, Row{200, 40, false}, Row{200, 60, true}}) {
    std::vector<Camera> cameras = line_with(0, row.count);
    for (std::size_t i = 0; i < row.far; ++i)
      cameras[2 * i].view_from_world[3].y = 1e5 * static_cast<double>(1 + i);
    EXPECT_EQ(outliers(cameras).size(), row.do_count ? 0 : row.far) << row.count << ' ' << row.far;
    EXPECT_EQ(extent_of(without_outliers(cameras)) > 1000, row.do_count) << row.count;
  }
  // One camera is no outlier.
  EXPECT_THAT(outliers({test::front_camera(4, 4)}), testing::IsEmpty());
  EXPECT_THAT(outliers({}), testing::IsEmpty());
}

TEST_F(TrainData, georeferenced_cameras_count_from_an_origin) {
  const glm::dvec3 place(500123.4, 4650012.7, 230);
  std::vector<LensCamera> cameras = read_camera_set(options_.data).cameras;
  const std::vector<PhotographView> before = read().training;
  for (LensCamera& taken : cameras)
    taken.camera.view_from_world[3] -= glm::dmat3(taken.camera.view_from_world) * place;
  test::write_cameras(pinhole_cameras(cameras), folder_ / "cameras.json");
  const DataSet moved = read();
  EXPECT_EQ(moved.origin, glm::dvec3(500120, 4650010, 230));
  for (std::size_t i = 0; i < before.size(); ++i) {
    const glm::dvec3 world = moved.origin + moved.training[i].camera.position();
    const glm::dvec3 expected = place + before[i].camera.position();
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(world[axis], expected[axis], 1e-6);
  }
}

TEST_F(TrainData, bad_data_is_refused_with_the_name_of_the_file) {
  write_photograph("c", 40, 40, 0.5f);
  EXPECT_EQ(error(),
            "images/c.pfm: 40 x 40 pixels do not have the aspect ratio of its camera, 40 x 30");
  write_photograph("c", 40, 30, NAN);
  EXPECT_EQ(error(), "images/c.pfm: holds values that are not finite numbers");
  std::ofstream(folder_ / "images/c.pfm") << "PF\n0 0\n-1\n";
  EXPECT_THAT(error(), HasSubstr("images/c.pfm: "));
  options_.images = "photos";
  EXPECT_EQ(error(), "photos: not a folder of pictures");
  std::filesystem::create_directories(folder_ / "photos");
  EXPECT_EQ(
      error(),
      "photos: holds no photograph named like one of the 10 cameras of cameras.json, such as a; "
      "it has no picture: name the folder with --images");
  write_image(Image(40, 30, 3), folder_ / "photos/x.png");
  EXPECT_THAT(error(), HasSubstr("such as a; it has x.png: name the folder"));
  options_.images = "images";
  std::filesystem::remove(folder_ / "images/c.pfm");
  options_.holdout = 1;
  EXPECT_EQ(error(),
            "images: all 8 photographs are test views: use --holdout 0 to train from them");
  options_.data = folder_ / "nothing";
  EXPECT_EQ(error(), "nothing: cannot be read: no such file");
}

TEST_F(TrainData, fingerprint_notices_another_pixel_or_camera) {
  const std::string before = read().fingerprint();
  EXPECT_EQ(read().fingerprint(), before);
  write_photograph("d", 40, 30, 0.31f);
  EXPECT_NE(read().fingerprint(), before);
}

}  // namespace
}  // namespace qs::train
