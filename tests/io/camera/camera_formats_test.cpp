// SPDX-License-Identifier: MIT
// The bundled cameras, written as COLMAP text, COLMAP binary and transforms.json, and read back.
#include "io/camera/camera_formats.h"

#include <array>
#include <cmath>
#include <fstream>
#include <functional>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::vector<Camera> bundled() { return read_cameras(test::source_path("assets/cameras.json")); }

std::string error_of(const std::filesystem::path& path) {
  try {
    read_cameras(path);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    return error.what();
  }
  return "no error";
}

glm::dquat quaternion(const Camera& camera) {
  return glm::quat_cast(glm::dmat3(camera.view_from_world));
}

void write(const std::filesystem::path& path, const std::string& content) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << content;
}

std::string colmap_text_lenses(const std::vector<Camera>& cameras) {
  std::string text = "# Camera list\n";
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& c = cameras[i];
    text += fmt::format("{} PINHOLE {} {} {} {} {} {}\n", i + 1, c.width, c.height, c.focal_px.x,
                        c.focal_px.y, c.center_px.x + 0.5, c.center_px.y + 0.5);
  }
  return text;
}

std::string colmap_text_images(const std::vector<Camera>& cameras) {
  std::string text = "# Image list\r\n#   with two lines of data per image\n";
  for (std::size_t i = cameras.size();
       i-- > 0;) {  // in reverse order, because COLMAP guarantees none
    const Camera& c = cameras[i];
    const glm::dquat q = quaternion(c);
    const glm::dvec3 t = c.view_from_world[3];
    text += fmt::format("{} {} {} {} {} {} {} {} {} {}.jpg\n{}\n", i + 7, q.w, q.x, q.y, q.z, t.x,
                        t.y, t.z, i + 1, c.name, i % 2 == 0 ? "" : "1.5 2.5 -1 3 4 17");
  }
  return text;
}

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string colmap_binary_lenses(const std::vector<Camera>& cameras) {
  std::string bytes;
  put<std::uint64_t>(bytes, cameras.size());
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& c = cameras[i];
    put<std::uint32_t>(bytes, static_cast<std::uint32_t>(i + 1));
    put<std::int32_t>(bytes, 4);  // OPENCV that does not distort
    put<std::uint64_t>(bytes, static_cast<std::uint64_t>(c.width));
    put<std::uint64_t>(bytes, static_cast<std::uint64_t>(c.height));
    for (const double value : {c.focal_px.x, c.focal_px.y, c.center_px.x + 0.5, c.center_px.y + 0.5,
                               0.0, 1e-9, 0.0, 0.0})
      put(bytes, value);
  }
  return bytes;
}

std::string colmap_binary_images(const std::vector<Camera>& cameras) {
  std::string bytes;
  put<std::uint64_t>(bytes, cameras.size());
  for (std::size_t i = cameras.size(); i-- > 0;) {
    const Camera& c = cameras[i];
    put<std::uint32_t>(bytes, static_cast<std::uint32_t>(i + 7));
    const glm::dquat q = quaternion(c);
    const glm::dvec3 t = c.view_from_world[3];
    for (const double value : {q.w, q.x, q.y, q.z, t.x, t.y, t.z}) put(bytes, value);
    put<std::uint32_t>(bytes, static_cast<std::uint32_t>(i + 1));
    bytes += c.name + ".jpg" + '\0';
    put<std::uint64_t>(bytes, i % 3);
    bytes.append(24 * (i % 3), 'x');
  }
  return bytes;
}

json transforms(const std::vector<Camera>& cameras) {
  json frames = json::array();
  for (const Camera& c : cameras) {
    const glm::dmat3 world_from_view = glm::transpose(glm::dmat3(c.view_from_world));
    const glm::dvec3 position = c.position();
    json rows = json::array();
    for (int i = 0; i < 3; ++i)
      rows.push_back(
          {world_from_view[0][i], -world_from_view[1][i], -world_from_view[2][i], position[i]});
    rows.push_back({0, 0, 0, 1});
    frames.push_back({{"file_path", "./images/" + c.name + ".jpg"},
                      {"transform_matrix", rows},
                      {"fl_x", c.focal_px.x},
                      {"fl_y", c.focal_px.y},
                      {"cx", c.center_px.x + 0.5}});
  }
  return {{"w", cameras[0].width},
          {"h", cameras[0].height},
          {"cy", cameras[0].center_px.y + 0.5},
          {"fl_x", 1},
          {"k1", 0.0},
          {"frames", frames}};
}

// A chunk whose component is turned, moved and scaled.
std::string metashape_xml(const std::vector<Camera>& cameras) {
  const glm::dmat3 turn = glm::mat3_cast(glm::normalize(glm::dquat(0.5, 0.1, -0.7, 0.2)));
  const glm::dvec3 move(3, -1, 20);
  constexpr double kScale = 2.5;
  const auto rows = [](const glm::dmat3& m) {
    return fmt::format("{} {} {} {} {} {} {} {} {}", m[0][0], m[1][0], m[2][0], m[0][1], m[1][1],
                       m[2][1], m[0][2], m[1][2], m[2][2]);
  };
  std::string sensors, shots;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Camera& c = cameras[i];
    const glm::dvec2 middle = c.center_px - 0.5 * (glm::dvec2(c.width, c.height) - 1.0);
    const glm::dmat3 own = glm::transpose(turn) * glm::transpose(glm::dmat3(c.view_from_world));
    const glm::dvec3 place = glm::transpose(turn) * (c.position() - move) / kScale;
    sensors += fmt::format(
        "<sensor id=\"{0}\" type=\"frame\"><resolution width=\"{1}\" height=\"{2}\"/>"
        "<calibration class=\"initial\"><f>1</f></calibration>"
        "<calibration type='frame' class='adjusted'><resolution width=\"{1}\" height=\"{2}\"/>"
        "<f>{3}</f><b1>{4}</b1><cx>{5}</cx><cy>{6}</cy></calibration></sensor>\n",
        i, c.width, c.height, c.focal_px.y, c.focal_px.x - c.focal_px.y, middle.x, middle.y);
    shots += fmt::format(
        "<camera id=\"{0}\" sensor_id=\"{0}\" component_id=\"4\" label=\"{1}.jpg\">"
        "<transform>{2} {3} {4} {5}\n{6} {7} {8} {9} {10} {11} {12} {13} 0 0 0 1</transform>"
        "</camera>",
        i, c.name, own[0][0], own[1][0], own[2][0], place.x, own[0][1], own[1][1], own[2][1],
        place.y, own[0][2], own[1][2], own[2][2], place.z);
    if (i == 2) shots += "<group id=\"0\" label=\"the others\">";
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- cameras -->\n<document "
      "version=\"2.0.0\"><chunk label=\"A &amp; B\"><sensors>{}</sensors><components><component "
      "id=\"4\"><transform><rotation>{}</rotation><translation>{} {} {}</translation>"
      "<scale>{}</scale></transform></component></components><cameras>{}</group></cameras>"
      "</chunk></document>\n",
      sensors, rows(turn), move.x, move.y, move.z, kScale, shots);
}

void expect_same(const std::vector<Camera>& read, const std::vector<Camera>& expected) {
  ASSERT_EQ(read.size(), expected.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Camera &a = read[i], &b = expected[i];
    EXPECT_EQ(a.name, b.name);
    for (int column = 0; column < 4; ++column)
      EXPECT_LT(glm::distance(a.view_from_world[column], b.view_from_world[column]), 1e-4) << i;
    EXPECT_LT(glm::distance(a.position(), b.position()), 1e-4) << i;
    EXPECT_LT(glm::distance(a.focal_px, b.focal_px), 1e-4) << i;
    EXPECT_LT(glm::distance(a.center_px, b.center_px), 1e-4) << i;
    EXPECT_EQ(glm::ivec2(a.width, a.height), glm::ivec2(b.width, b.height));
  }
}

TEST(CameraFormats, give_one_pose_for_one_image) {
  const std::vector<Camera> cameras = bundled();
  const TemporaryFolder folder;
  write(folder / "text/sparse/0/cameras.txt", colmap_text_lenses(cameras));
  write(folder / "text/sparse/0/images.txt", colmap_text_images(cameras));
  write(folder / "binary/sparse/0/cameras.bin", colmap_binary_lenses(cameras));
  write(folder / "binary/sparse/0/images.bin", colmap_binary_images(cameras));
  write(folder / "nerf/transforms.json", transforms(cameras).dump());
  write(folder / "metashape/cameras.xml", metashape_xml(cameras));
  write(folder / "exported.xml", metashape_xml(cameras));
  for (const char* path :
       {"text", "text/sparse", "text/sparse/0", "text/sparse/0/images.txt",
        "text/sparse/0/cameras.txt", "binary", "binary/sparse", "binary/sparse/0",
        "binary/sparse/0/images.bin", "binary/sparse/0/cameras.bin", "nerf", "nerf/transforms.json",
        "metashape", "exported.xml"}) {
    SCOPED_TRACE(path);
    expect_same(read_cameras(folder / path), cameras);
  }
}

TEST(CameraFormats, are_found_beside_the_scene_after_cameras_json) {
  const TemporaryFolder folder;
  const auto scene = folder / "model/point_cloud/iteration_7/point_cloud.ply";
  write(folder / "model/cameras.xml", "");
  EXPECT_EQ(find_cameras_file(scene), folder / "model/cameras.xml");
  write(folder / "model/transforms.json", "{}");
  EXPECT_EQ(find_cameras_file(scene), folder / "model/transforms.json");
  write(folder / "model/sparse/0/images.txt", "");
  EXPECT_EQ(find_cameras_file(scene), folder / "model/sparse/0/images.txt");
  write(folder / "model/sparse/0/images.bin", "");
  EXPECT_EQ(find_cameras_file(scene), folder / "model/sparse/0/images.bin");
  write(folder / "cameras.json", "[]");
  EXPECT_EQ(find_cameras_file(scene), folder / "cameras.json");
}

TEST(CameraFormats, a_blender_file_takes_its_size_from_the_photograph) {
  const TemporaryFolder folder;
  write_image(Image(40, 30, 3), folder / "r_0.png");
  json file = {
      {"camera_angle_x", 2 * std::atan(0.5)},
      {"frames",
       {{{"file_path", "./r_0"},
         {"transform_matrix", {{1, 0, 0, 5}, {0, 1, 0, 6}, {0, 0, 1, 7}, {0, 0, 0, 1}}}}}}};
  write(folder / "transforms.json", file.dump());
  const std::vector<Camera> cameras = read_cameras(folder.path());
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].name, "r_0");
  EXPECT_NEAR(cameras[0].focal_px.x, 40, 1e-9);
  EXPECT_EQ(cameras[0].focal_px.x, cameras[0].focal_px.y);
  EXPECT_EQ(cameras[0].center_px, glm::dvec2(19.5, 14.5));
  // The camera looks along -z with y up: a point below the axis appears below the image centre.
  const glm::dvec3 seen = cameras[0].view_from_world * glm::dvec4(5, 4, 3, 1);
  EXPECT_LT(glm::distance(seen, glm::dvec3(0, 2, 4)), 1e-12);
  std::filesystem::remove(folder / "r_0.png");
  EXPECT_THAT(error_of(folder.path()), HasSubstr("frame 0: w and h are missing"));
}

TEST(CameraFormats, simple_lenses_have_one_focal_length) {
  const TemporaryFolder folder;
  write(folder / "images.txt", "1 2 0 0 0 1 2 3 9 a b/c d.JPG \r\n\n");
  for (const char* lens : {"SIMPLE_PINHOLE 20 10 50 10 5", "SIMPLE_RADIAL 20 10 50 10 5 0",
                           "RADIAL 20 10 50 10 5 0 -1e-9"}) {
    write(folder / "cameras.txt", std::string("9 ") + lens);
    const std::vector<Camera> cameras = read_cameras(folder.path());
    ASSERT_EQ(cameras.size(), 1u);
    EXPECT_EQ(cameras[0].focal_px, glm::dvec2(50, 50));
    EXPECT_EQ(cameras[0].center_px, glm::dvec2(9.5, 4.5));
    EXPECT_EQ(cameras[0].name, "a b/c d");
    EXPECT_EQ(cameras[0].view_from_world, glm::dmat4x3(1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 2, 3));
  }
}

TEST(CameraFormats, damaged_colmap_text_is_named_by_file_and_line) {
  const std::string lens = "1 PINHOLE 20 10 50 50 10 5\n", image = "1 1 0 0 0 0 0 0 1 a.jpg\n\n";
  const std::vector<std::array<std::string, 3>> cases = {
      {"\n1 EUCM 20 10 50 50 10 5 2 1\n", image,
       "cameras.txt: line 2: alpha is 2, but must be from 0 to 1"},
      {"1 RADIAL 200 100 50 100 50 -500 0\n", image,
       "cameras.txt: line 1: the lens distorts too strongly"},
      {"1 FOV 20 10 50 50 10 5 0\n", image,
       "cameras.txt: line 1: omega is 0, but must be between 0 and pi"},
      {"1 EQUIRECTANGULAR 20 10 40 20\n", image,
       "line 1: the parameters of EQUIRECTANGULAR are 40 x 20, but its picture has 20 x 10 pixels"},
      {"1 EQUIRECTANGULAR 20 12 20 12\n", image, "line 1: a panorama of 20 x 12 pixels"},
      {"1 BOX 20 10 50 50 10 5\n", image, "cameras.txt: line 1: there is no camera model 'BOX'"},
      {"1 PINHOLE 0 10 50 50 10 5\n", image, "line 1: a picture of 0 x 10 pixels"},
      {"1 PINHOLE 99999999999 10 50 50 10 5\n", image, "line 1: a picture of 99999999999 x 10"},
      {"1 PINHOLE -5 10 50 50 10 5\n", image, "line 1: the width '-5' is not a number"},
      {"1 PINHOLE 20 10 50 50 10\n", image, "line 1: a parameter is missing"},
      {"1 PINHOLE 20 10 nan 50 10 5\n", image, "line 1: a parameter is not finite"},
      {"1 PINHOLE 20 10 -50 50 10 5\n", image, "line 1: the focal length is not above 0"},
      {lens + lens, image, "cameras.txt: line 2: there is another camera 1"},
      {lens, "1 1 0 0 0 0 0 0 2 a.jpg\n\n", "images.txt: line 1: there is no camera 2"},
      {lens, "1 1 0 0 0 0 0 0 1\n\n", "images.txt: line 1: the name is missing"},
      {lens, "1 0 0 0 0 0 0 0 1 a.jpg\n\n", "images.txt: line 1: its quaternion is no rotation"},
      {lens, "1 1 0 0 0 0 inf 0 1 a.jpg\n\n", "line 1: its translation is not finite"},
      {lens, "1 1 0 x 0 0 0 0 1 a.jpg\n\n", "line 1: the quaternion 'x' is not a number"},
      {lens, "1 1 0 0 0 0 0 0 1 a.jpg\n2 1 0 0 0 0 0 0 1 b.jpg\n",
       "images.txt: line 2: not a list of points"},
  };
  const TemporaryFolder folder;
  for (const auto& [lenses, images, sentence] : cases) {
    write(folder / "cameras.txt", lenses);
    write(folder / "images.txt", images);
    EXPECT_THAT(error_of(folder.path()), HasSubstr(sentence));
  }
  // Lenses that no image uses may be of any kind.
  write(folder / "images.txt", image);
  for (const char* unused :
       {"2 FOV 20 10 50 50 10 5 0\n", "2 OPENCV_FISHEYE 20 10 50 50 10 5 0.1 0 0 0\n", "2 BOX 20\n",
        "2 PINHOLE 0 10 50 50 10 5\n", "2 PINHOLE 20 10 nan 50 10 5\n",
        "2 RADIAL 200 100 50 100 50 -500 0\n", "2 BOX 2\n2 PINHOLE 20 10 50 50 10 5\n"}) {
    write(folder / "cameras.txt", unused + lens);
    EXPECT_EQ(read_cameras(folder.path()).size(), 1u) << unused;
  }
  // A second lens of one id is no choice, finite or not.
  for (const char* second : {"1 PINHOLE 20 10 nan 50 10 5\n", "1 PINHOLE 20 10 60 50 10 5\n"}) {
    for (const std::string& lenses : {lens + second, second + lens}) {
      write(folder / "cameras.txt", lenses);
      EXPECT_THAT(error_of(folder.path()), HasSubstr("line 2: there is another camera 1"));
    }
  }
  std::filesystem::remove(folder / "cameras.txt");
  EXPECT_THAT(error_of(folder / "images.txt"), HasSubstr("cameras.txt: "));
}

TEST(CameraFormats, colmap_binary_that_is_cut_off_anywhere_is_an_error) {
  const std::vector<Camera> cameras = {bundled()[0], bundled()[1], bundled()[2]};
  const std::string lenses = colmap_binary_lenses(cameras), images = colmap_binary_images(cameras);
  const TemporaryFolder folder;
  write(folder / "cameras.bin", lenses);
  for (std::size_t size = 0; size < images.size(); ++size) {
    write(folder / "images.bin", images.substr(0, size));
    ASSERT_THAT(error_of(folder.path()), HasSubstr("images.bin")) << size;
  }
  write(folder / "images.bin", images);
  for (std::size_t size = 0; size < lenses.size(); ++size) {
    write(folder / "cameras.bin", lenses.substr(0, size));
    ASSERT_THAT(error_of(folder.path()), HasSubstr("cameras.bin")) << size;
  }
}

TEST(CameraFormats, colmap_binary_that_claims_too_much_is_an_error) {
  const std::vector<Camera> cameras = {bundled()[0]};
  const std::string lenses = colmap_binary_lenses(cameras);
  std::string images = colmap_binary_images(cameras);
  const TemporaryFolder folder;
  write(folder / "cameras.bin", lenses);
  // The bytes of 2^61 + 1 points overflow to 24 bytes in 64 bits, and the file has 24 bytes.
  const std::uint64_t points = (std::uint64_t{1} << 61) + 1;
  images.replace(images.size() - 8, 8, reinterpret_cast<const char*>(&points), 8);
  images.append(24, 'x');
  write(folder / "images.bin", images);
  EXPECT_THAT(error_of(folder.path()), HasSubstr("images.bin: image 0: cut off"));
  write(folder / "images.bin", std::string(8, '\xff'));
  EXPECT_THAT(error_of(folder.path()), HasSubstr("images.bin: image 0: cut off"));
  write(folder / "images.bin", colmap_binary_images(cameras));
  std::string model = lenses;
  model[12] = 77;
  write(folder / "cameras.bin", model);
  EXPECT_THAT(error_of(folder.path()),
              HasSubstr("cameras.bin: camera 0: there is no camera model"));
}

TEST(CameraFormats, damaged_transforms_are_named_by_file_and_frame) {
  const json valid = transforms({bundled()[0], bundled()[1]});
  const std::vector<std::pair<std::function<void(json&)>, std::string>> cases = {
      {[](json& f) { f.erase("frames"); }, "nor an object with a list of frames"},
      {[](json& f) { f["frames"][1] = 3; }, "frame 1: not a JSON object"},
      {[](json& f) { f["frames"][1].erase("transform_matrix"); },
       "frame 1: transform_matrix is missing"},
      {[](json& f) { f["frames"][1]["transform_matrix"] = 3; },
       "frame 1: transform_matrix is not a list of 3 or 4 rows"},
      {[](json& f) {
         f["frames"][1]["transform_matrix"][2] = {1, 2};
       },
       "frame 1: transform_matrix is not a list of 4 numbers"},
      {[](json& f) { f["frames"][1]["transform_matrix"][0][0] = 3; },
       "frame 1: transform_matrix holds no rotation"},
      {[](json& f) { f["frames"][1]["fl_x"] = -1; }, "frame 1: fl_x is -1"},
      {[](json& f) { f["frames"][1]["file_path"] = 5; }, "frame 1: file_path is not a string"},
      {[](json& f) { f.erase("h"); }, "frame 0: h is missing"},
      {[](json& f) { f["w"] = 1e12; }, "frame 0: w is"},
      {[](json& f) { f["k4"] = 0.1; }, "frame 0: k4 is 0.1, which a lens OPENCV does not have"},
      {[](json& f) { f["camera_model"] = "ORTHOPHOTO"; }, "is no lens that is known"},
      {[](json& f) {
         f["frames"][0].erase("fl_x");
         f.erase("fl_x");
       },
       "frame 0: camera_angle_x is missing"},
      {[](json& f) {
         f["frames"][0].erase("fl_x");
         f.erase("fl_x");
         f["camera_angle_x"] = 4;
       },
       "frame 0: camera_angle_x is 4, but"},
  };
  const TemporaryFolder folder;
  for (const auto& [damage, sentence] : cases) {
    json file = valid;
    damage(file);
    write(folder / "transforms.json", file.dump());
    const std::string message = error_of(folder / "transforms.json");
    EXPECT_THAT(message, HasSubstr("transforms.json: "));
    EXPECT_THAT(message, HasSubstr(sentence));
  }
}

TEST(CameraFormats, a_folder_without_cameras_is_an_error) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of(folder.path()), HasSubstr("a folder without cameras.json"));
}

}  // namespace
}  // namespace qs
