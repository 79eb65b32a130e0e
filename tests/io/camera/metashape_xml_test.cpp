// SPDX-License-Identifier: MIT
// Metashape's exported cameras: lenses of its sensors, cameras that are left out, and damaged
// files.
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/camera_formats.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kFrame =
    "<sensor id=\"0\" type=\"frame\"><resolution width=\"640\" height=\"480\"/><calibration "
    "class=\"adjusted\"><f>510</f><b1>-10</b1><b2>3</b2><cx>2</cx><cy>-1</cy><k1>0.05</k1>"
    "<k2>-0.02</k2><k3>0.004</k3><k4>-0.001</k4><p1>0.002</p1><p2>-0.003</p2></calibration>"
    "</sensor>";
constexpr const char* kShot =
    "<camera sensor_id=\"0\" label=\"a.jpg\"><transform>1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1"
    "</transform></camera>";

std::string document(const std::string& sensors, const std::string& cameras,
                     const std::string& more = "") {
  return "<document><chunk><sensors>" + sensors + "</sensors>" + more + "<cameras>" + cameras +
         "</cameras></chunk></document>";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

class MetashapeXml : public testing::Test {
 protected:
  CameraSet read(const std::string& text) const {
    std::ofstream(folder_ / "cameras.xml", std::ios::binary) << text;
    return read_camera_set(folder_ / "cameras.xml");
  }
  std::string error(const std::string& text) const {
    return test::error_of([&] { read(text); });
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(MetashapeXml, sensors_are_models_of_lenses) {
  const CameraSet set = read(document(kFrame, kShot));
  ASSERT_EQ(set.cameras.size(), 1u);
  EXPECT_THAT(set.sentences(), IsEmpty());
  const CameraSet written = read("\xef\xbb\xbf<?xml version='1.0'?>\n<!DOCTYPE a><!-- <b> -->" +
                                 document(kFrame, replaced(kShot, "a.jpg", "a&amp;lt; > b.jpg")));
  EXPECT_EQ(written.cameras[0].photograph, "a&lt; > b.jpg");
  const LensCamera& camera = set.cameras[0];
  EXPECT_EQ(camera.camera.name, "a");
  EXPECT_EQ(camera.photograph, "a.jpg");
  EXPECT_EQ(camera.camera.position(), glm::dvec3(5, 6, 7));
  ASSERT_TRUE(camera.lens);
  // The golden point of METASHAPE, moved by cx and cy.
  const auto pixel = camera.lens->project({0.3, -0.2, 1});
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->x + 0.5, 470.809 + 2, 6e-4);
  EXPECT_NEAR(pixel->y + 0.5, 136.927 - 1, 6e-4);

  const struct {
    const char *type, *model;
  } types[] = {{"fisheye", "METASHAPE_FISHEYE"},
               {"equidistant_fisheye", "METASHAPE_FISHEYE"},
               {"spherical", "EQUIRECTANGULAR"}};
  for (const auto& [type, model] : types) {
    SCOPED_TRACE(type);
    std::string sensor = replaced(kFrame, "\"frame\"", std::string("\"") + type + "\"");
    if (type == std::string("spherical"))
      sensor =
          "<sensor id=\"0\" type=\"spherical\"><resolution width=\"640\" height=\"320\"/></sensor>";
    const CameraSet other = read(document(sensor, kShot));
    ASSERT_TRUE(other.cameras[0].lens);
    EXPECT_EQ(other.cameras[0].lens->model->name, model);
  }
}

TEST_F(MetashapeXml, cameras_that_are_not_used_are_counted) {
  const std::string off = replaced(kShot, "<camera", "<camera enabled=\"false\""),
                    loose = "<camera sensor_id=\"0\" label=\"b\"/>",
                    turned = replaced(kShot, "</camera>", "<orientation>6</orientation></camera>"),
                    lost = replaced(kShot, "1 0 0 5", "1 0 0 nan");
  const CameraSet set = read(document(kFrame, kShot + off + loose + loose + turned + lost));
  EXPECT_EQ(set.cameras.size(), 2u);
  EXPECT_THAT(
      set.sentences(),
      ElementsAre(HasSubstr("cameras.xml: not aligned, so left out: 2 cameras"),
                  HasSubstr("not enabled, so left out: 1 camera"),
                  HasSubstr("turned by Exif's orientation, which is not used: 1 camera"),
                  HasSubstr("camera 'a.jpg': transform is nan (a.jpg); this camera is left out")));
  const std::string two = "<components><component id=\"1\"/><component id=\"2\"/></components>",
                    in_1 = replaced(kShot, "<camera", "<camera component_id=\"1\""),
                    in_2 = replaced(kShot, "<camera", "<camera component_id=\"2\"");
  EXPECT_THAT(read(document(kFrame, in_1 + in_2, two)).sentences(),
              ElementsAre(HasSubstr("its cameras are of 2 components")));
  const std::string second =
      replaced(document(kFrame, kShot), "</document>", "<chunk/></document>");
  EXPECT_THAT(read(second).sentences(), ElementsAre(HasSubstr("only its first chunk is used")));
}

TEST_F(MetashapeXml, the_place_of_a_chunk_without_components_counts) {
  const std::string place =
      "<transform><rotation>0 -1 0 1 0 0 0 0 1</rotation><translation>1 2 3</translation>"
      "<scale>2</scale></transform>";
  const CameraSet set = read(document(kFrame, kShot, place));
  EXPECT_EQ(set.cameras[0].camera.position(), glm::dvec3(1 - 12, 2 + 10, 3 + 14));
}

TEST_F(MetashapeXml, bad_files_get_a_sentence) {
  const std::string good = document(kFrame, kShot);
  std::string deep;
  for (int i = 0; i < 65; ++i) deep += "<a>";
  const struct {
    std::string text;
    const char* sentence;
  } rows[] = {
      {"<document/>", "not Metashape's cameras: there is no document with a chunk"},
      {"<document><chunk/></document>", "its chunk has no cameras"},
      {document(kFrame, ""), "no camera of its chunk is aligned and enabled"},
      {document("", kShot), "camera 'a.jpg': there is no sensor '0'"},
      {replaced(good, "type=\"frame\"", "type=\"cylindrical\""),
       "sensor 0: its type is 'cylindrical', which is no lens that is known"},
      {replaced(good, "type=\"frame\"", ""), "its type is '', which is no lens"},
      {replaced(good, "width=\"640\"", "width=\"640.5\""),
       "sensor 0: its width is 640.5, but is a whole number from 1 to 65535"},
      {replaced(good, "width=\"640\"", "wide=\"640\""), "width has '' in place of a number"},
      {replaced(good, "<f>510</f>", ""), "the focal length is not above 0"},
      {replaced(good, "<f>510</f>", "<f>5l0</f>"), "f has '5l0' in place of a number"},
      {replaced(good, "<k1>0.05</k1>", "<k1>0.05 1</k1>"), "k1 has more than 1 numbers"},
      {document(
           "<sensor id=\"0\" type=\"frame\"><resolution width=\"640\" height=\"480\"/></sensor>",
           kShot),
       "sensor 0: has no calibration: align the photographs before the export"},
      {replaced(good, "1 0 0 5", "2 0 0 5"), "its transform holds no rotation"},
      {replaced(good, "0 0 0 1</transform>", "0 0 0</transform>"),
       "transform has '' in place of a number"},
      {document(kFrame, kShot, "<transform><scale>0</scale></transform>"),
       "chunk: its scale is 0, but is above 0"},
      {replaced(good, "</chunk>", ""),
       "not valid XML: line 1: an element ends that did not begin last"},
      {good.substr(0, good.size() - 5), "not valid XML: line 1: the file ends too early"},
      {replaced(good, "<document>", "<document>\n<!-- "), "line 2: the file ends too early"},
      {replaced(good, "<chunk>", "<chunk a=\"1>"), "line 1: the file ends too early"},
      {"<document></document></document>", "an element ends that did not begin last"},
      {"<document>" + deep, "more than 64 nested levels"},
  };
  for (const auto& [text, sentence] : rows) EXPECT_THAT(error(text), HasSubstr(sentence)) << text;
}

}  // namespace
}  // namespace qs
