// SPDX-License-Identifier: MIT
//
// .ply files of programs that add to 3DGS's properties, or name or store them otherwise, and of
// models that are no Gaussians.
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include <glm/gtc/packing.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/scene/ply/ply.h"
#include "support/corpus.h"
#include "support/error_of.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const char* const kPlace = "x y z";
const char* const kShape = " opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
const char* const kUsual =
    "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 "
    "rot_2 rot_3";
const char* const kUsualRow = "1 2 3 0.1 0.2 0.3 0 -1 -2 -3 1 0 0 0";

// One vertex in ascii. A name may have a type: "uchar:red".
std::string file_of(const std::string& names, const std::string& row,
                    const std::string& more = "") {
  std::string text = "ply\nformat ascii 1.0\n" + more + "element vertex 1\n";
  std::istringstream words(names);
  for (std::string name; words >> name;) {
    const std::size_t colon = name.find(':');
    text += colon == name.npos
                ? "property float " + name + "\n"
                : "property " + name.substr(0, colon) + " " + name.substr(colon + 1) + "\n";
  }
  return text + "end_header\n" + row + "\n";
}

Scene read_text(const std::string& text, const std::string& path = "test.ply") {
  const auto bytes = to_bytes(text);
  Scene scene;
  scene.path = path;
  ThreadPool pool(1);
  read_ply(bytes, scene.path, pool, {}, scene);
  return scene;
}

TEST(PlyKinds, the_last_of_several_comments_holds) {
  struct Row {
    const char* comments;
    bool antialiased;
    const char* vertical_axis;
  };
  for (const Row& row : std::initializer_list<Row>{
           {"comment SplatRenderMode: mip\ncomment SplatRenderMode: default\n", false, ""},
           {"comment SplatRenderMode: default\ncomment SplatRenderMode: mip\n", true, ""},
           {"comment antialiased 1\ncomment antialiased 0\n", false, ""},
           {"comment antialiased 0\ncomment antialiased 1\n", true, ""},
           {"comment antialiased 1\ncomment SplatRenderMode: default\n", false, ""},
           {"comment SplatRenderMode: default\ncomment antialiased 1\n", true, ""},
           {"comment SplatRenderMode: mip\ncomment other\n", true, ""},
           {"comment SplatRenderMode: mip\ncomment SplatRenderMode: 2dgs\n", false, ""},
           {"comment Vertical axis: y\ncomment Vertical axis: -z\n", false, "-z"},
           {"comment Vertical axis: z\ncomment Vertical axis: y\n", false, "y"}}) {
    SCOPED_TRACE(row.comments);
    const Scene scene = read_text(file_of(kUsual, kUsualRow, row.comments));
    EXPECT_EQ(scene.cloud.antialiased, row.antialiased);
    EXPECT_EQ(scene.vertical_axis, row.vertical_axis);
  }
}

// Yu et al. 2024: variances grow by f^2, opacity falls by the root of the ratio of determinants.
TEST(PlyKinds, the_3d_filter_of_mip_splatting_is_applied) {
  for (const double filter : {0.0, 0.001, 0.05, 0.5, 2.0, -0.05}) {
    for (const double logit : {-3.0, 0.0, 4.0}) {
      SCOPED_TRACE(testing::Message() << filter << " " << logit);
      const Scene scene =
          read_text(file_of(std::string(kUsual) + " filter_3D",
                            fmt::format("0 0 0 0 0 0 {} -1 -2 -3 1 0 0 0 {}", logit, filter)));
      double ratio = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const double before = std::exp(-2.0 * (axis + 1)), after = before + filter * filter;
        EXPECT_NEAR(scene.cloud.log_scales[0][axis], 0.5 * std::log(after), 1e-5);
        ratio *= before / after;
      }
      const double opacity = std::sqrt(ratio) / (1 + std::exp(-logit));
      EXPECT_NEAR(1 / (1 + std::exp(-static_cast<double>(scene.cloud.opacity_logits[0]))), opacity,
                  1e-6);
      EXPECT_THAT(scene.format, HasSubstr("3D filter"));
    }
  }
  const Scene opaque =
      read_text(file_of(std::string(kUsual) + " filter_3D", "0 0 0 0 0 0 inf -1 -1 -1 1 0 0 0 1"));
  EXPECT_NEAR(1 / (1 + std::exp(-opaque.cloud.opacity_logits[0])),
              std::pow(std::exp(-2.0) / (std::exp(-2.0) + 1), 1.5), 1e-6);
}

TEST(PlyKinds, colours_in_place_of_spherical_harmonics_are_read) {
  struct Row {
    const char* names;
    const char* values;
  };
  for (const Row& row : std::initializer_list<Row>{
           {" uchar:red uchar:green uchar:blue", " 255 51 0"},
           {" uint8:red uint8:green uint8:blue", " 255 51 0"},
           {" ushort:red ushort:green ushort:blue", " 65535 13107 0"},
           {" red green blue", " 1 0.2 0"},
           {" double:red double:green double:blue", " 1 0.2 0"},
           {" uchar:red uchar:green uchar:blue uchar:alpha", " 255 51 0 7"}}) {
    SCOPED_TRACE(row.names);
    const std::string text = file_of(std::string(kPlace) + kShape + row.names,
                                     std::string("1 2 3 0 -1 -2 -3 1 0 0 0") + row.values);
    EXPECT_TRUE(recognises_ply(to_bytes(text), "test.ply"));
    const Scene scene = read_text(text);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(0.5 + 0.28209479 * static_cast<double>(scene.cloud.sh[0][c]),
                  (std::array{1.0, 0.2, 0.0}[static_cast<std::size_t>(c)]), 1e-6);
  }
  const Scene both = read_text(file_of(std::string(kUsual) + " uchar:red uchar:green uchar:blue",
                                       std::string(kUsualRow) + " 255 255 255"));
  EXPECT_EQ(both.cloud.sh[0], glm::vec3(0.1f, 0.2f, 0.3f));
}

TEST(PlyKinds, prefixes_of_cloudcompare_are_dropped) {
  std::string prefixed;
  std::istringstream words(kUsual);
  for (std::string name; words >> name;) prefixed += (name.size() == 1 ? " " : " scalar_") + name;
  const Scene expected = read_text(file_of(kUsual, kUsualRow)),
              scene = read_text(file_of(prefixed, kUsualRow));
  EXPECT_EQ(scene.cloud.positions, expected.cloud.positions);
  EXPECT_EQ(scene.cloud.sh, expected.cloud.sh);
  EXPECT_EQ(scene.cloud.log_scales, expected.cloud.log_scales);
  EXPECT_EQ(scene.cloud.rotations, expected.cloud.rotations);
  EXPECT_THAT(scene.warnings, IsEmpty());
  // A property of both names: the one without prefix is the trainer's.
  const Scene both =
      read_text(file_of(std::string(kUsual) + " scalar_opacity", std::string(kUsualRow) + " 9"));
  EXPECT_EQ(both.cloud.opacity_logits[0], 0);
}

TEST(PlyKinds, halves_are_read_in_both_byte_orders) {
  for (const char* type : {"half", "float16"}) {
    for (const bool big : {false, true}) {
      std::string text = fmt::format("ply\nformat binary_{}_endian 1.0\nelement vertex 1\n",
                                     big ? "big" : "little");
      std::istringstream words(kUsual);
      for (std::string name; words >> name;) text += fmt::format("property {} {}\n", type, name);
      text += "end_header\n";
      for (const float value : {1.0f, -2.5f, 0.25f, 3.0f, 4.0f, 5.0f, 6.0f, -1.0f, -2.0f, -3.0f,
                                0.0f, 1.0f, 0.0f, 0.0f}) {
        const std::uint16_t bits = glm::packHalf1x16(value);
        const char low = static_cast<char>(bits & 255), high = static_cast<char>(bits >> 8);
        text += big ? std::string{high, low} : std::string{low, high};
      }
      const Scene scene = read_text(text);
      EXPECT_EQ(scene.cloud.positions[0], glm::vec3(1, -2.5f, 0.25f));
      EXPECT_EQ(scene.cloud.sh[0], glm::vec3(3, 4, 5));
      EXPECT_EQ(scene.cloud.opacity_logits[0], 6);
      EXPECT_EQ(scene.cloud.log_scales[0], glm::vec3(-1, -2, -3));
      EXPECT_EQ(scene.cloud.rotations[0], glm::quat(0, 1, 0, 0));
    }
  }
}

TEST(PlyKinds, gaussians_over_time_are_named_and_drawn) {
  for (const char* more : {"t", "trbf_center", "motion_0", "velocity_0", "scale_t", "t_scale",
                           "rot_r_0", "scaling_t_0"}) {
    SCOPED_TRACE(more);
    const Scene scene =
        read_text(file_of(std::string(kUsual) + " " + more, std::string(kUsualRow) + " 0.5"));
    EXPECT_EQ(scene.cloud.positions[0], glm::vec3(1, 2, 3));
    EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("4D Gaussians")));
  }
}

TEST(PlyKinds, flat_gaussians_are_named_and_drawn) {
  const Scene scene = read_text(
      file_of("x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 rot_0 rot_1 rot_2 rot_3",
              "1 2 3 0.1 0.2 0.3 0 -1 -2 1 0 0 0"));
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("2D Gaussians (2DGS)")));
}

TEST(PlyKinds, anchors_of_scaffold_gs_are_refused_by_name) {
  for (const char* more : {"f_anchor_feat_0", "f_offset_0", "f_offset_0 f_anchor_feat_0"}) {
    SCOPED_TRACE(more);
    const std::string text =
        file_of(std::string(kPlace) + " " + more + kShape, "1 2 3 0 0 0 -1 -2 -3 1 0 0 0");
    EXPECT_TRUE(recognises_ply(to_bytes(text), "test.ply"));
    EXPECT_FALSE(is_ply_without_colors(to_bytes(text)));
    EXPECT_THAT(test::error_of([&] { read_text(text); }), HasSubstr("anchors of Scaffold-GS"));
  }
}

}  // namespace
}  // namespace qs::test
