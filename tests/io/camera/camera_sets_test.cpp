// SPDX-License-Identifier: MIT
// Files of cameras as programs really write them: layouts, texts, lenses, numbers that are not
// finite, and the sentences about them.
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class CameraSets : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& content) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  void write_model(const std::string& folder, int images) const {
    std::string text;
    for (int i = 0; i < images; ++i) text += fmt::format("{} 1 0 0 0 {} 0 0 1 {}.jpg\n\n", i, i, i);
    write(folder + "/images.txt", text);
    write(folder + "/cameras.txt", "1 PINHOLE 20 10 50 50 10 5\n");
  }
  CameraSet read(const std::string& name = "") const { return read_camera_set(folder_ / name); }
  std::string error(const std::string& name = "transforms.json") const {
    return test::error_of([&] { read(name); }, folder_.path());
  }
  std::vector<std::string> sentences(const CameraSet& set) const {
    std::vector<std::string> result;
    for (const std::string& sentence : set.sentences())
      result.push_back(test::without_folder(sentence, folder_.path()));
    return result;
  }
  // Two frames.
  static json transforms() {
    json file = {{"w", 20}, {"h", 10}, {"fl_x", 50}, {"frames", json::array()}};
    for (int i = 0; i < 2; ++i)
      file["frames"].push_back(
          {{"file_path", fmt::format("images/{}.jpg", i)},
           {"transform_matrix", {{1, 0, 0, i}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}});
    return file;
  }
  std::string error_with(const char* pointer, const json& value) const {
    json file = transforms();
    file[json::json_pointer(pointer)] = value;
    write("transforms.json", file.dump());
    return error();
  }

  TemporaryFolder folder_;
};

TEST_F(CameraSets, colmap_models_are_found_in_every_layout) {
  for (const char* layout :
       {".", "sparse", "sparse/0", "0", "1", "sparse/1", "sparse/best", "sparse/00"}) {
    std::filesystem::remove_all(folder_ / "set");
    write_model(std::string("set/") + layout, 3);
    const CameraSet set = read("set");
    EXPECT_EQ(set.cameras.size(), 3u) << layout;
    EXPECT_THAT(set.sentences(), IsEmpty()) << layout;
  }
  std::filesystem::remove_all(folder_ / "set");
  write_model("set/dense/0", 3);
  EXPECT_THAT(error("set"), HasSubstr("a folder without cameras.json, COLMAP's images.bin"));
}

TEST_F(CameraSets, the_largest_of_several_models_is_read_and_the_others_are_named) {
  write_model("sparse/0", 2);
  write_model("sparse/1", 5);
  write_model("sparse/2", 5);
  const CameraSet set = read();
  EXPECT_EQ(set.cameras.size(), 5u);
  EXPECT_THAT(sentences(set),
              ElementsAre("sparse/1 is the largest of 3 COLMAP models, with 5 photographs, and "
                          "only it is used: sparse/0 has 2, sparse/2 has 5"));
  EXPECT_EQ(find_cameras_file(folder_ / "point_cloud.ply"), folder_ / "sparse/1/images.txt");
  EXPECT_EQ(read("sparse/0").cameras.size(), 2u) << "a model that is named is read";
  EXPECT_THAT(read("sparse/0").sentences(), IsEmpty());
}

TEST_F(CameraSets, the_first_of_several_formats_is_read_and_the_others_are_named) {
  write_model("sparse/0", 2);
  write("transforms.json", transforms().dump());
  EXPECT_THAT(sentences(read()), ElementsAre("transforms.json: is not used, because there is "
                                             "sparse/0/images.txt"));
  EXPECT_THAT(read("transforms.json").sentences(), IsEmpty());
}

TEST_F(CameraSets, byte_order_marks_are_skipped) {
  const std::string mark = "\xef\xbb\xbf";
  write("transforms.json", mark + transforms().dump());
  EXPECT_EQ(read("transforms.json").cameras.size(), 2u);
  write("a/cameras.json", mark + R"([{"img_name": "a", "width": 20, "height": 10, "fx": 5, "fy": 5,
      "position": [0, 0, 0], "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}])");
  EXPECT_EQ(read("a").cameras.size(), 1u);
  write("b/cameras.txt", mark + "1 PINHOLE 20 10 50 50 10 5\r\n");
  write("b/images.txt", mark + "1 1 0 0 0 0 0 0 1 a.jpg\r\n\r\n");
  EXPECT_EQ(read("b").cameras.size(), 1u);
}

TEST_F(CameraSets, frames_that_are_not_finite_are_left_out_and_named) {
  const char* const words[] = {"NaN", "Infinity", "-Infinity", "nan", "-inf", "1e999"};
  for (const char* word : words) {
    for (const char* key : {"fl_x", "cx", "k1", "transform_matrix"}) {
      json file = transforms();
      if (std::string_view(key) == "transform_matrix")
        file["frames"][1][key][2][3] = 12345;
      else
        file["frames"][1][key] = 12345;
      std::string text = file.dump();
      text.replace(text.find("12345"), 5, word);
      write("transforms.json", text);
      if (std::string_view(word) == "1e999") {
        EXPECT_THAT(error(), HasSubstr("transforms.json: not valid JSON")) << key;
        continue;
      }
      const CameraSet set = read("transforms.json");
      ASSERT_EQ(set.cameras.size(), 1u) << word << key;
      EXPECT_EQ(set.cameras[0].camera.name, "0");
      EXPECT_THAT(sentences(set),
                  ElementsAre(fmt::format("transforms.json: frame 1: {} is {} (images/1.jpg); this "
                                          "camera is left out",
                                          key, word)));
    }
  }
  // Texts stay texts, and a key for all frames leaves none.
  json file = transforms();
  file["frames"][0]["file_path"] = "images/NaN.jpg";
  write("transforms.json", file.dump());
  EXPECT_EQ(read("transforms.json").cameras[0].camera.name, "NaN");
  std::string text = transforms().dump();
  text.replace(text.find("50"), 2, "NaN");
  write("transforms.json", text);
  EXPECT_THAT(error(), HasSubstr("transforms.json: frame 0: fl_x is NaN (images/0.jpg)"));
}

TEST_F(CameraSets, many_cameras_that_are_left_out_are_counted) {
  json file = transforms();
  for (int i = 2; i < 12; ++i) {
    file["frames"].push_back(file["frames"][1]);
    file["frames"].back()["fl_x"] = "NaN";
  }
  write("transforms.json", file.dump());
  const auto all = sentences(read("transforms.json"));
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[3],
            "transforms.json: 10 cameras in all are left out, because their numbers are not "
            "finite");
}

TEST_F(CameraSets, lenses_that_are_not_known_are_refused_and_others_read) {
  struct Row {
    const char* key;
    json value;
    const char* sentence;  // "" if it is read
  };
  const Row rows[] = {
      {"is_fisheye", true, ""},
      {"is_fisheye", 1, ""},
      {"is_fisheye", "true", ""},
      {"is_fisheye", false, ""},
      {"is_fisheye", 0, ""},
      {"is_fisheye", "false", ""},
      {"is_fisheye", nullptr, ""},
      {"ftheta_p0", 0.1, "ftheta_p0 is 0.1: no lens that is known; undistort the photographs"},
      {"ortho", true, "ortho is true: no lens that is known"},
      {"latlong", true, ""},
      {"equirectangular", true, ""},
      {"distortion_params", {0, 0, 0.1, 0, 0, 0}, "distortion_params is"},
      {"distortion_params", {0, 0, 0, 0, 0, 0}, ""},
      {"k1", 0.01, ""},
      {"k3", 0, ""},
      {"k3", 0.01, ""},
      {"k4", -0.01, "k4 is -0.01, which a lens OPENCV does not have; undistort the photographs"},
      {"k5", 0.01, "k5 is 0.01"},
      {"k6", 0.01, "k6 is 0.01"},
      {"s1", 0.01, "s1 is 0.01"},
      {"camera_model", "OPENCV", ""},
      {"camera_model", "PINHOLE", ""},
      {"camera_model", "SIMPLE_RADIAL", ""},
      {"camera_model", "PERSPECTIVE", ""},
      {"camera_model", "pinhole", ""},
      {"camera_model", "FULL_OPENCV", ""},
      {"camera_model", "OPENCV_FISHEYE", ""},
      {"camera_model", "RAD_TAN_THIN_PRISM_FISHEYE", ""},
      {"camera_model", "FISHEYE624", ""},
      {"camera_model", "SIMPLE_DIVISION", ""},
      {"camera_model", "FOV", "omega is 0, but must be between 0 and pi"},
      {"camera_model", "EQUIRECTANGULAR", ""},
      {"w", 30, ""},
      {"camera_model", "ORTHOPHOTO", "camera_model ORTHOPHOTO is no lens that is known"},
      {"camera_model", "VR180_L", "camera_model VR180_L is no lens that is known"},
      {"camera_model", "", "camera_model  is no lens that is known"},
      {"camera_model", 4, "camera_model is not a string"},
  };
  for (const Row& row : rows) {
    for (const char* place : {"/", "/frames/1/"}) {
      const std::string pointer = std::string(place) + row.key;
      const std::string message = error_with(pointer.c_str(), row.value);
      if (std::string_view(row.sentence).empty())
        EXPECT_EQ(message, "") << pointer << row.value;
      else
        EXPECT_THAT(message, HasSubstr(row.sentence)) << pointer << row.value;
    }
  }
}

TEST_F(CameraSets, keys_of_lenses_that_contradict_each_other_are_refused) {
  struct Row {
    json keys;
    const char* model;     // "": it is refused
    const char* sentence;  // of the refusal
  };
  const json params = {0.01, 0, 0, 0, 0, 0, 0.001, 0, 0, 0, 0, 0};
  const Row rows[] = {
      {{{"is_fisheye", true}}, "OPENCV_FISHEYE", ""},
      {{{"is_fisheye", true}, {"k1", 0.01}, {"k4", 0.001}}, "OPENCV_FISHEYE", ""},
      {{{"is_fisheye", true}, {"camera_model", "OPENCV_FISHEYE"}}, "OPENCV_FISHEYE", ""},
      {{{"is_fisheye", true}, {"camera_model", "EUCM"}, {"alpha", 0.5}, {"beta", 1}}, "EUCM", ""},
      {{{"is_fisheye", true}, {"camera_model", "OPENCV"}},
       "",
       "is_fisheye is true, but its lens is OPENCV"},
      {{{"is_fisheye", true}, {"latlong", true}},
       "",
       "latlong is true, but its lens is OPENCV_FISHEYE"},
      {{{"is_fisheye", true}, {"p1", 0.01}}, "", "p1 is 0.01, which a lens OPENCV_FISHEYE"},
      {{{"latlong", true}}, "EQUIRECTANGULAR", ""},
      {{{"camera_model", "EQUIRECTANGULAR"}}, "EQUIRECTANGULAR", ""},
      {{{"latlong", true}, {"w", 30}},
       "",
       "frame 0: a panorama of 30 x 10 pixels is not twice as wide as high"},
      {{{"k1", 0.01}, {"p2", 0.001}}, "OPENCV", ""},
      {{{"k1", 0.01}, {"k3", 0.001}}, "FULL_OPENCV", ""},
      {{{"k1", 0.01}, {"k3", 0.001}, {"k4", 0.01}}, "", "k4 is 0.01, but a lens with k3 has it as"},
      {{{"camera_model", "FULL_OPENCV"}, {"k1", 0.01}, {"k4", 0.01}}, "FULL_OPENCV", ""},
      {{{"camera_model", "METASHAPE"}, {"k1", 0.01}, {"k4", 0.01}}, "METASHAPE", ""},
      {{{"camera_model", "FISHEYE624"}, {"distortion_params", params}}, "FISHEYE624", ""},
      {{{"camera_model", "OPENCV"}, {"distortion_params", params}}, "", "for FISHEYE624 alone"},
  };
  for (const Row& row : rows) {
    json file = transforms();
    file.update(row.keys);
    write("transforms.json", file.dump());
    if (std::string_view(row.model).empty()) {
      EXPECT_THAT(error("transforms.json"), HasSubstr(row.sentence)) << row.keys;
      continue;
    }
    const auto cameras = read("transforms.json").cameras;
    ASSERT_TRUE(cameras[0].lens) << row.keys;
    EXPECT_EQ(cameras[0].lens->model->name, row.model) << row.keys;
  }
}

TEST_F(CameraSets, data_that_is_not_used_is_named) {
  json file = transforms();
  file["train_filenames"] = {"images/0.jpg"};
  file["frames"][1]["depth_file_path"] = "depth/1.png";
  file["fisheye_crop_radius"] = 707.5;
  write("transforms.json", file.dump());
  EXPECT_THAT(sentences(read("transforms.json")),
              ElementsAre("transforms.json: train_filenames is not used",
                          "transforms.json: depth_file_path is not used",
                          "transforms.json: fisheye_crop_radius is not used"));
}

TEST_F(CameraSets, odd_numbers_are_told_and_wrong_ones_refused) {
  EXPECT_EQ(error_with("/cx", 10), "");
  EXPECT_THAT(read("transforms.json").sentences(), IsEmpty());
  EXPECT_EQ(error_with("/cx", 0.5), "");
  EXPECT_THAT(sentences(read("transforms.json")),
              ElementsAre(HasSubstr("the principal points of 2 cameras are far from the middle")));
  EXPECT_EQ(error_with("/fl_x", 0.3), "");
  EXPECT_THAT(sentences(read("transforms.json")),
              ElementsAre(HasSubstr("the focal lengths of 2 cameras are less than a fiftieth")));
  EXPECT_EQ(error_with("/frames/1/transform_matrix/3", {1, 2, 3, 1}),
            "transforms.json: frame 1: the last row of transform_matrix is not 0, 0, 0, 1: is it "
            "transposed?");
  write_model("m", 1);
  write("m/cameras.txt", "1 PINHOLE 20 10 50 50 10 5 0.1 0 0 0\n");
  EXPECT_EQ(error("m"), "m/cameras.txt: line 1: more parameters than the camera model has");
  write("deep/set/transforms.json", transforms().dump());
  EXPECT_THAT(error("deep"), HasSubstr("; deep/set/transforms.json is one, further below"));
  write("points.las", "LASF");
  std::vector<std::string> warnings;
  EXPECT_EQ(test::error_of([&] { read_points(folder_ / "points.las", warnings); }, folder_.path()),
            "points.las: points are read from .ply, .bin and .txt");
}

TEST_F(CameraSets, frames_have_their_own_intrinsics_masks_and_names) {
  json file = transforms();
  file["frames"][1]["fl_x"] = 70;
  file["frames"][1]["w"] = 40;
  file["frames"][1]["h"] = 30;
  file["frames"][1]["mask_path"] = "masks/b.png";
  file["frames"][1]["file_path"] = "./images\\deep/b.JPG";
  file["ply_file_path"] = "points.ply";
  write("transforms.json", file.dump());
  const CameraSet set = read("transforms.json");
  EXPECT_EQ(set.points, "points.ply");
  EXPECT_EQ(set.cameras[0].camera.focal_px.x, 50);
  EXPECT_EQ(set.cameras[1].camera.focal_px.x, 70);
  EXPECT_EQ(set.cameras[1].camera.width, 40);
  EXPECT_EQ(set.cameras[0].mask, "");
  EXPECT_EQ(set.cameras[1].mask, "masks/b.png");
  EXPECT_EQ(set.cameras[0].camera.name, "0");
  EXPECT_EQ(set.cameras[1].camera.name, "deep/b");
  EXPECT_EQ(set.cameras[1].photograph, "./images\\deep/b.JPG");
}

TEST_F(CameraSets, blender_s_photograph_may_have_any_ending) {
  json file = transforms();
  file.erase("w");
  file.erase("h");
  for (int i = 0; i < 2; ++i) file["frames"][i]["file_path"] = fmt::format("./train/r_{}", i);
  for (const char* ending : {".png", ".PNG", ".ppm", ".pfm"}) {
    std::filesystem::remove_all(folder_ / "train");
    std::filesystem::create_directories(folder_ / "train");
    write_image(Image(20, 10, 3), folder_ / "train" / (std::string("r_0") + ending));
    write("transforms.json", file.dump());
    EXPECT_EQ(read("transforms.json").cameras[1].camera.width, 20) << ending;
  }
  std::filesystem::remove_all(folder_ / "train");
  EXPECT_THAT(error(), HasSubstr("frame 0: w and h are missing, and so is its photograph"));
}

// ---- points -------------------------------------------------------------------------------------
std::string ply_of(const std::string& properties, const std::string& rows, int count = 2) {
  return fmt::format("ply\nformat ascii 1.0\nelement vertex {}\n{}end_header\n{}", count,
                     properties, rows);
}

constexpr const char* kPlaces = "property float x\nproperty float y\nproperty double z\n";

TEST_F(CameraSets, points_of_a_ply_have_the_colours_of_its_program) {
  const std::string bytes = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  const std::string floats = "property float red\nproperty float green\nproperty float blue\n";
  const std::string shorts = "property ushort r\nproperty ushort g\nproperty ushort b\n";
  const std::string dc = "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n";
  struct Row {
    std::string properties, values;
    glm::vec3 color;  // of the second point
  };
  const Row rows[] = {
      {"", "", {0.5f, 0.5f, 0.5f}},
      {bytes, "0 51 255", {0, 0.2f, 1}},
      {floats, "0 0.2 1", {0, 0.2f, 1}},
      {floats, "0 51 255", {0, 0.2f, 1}},
      {shorts, "0 13107 65535", {0, 0.2f, 1}},
      {dc, "-1.7724539 -1.0634723 1.7724539", {0, 0.2f, 1}},
      {"property uchar red\n", "9", {0.5f, 0.5f, 0.5f}},
  };
  std::vector<std::string> warnings;
  for (const Row& row : rows) {
    write("points.ply",
          ply_of(kPlaces + row.properties, "1 2 3 " + row.values + "\n4 5 6 " + row.values + "\n"));
    const auto points = read_points(folder_ / "points.ply", warnings);
    EXPECT_THAT(warnings, IsEmpty());
    ASSERT_EQ(points.size(), 2u);
    EXPECT_EQ(points[1].position, glm::dvec3(4, 5, 6));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(points[1].color[c], row.color[c], 1e-6) << row.values;
  }
  const auto message = [&](const std::string& content) {
    write("points.ply", content);
    return test::error_of([&] { read_points(folder_ / "points.ply", warnings); }, folder_.path());
  };
  EXPECT_THAT(message("x"), HasSubstr("points.ply: not a .ply file of points"));
  EXPECT_THAT(message(ply_of("property float x\n", "1\n2\n")), HasSubstr("points.ply"));
  EXPECT_EQ(message(ply_of(kPlaces, "", 0)), "");
}

TEST_F(CameraSets, points_that_are_not_finite_are_left_out_and_counted) {
  const std::string colors = "property float red\nproperty float green\nproperty float blue\n";
  struct Row {
    const char* file;
    std::string content;
    std::size_t kept;
    const char* sentence;
  };
  const Row rows[] = {
      {"a.ply", ply_of(kPlaces, "1 2 3\n4 nan 6\n"), 1, "1 of 2 points left out"},
      {"a.ply", ply_of(kPlaces, "inf 2 3\n4 5 -inf\n"), 0, "2 of 2 points left out"},
      {"a.ply", ply_of(kPlaces, "1 2 3\n4 5 1e300\n"), 1, "1 of 2 points left out"},
      {"a.ply", ply_of(kPlaces + colors, "1 2 3 0 nan 0\n4 5 6 0 1 0\n"), 1,
       "1 of 2 points left out"},
      {"points3D.txt", "1 nan 0 0 1 2 3 0\n2 4 5 6 1 2 3 0\n3 0 0 -inf 1 2 3 0\n", 1,
       "2 of 3 points left out"},
  };
  for (const Row& row : rows) {
    write(row.file, row.content);
    std::vector<std::string> warnings;
    EXPECT_EQ(read_points(folder_ / row.file, warnings).size(), row.kept) << row.content;
    EXPECT_THAT(warnings, ElementsAre(HasSubstr(fmt::format(
                              "{}: {}, because numbers are not finite", row.file, row.sentence))));
  }
}

TEST_F(CameraSets, repeated_points_become_one) {
  const std::vector<ScenePoint> points = {
      {{1, 2, 3}, {0, 0, 0}}, {{4, 5, 6}, {1, 1, 1}}, {{1, 2, 3 + 1e-12}, {1, 0.5f, 0}}};
  const auto once = without_repetitions(points);
  ASSERT_EQ(once.size(), 2u);
  EXPECT_EQ(once[0].position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(once[0].color, glm::vec3(0.5f, 0.25f, 0));
  EXPECT_EQ(once[1].position, glm::dvec3(4, 5, 6));
  EXPECT_THAT(without_repetitions({}), IsEmpty());
}

TEST_F(CameraSets, points_belong_to_the_model_that_is_read) {
  write("sparse/0/points3D.txt", "");
  write("sparse/1/points3D.ply", "");
  write("points3d.ply", "");
  EXPECT_EQ(find_points_file(folder_ / "sparse/1", folder_.path()),
            folder_ / "sparse/1/points3D.ply");
  EXPECT_EQ(find_points_file(folder_ / "sparse/0", folder_.path()),
            folder_ / "sparse/0/points3D.txt");
  EXPECT_EQ(find_points_file(folder_ / "sparse/2", folder_.path()), folder_ / "points3d.ply");
}

// ---- EXIF ---------------------------------------------------------------------------------------
// A TIFF block with the tag Orientation.
std::string tiff_with(int orientation, bool big_endian) {
  const auto word = [&](int value, int size) {
    std::string bytes;
    for (int i = 0; i < size; ++i)
      bytes += static_cast<char>(value >> 8 * (big_endian ? size - 1 - i : i));
    return bytes;
  };
  return (big_endian ? "MM" : "II") + word(42, 2) + word(8, 4) + word(2, 2) + word(0x010f, 2) +
         word(2, 2) + word(1, 4) + word(0, 4) + word(0x0112, 2) + word(3, 2) + word(1, 4) +
         word(orientation, 2) + word(0, 2) + word(0, 4);
}

TEST_F(CameraSets, orientations_of_pictures_are_read_from_exif) {
  const auto read_from = [](const std::string& bytes) {
    return exif_orientation(std::as_bytes(std::span(bytes)));
  };
  for (const bool big_endian : {false, true}) {
    for (int orientation = 1; orientation <= 8; ++orientation) {
      const std::string exif = std::string("Exif\0\0", 6) + tiff_with(orientation, big_endian);
      const std::string other = std::string("\xff\xe0\0\x04xx", 6);
      const std::string size = {0, static_cast<char>(exif.size() + 2)};
      const std::string jpeg = "\xff\xd8" + other + "\xff\xe1" + size + exif + "\xff\xd9";
      EXPECT_EQ(read_from(jpeg), orientation);
      const std::string tiff = tiff_with(orientation, big_endian);
      const std::string length = {0, 0, 0, static_cast<char>(tiff.size())};
      EXPECT_EQ(read_from("\x89PNG\r\n\x1a\n" + length + "eXIf" + tiff + "crc."), orientation);
      // No cut-off block is read beyond its end.
      for (std::size_t end = 0; end < jpeg.size() - 8; ++end)
        EXPECT_THAT(read_from(jpeg.substr(0, end)), testing::AnyOf(1, orientation)) << end;
    }
  }
  EXPECT_EQ(read_from("\xff\xd8\xff\xe1"), 1);
  const std::string strange =
      std::string("\xff\xd8\xff\xe1\0\x24", 6) + std::string("Exif\0\0", 6) + tiff_with(9, false);
  EXPECT_EQ(read_from(strange), 1) << "there is no orientation 9";
}

}  // namespace
}  // namespace qs
