// SPDX-License-Identifier: MIT
//
// OpenUSD in text: transforms, defaults, lengths, other things of a stage, sentences, and the
// written bytes. The corpus has whole files.
#include "io/scene/usd/usd.h"

#include <cmath>
#include <cstring>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/bytes/zip.h"
#include "io/support/zip_archive.h"
#include "support/corpus.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Scene read_usda(const std::string& text) {
  Scene scene;
  scene.path = "a.usda";
  read_usd(std::as_bytes(std::span(text)), scene.path, pool(), {}, scene);
  return scene;
}

std::string usda_error(const std::string& text) {
  try {
    read_usda(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

const std::string kHead = "#usda 1.0\n";

std::string splat_prim(const std::string& body) {
  return "def ParticleField3DGaussianSplat \"S\" {\n" + body + "\n}\n";
}

const std::string kOne = splat_prim(
    "point3f[] positions = [(1, 2, 3)]\nfloat3[] scales = [(0.5, 0.5, 0.5)]\n"
    "float[] opacities = [0.5]");

// A stage is y up with z back; the cloud has y down and z forward.
glm::vec3 of_stage(double x, double y, double z) { return glm::dvec3(x, -y, -z); }

void expect_at(const glm::vec3& actual, const glm::vec3& expected) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(actual[axis], expected[axis], 1e-5) << axis;
}

TEST(Usd, parents_move_their_gaussians) {
  struct Case {
    const char* ops;
    glm::vec3 position;
    double scale = 0.5;
  };
  const Case cases[] = {
      {"", of_stage(1, 2, 3)},
      {"double3 xformOp:translate = (10, 20, 30)\nuniform token[] xformOpOrder = "
       "[\"xformOp:translate\"]",
       of_stage(11, 22, 33)},
      {"double3 xformOp:translate = (10, 20, 30)", of_stage(1, 2, 3)},  // not in the order
      {"float xformOp:rotateX = 90\nuniform token[] xformOpOrder = [\"xformOp:rotateX\"]",
       of_stage(1, -3, 2)},
      {"float xformOp:rotateY:a = 90\nuniform token[] xformOpOrder = [\"xformOp:rotateY:a\"]",
       of_stage(3, 2, -1)},
      // X first: (1, -3, 2), then Y: (2, -3, -1), then Z: (3, 2, -1).
      {"float3 xformOp:rotateXYZ = (90, 90, 90)\nuniform token[] xformOpOrder = "
       "[\"xformOp:rotateXYZ\"]",
       of_stage(3, 2, -1)},
      // Z first: (-2, 1, 3), then X: (-2, -3, 1).
      {"float3 xformOp:rotateZXY = (90, 90, 0)\nuniform token[] xformOpOrder = "
       "[\"xformOp:rotateZXY\"]",
       of_stage(-2, -3, 1)},
      {"half3 xformOp:scale = (2, 2, 2)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]",
       of_stage(2, 4, 6), 1},
      {"quatf xformOp:orient = (0.70710678, 0, 0, 0.70710678)\nuniform token[] xformOpOrder = "
       "[\"xformOp:orient\"]",
       of_stage(-2, 1, 3)},
      {"matrix4d xformOp:transform = ( (0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (5, 6, 7, 1) "
       ")\nuniform token[] xformOpOrder = [\"xformOp:transform\"]",
       of_stage(-2 + 5, 1 + 6, 3 + 7)},
      // The last operation is applied first.
      {"double3 xformOp:translate = (1, 0, 0)\nfloat3 xformOp:scale = (2, 2, 2)\nuniform token[] "
       "xformOpOrder = [\"xformOp:translate\", \"xformOp:scale\"]",
       of_stage(3, 4, 6), 1},
      {"float3 xformOp:scale = (2, 2, 2)\ndouble3 xformOp:translate = (1, 0, 0)\nuniform token[] "
       "xformOpOrder = [\"xformOp:scale\", \"xformOp:translate\"]",
       of_stage(4, 4, 6), 1},
      {"double3 xformOp:translate:pivot = (1, 2, 3)\nfloat3 xformOp:scale = (2, 2, 2)\nuniform "
       "token[] xformOpOrder = [\"xformOp:translate:pivot\", \"xformOp:scale\", "
       "\"!invert!xformOp:translate:pivot\"]",
       of_stage(1, 2, 3), 1},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.ops);
    const std::string one = kHead + "def Xform \"P\" {\n" + c.ops + "\n" + kOne + "}\n";
    const Scene scene = read_usda(one);
    EXPECT_THAT(scene.warnings, IsEmpty());
    ASSERT_EQ(scene.cloud.size(), 1u);
    expect_at(scene.cloud.positions[0], c.position);
    EXPECT_NEAR(std::exp(scene.cloud.log_scales[0].y), c.scale, 1e-6);
  }
  // Nested, and a prim that ignores its parents.
  const std::string moved =
      "double3 xformOp:translate = (10, 0, 0)\nuniform token[] xformOpOrder = "
      "[\"xformOp:translate\"]\n";
  const std::string reset =
      "double3 xformOp:translate = (0, 5, 0)\nuniform token[] xformOpOrder = "
      "[\"!resetXformStack!\", \"xformOp:translate\"]\n";
  const Scene nested = read_usda(kHead + "def Xform \"A\" {\n" + moved + "def \"B\" {\n" + moved +
                                 kOne + "}\n" + "def \"C\" {\n" + reset + kOne + "}\n}\n");
  ASSERT_EQ(nested.cloud.size(), 2u);
  expect_at(nested.cloud.positions[0], of_stage(21, 2, 3));
  expect_at(nested.cloud.positions[1], of_stage(1, 7, 3));
}

TEST(Usd, z_up_is_turned) {
  const Scene scene = read_usda(kHead + "(\n upAxis = \"Z\"\n)\n" + kOne);
  EXPECT_EQ(scene.axes, "RFU");
  expect_at(scene.cloud.positions[0], glm::vec3(1, -3, 2));
  EXPECT_EQ(read_usda(kHead + kOne).axes, "RUB");
}

TEST(Usd, rotations_are_w_x_y_z_and_are_normalised) {
  const Scene scene = read_usda(
      kHead +
      splat_prim("point3f[] positions = [(0, 0, 0)]\nquatf[] orientations = [(2, 0, 0, 2)]"));
  const glm::quat q = scene.cloud.rotations[0];
  EXPECT_NEAR(q.w, std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(q.x, 0, 1e-6);
  EXPECT_NEAR(q.z, -std::sqrt(0.5), 1e-6);  // about an axis that points the other way
}

TEST(Usd, missing_and_short_arrays_have_the_defaults_of_the_schema) {
  const Scene bare = read_usda(kHead + splat_prim("point3f[] positions = [(0, 0, 0), (1, 0, 0)]"));
  EXPECT_THAT(bare.warnings, IsEmpty());
  ASSERT_EQ(bare.cloud.size(), 2u);
  EXPECT_EQ(bare.cloud.sh_degree, 0);
  EXPECT_EQ(bare.cloud.log_scales[1], glm::vec3(0));
  EXPECT_EQ(bare.cloud.opacity_logits[1], INFINITY);
  EXPECT_EQ(bare.cloud.rotations[1], glm::quat(1, 0, 0, 0));
  EXPECT_EQ(bare.cloud.sh[1], glm::vec3(0));  // a colour of 0.5
  const Scene declared = read_usda(
      kHead +
      splat_prim("point3f[] positions = [(0, 0, 0)]\nquatf[] orientations\nfloat[] opacities "
                 "( doc = \"none\" )\ndouble3 xformOp:translate\ntoken visibility\n"
                 "uniform token[] xformOpOrder\nint radiance:sphericalHarmonicsDegree"));
  EXPECT_EQ(declared.cloud.rotations[0], glm::quat(1, 0, 0, 0)) << "declarations without a value";
  // Degree 3 without a number.
  const Scene short_sh = read_usda(
      kHead + splat_prim("point3f[] positions = [(0, 0, 0)]\n"
                         "float3[] radiance:sphericalHarmonicsCoefficients = [(1, 1, 1)]"));
  EXPECT_EQ(short_sh.cloud.sh_degree, 0);
  EXPECT_EQ(short_sh.cloud.sh[0], glm::vec3(0));
  EXPECT_THAT(short_sh.warnings, ElementsAre(HasSubstr("they were ignored")));
}

TEST(Usd, floats_are_preferred_to_halves) {
  for (const char* body : {"half[] opacitiesh = [0.25]\nfloat[] opacities = [0.5]",
                           "float[] opacities = [0.5]\nhalf[] opacitiesh = [0.25]",
                           "float[] opacities = [0.5]\nhalf[] opacitiesh = None"}) {
    const Scene scene =
        read_usda(kHead + splat_prim("point3h[] positionsh = [(1, 2, 3)]\n" + std::string(body)));
    EXPECT_EQ(scene.cloud.opacity_logits[0], 0) << body;
    expect_at(scene.cloud.positions[0], of_stage(1, 2, 3));
  }
}

TEST(Usd, parts_of_a_stage_that_are_not_read_get_a_warning) {
  const std::pair<std::string, const char*> cases[] = {
      {"(\n subLayers = [@a.usda@, @b.usda@]\n)\n" + kOne, "not read: sublayers"},
      {"def \"A\" (\n references = @a.usda@</X> (offset = 10)\n)\n{\n}\n" + kOne, "references"},
      {"def \"A\" (\n prepend references = [@a.usda@, </B>]\n)\n{\n}\n" + kOne, "references"},
      {"def \"A\" (\n payload = @@@a@b.usda@@@\n)\n{\n}\n" + kOne, "payload"},
      {"def \"A\" (\n inherits = </Class>\n)\n{\n}\n" + kOne, "inherits"},
      {"def \"A\" {\n variantSet \"size\" = {\n \"big\" {\n def \"B\" {\n}\n}\n}\n}\n" + kOne,
       "variants"},
      {splat_prim("point3f[] positions = [(0, 0, 0)]\nfloat[] opacities = [0.5]\n"
                  "point3f[] positions.timeSamples = { 1: [(1, 1, 1)], 2: [(2, 2, 2)], }"),
       "change over time are not read: positions"},
      {"def \"A\" {\n token visibility = \"invisible\"\n" + kOne + "}\n" + kOne,
       "not defined were left out: 1."},
      {"class \"A\" {\n" + kOne + "}\n" + kOne, "not defined were left out: 1."},
      {"over \"A\" {\n" + kOne + "}\n" + kOne, "not defined were left out: 1."},
      {"def \"A\" (\n active = false\n) {\n" + kOne + "}\n" + kOne,
       "inactive or not defined were left out: 1."},
      {splat_prim("point3f[] positions = [(0, 0, 0)]\n"
                  "uniform token projectionModeHint = \"tangential\""),
       "tangential"},
      {"def \"A\" {\n double3 xformOp:scale = (1, 2, 3)\nuniform token[] xformOpOrder = "
       "[\"xformOp:scale\"]\n" +
           kOne + "}\n",
       "stretches or mirrors"},
  };
  for (const auto& [text, warning] : cases) {
    SCOPED_TRACE(text);
    const Scene scene = read_usda(kHead + text);
    EXPECT_EQ(scene.cloud.size(), 1u);
    EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr(warning)));
  }
}

TEST(Usd, errors_name_the_line_and_the_reason) {
  const std::pair<std::string, const char*> cases[] = {
      {splat_prim("point3f[] positions = [(0, 0, x)]"),
       "a.usda: line 3: a number is expected, there is 'x'"},
      {splat_prim("point3f[] positions = [(0, 0)]"),
       "a.usda: line 3: ',' is expected, there is ')'"},
      {splat_prim("point3f[] positions = [(0, 0, 0)"), "']' is expected, there is '}'"},
      {splat_prim("point3f[] positions = [(0, 0, 1e999)]"), "a number is out of range"},
      {splat_prim("point3f positions = (0, 0, 0)"), "is no list of 3 numbers each"},
      {splat_prim("quatf[] positions = [(0, 0, 0, 1)]"), "but of type quatf"},
      {splat_prim("uniform int radiance:sphericalHarmonicsDegree = -1"), "SH degree -1"},
      {splat_prim("double3 xformOp:translate = (1, 2)"), "2 numbers where 3 are needed"},
      {splat_prim("double3 xformOp:translate = (1, 2, inf)"), "xformOp:translate is not finite"},
      {splat_prim("double3 xformOp:shear = (1, 2, 3)"), "xformOp:shear is not known"},
      {splat_prim("string a = \"no end"), "a text in quotes has no end"},
      {splat_prim("asset a = @no end"), "the name of a file has no end"},
      {"(\n upAxis = \"X\"\n)\n", "upAxis is \"X\""},
      {"hello\n", "a prim is expected, there is 'hello'"},
      {"def ParticleField3DGaussianSplat \"S\" {\n", "the text ends where a name is expected"},
      {"def Xform \"W\" {\n}\n", "a.usda: no prim of type ParticleField3DGaussianSplat is shown"},
      {"def ParticleField \"S\" (\n apiSchemas = [\"ParticleFieldKernelConstantSurfletAPI\"]\n) "
       "{\n}\n",
       "/S has a kernel of flat surflets"},
  };
  for (const auto& [text, sentence] : cases)
    EXPECT_THAT(usda_error(kHead + text), HasSubstr(sentence)) << text;
}

TEST(Usd, nested_values_do_not_fill_the_stack) {
  std::string files, brackets;
  for (int i = 0; i < 200000; ++i) files += "@a@ (", brackets += "([{";
  EXPECT_THAT(usda_error(kHead + splat_prim("asset a = " + files)), HasSubstr("64 levels"));
  EXPECT_THAT(usda_error(kHead + splat_prim("int a = " + brackets)), HasSubstr("64 levels"));
  EXPECT_THAT(usda_error(kHead + "(\n a = " + brackets), HasSubstr("64 levels"));
  std::string numbers(200000, '(');
  EXPECT_THAT(usda_error(kHead + splat_prim("matrix4d xformOp:transform = " + numbers)),
              HasSubstr("64 levels"));
}

TEST(Usd, binary_files_are_refused_by_name) {
  EXPECT_THAT(usda_error(std::string("PXR-USDC\0\1\2", 11)), HasSubstr("binary .usdc (crate)"));
}

TEST(Usd, text_of_one_gaussian_is_written_as_the_schema_says) {
  GaussianCloud cloud = single_gaussian({1, 2, 3}, 0.5f, glm::vec3(0.5f), 0);
  cloud.rotations[0] = glm::quat(0.5f, 0.5f, 0.5f, 0.5f);
  const TemporaryFolder folder;
  write_scene(cloud, folder / "a.usda");
  const auto bytes = file_bytes(folder / "a.usda");
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
            R"(#usda 1.0
(
    defaultPrim = "World"
    doc = "written by quadsplat"
    metersPerUnit = 1
    upAxis = "Y"
)

def Xform "World"
{
    def ParticleField3DGaussianSplat "Splats"
    {
        float3[] extent = [(-0.5, -3.5, -4.5), (2.5, -0.5, -1.5)]
        point3f[] positions = [
(1, -2, -3)
        ]
        quatf[] orientations = [
(0.5, 0.5, -0.5, -0.5)
        ]
        float3[] scales = [
(0.5, 0.5, 0.5)
        ]
        float[] opacities = [
0.5
        ]
        uniform int radiance:sphericalHarmonicsDegree = 0
        float3[] radiance:sphericalHarmonicsCoefficients = [
(0, 0, 0)
        ] (
            elementSize = 1
            interpolation = "vertex"
        )
        uniform token projectionModeHint = "perspective"
        uniform token sortingModeHint = "zDepth"
    }
}
)");
}

TEST(Usd, files_of_an_archive_begin_at_multiples_of_64_bytes) {
  const TemporaryFolder folder;
  for (const std::size_t count : {1u, 2u, 17u, 300u}) {
    write_scene(random_cloud(count, 1, 3), folder / "a.usdz");
    const auto bytes = file_bytes(folder / "a.usdz");
    const auto files = zip_directory(bytes, "a.usdz");
    ASSERT_EQ(files.size(), 1u);
    EXPECT_EQ(files[0].name, "scene.usda");
    EXPECT_EQ(files[0].method, 0);
    EXPECT_EQ((files[0].stored.data() - bytes.data()) % 64, 0);
    EXPECT_THAT(zip_entries(folder / "a.usdz")[0].second, testing::StartsWith("#usda 1.0\n"));
    EXPECT_EQ(read_scene(folder / "a.usdz").cloud.size(), count);
  }
  std::vector<ZipEntry> entries;  // names and sizes of all remainders
  for (std::size_t i = 0; i < 70; ++i)
    entries.push_back({std::string(i + 1, 'n'), std::string(3 * i, 'c')});
  qs::write_zip(folder / "many.zip", entries, ZipForm::aligned);
  const auto bytes = file_bytes(folder / "many.zip");
  for (const ZippedFile& file : zip_directory(bytes, "many.zip"))
    EXPECT_EQ((file.stored.data() - bytes.data()) % 64, 0) << file.name;
  EXPECT_EQ(zip_entries(folder / "many.zip").size(), 70u);
}

}  // namespace
}  // namespace qs::test
