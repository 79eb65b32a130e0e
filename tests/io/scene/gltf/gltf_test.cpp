// SPDX-License-Identifier: MIT
//
// Cases that are not in the corpus: node transforms, the draft's logarithms, quantised values,
// repeated meshes.
#include "io/scene/gltf/gltf.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/bytes/json_text.h"
#include "io/scene/writer.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/glb.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::size_t kCount = 70;

Glb written(int degree = 1) {
  const TemporaryFolder folder;
  write_scene(random_cloud(kCount, degree, 5), folder / "a.glb");
  return open_glb(file_bytes(folder / "a.glb"));
}

Scene read(const Glb& glb) {
  const auto bytes = make_glb(glb);
  Scene scene;
  scene.path = "test.glb";
  ThreadPool pool(2);
  read_gltf(bytes, scene.path, pool, {}, scene);
  return scene;
}

std::string error_of(const Glb& glb) {
  try {
    read(glb);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

// The floats of the accessor of `attribute`.
float* floats(Glb& glb, const std::string& attribute) {
  const json& d = glb.description;
  const std::size_t accessor = d["meshes"][0]["primitives"][0]["attributes"][attribute];
  const std::size_t view = d["accessors"][accessor]["bufferView"];
  const std::size_t offset = d["bufferViews"][view]["byteOffset"];
  return reinterpret_cast<float*>(glb.binary.data() + offset);
}

TEST(Gltf, what_we_write_has_the_required_accessors) {
  const Glb glb = written(3);
  const json& primitive = glb.description["meshes"][0]["primitives"][0];
  EXPECT_EQ(primitive["mode"], 0);
  EXPECT_EQ(primitive["attributes"].size(), 4u + 16u);
  std::uint64_t end = 0;
  for (const json& view : glb.description["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"], end);
    EXPECT_EQ(end % 4, 0u);
    end += view["byteLength"].get<std::uint64_t>();
  }
  EXPECT_EQ(end, glb.binary.size());
  const json& position = glb.description["accessors"][0];
  EXPECT_EQ(position["min"].size(), 3u);
  EXPECT_EQ(position["max"].size(), 3u);
}

TEST(Gltf, nodes_move_their_gaussians) {
  Glb glb = written();
  const GaussianCloud before = read(glb).cloud;
  glb.description["nodes"] = parse_json(
      R"([{"translation":[1,2,3],"children":[1]},{"mesh":0,"scale":[2,2,2],"rotation":[0,0,0,1]}])",
      "test");
  const Scene scene = read(glb);
  EXPECT_THAT(scene.warnings, IsEmpty());
  for (std::size_t i = 0; i < kCount; ++i) {
    // glTF's x and y point the other way.
    const glm::vec3 expected = 2.0f * before.positions[i] + glm::vec3(-1, -2, 3);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(scene.cloud.positions[i][axis], expected[axis], 1e-4);
      EXPECT_NEAR(std::exp(scene.cloud.log_scales[i][axis]),
                  2 * std::exp(before.log_scales[i][axis]), 1e-4);
    }
  }
}

TEST(Gltf, mesh_of_two_nodes_is_read_twice) {
  Glb glb = written();
  glb.description["nodes"] = parse_json(R"([{"mesh":0},{"mesh":0,"translation":[9,0,0]}])", "test");
  glb.description["scenes"][0]["nodes"] = {0, 1};
  const Scene scene = read(glb);
  ASSERT_EQ(scene.cloud.size(), 2 * kCount);
}

TEST(Gltf, every_primitive_of_every_mesh_is_read) {
  Glb glb = written();
  const json first = glb.description["meshes"][0]["primitives"][0];
  json second = first;  // its positions are the scales of the first
  for (const auto& [name, accessor] : first["attributes"].items()) {
    if (name.ends_with("SCALE")) second["attributes"]["POSITION"] = accessor;
  }
  const auto positions_of = [&](const json& primitive) {
    glb.description["meshes"] = {{{"primitives", {primitive}}}};
    return read(glb).cloud.positions;
  };
  const auto a = positions_of(first), b = positions_of(second);
  ASSERT_NE(a, b);

  glb.description["meshes"] = {{{"primitives", {first, second}}}, {{"primitives", {first}}}};
  glb.description["nodes"] = {{{"mesh", 0}}, {{"mesh", 1}}};
  glb.description["scenes"][0]["nodes"] = {0, 1};
  auto expected = a;  // of the last node, which is read first
  expected.insert(expected.end(), a.begin(), a.end());
  expected.insert(expected.end(), b.begin(), b.end());
  const auto positions = read(glb).cloud.positions;
  ASSERT_EQ(positions.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(positions[i], expected[i]) << i;
}

TEST(Gltf, endless_repetition_is_refused) {
  Glb glb = written(0);
  json nodes = json::array(), roots = json::array();
  for (std::size_t i = 0; i < (1 << 20) / kCount + 1; ++i) {
    nodes.push_back({{"mesh", 0}});
    roots.push_back(i);
  }
  glb.description["nodes"] = nodes;
  glb.description["scenes"][0]["nodes"] = roots;
  EXPECT_THAT(error_of(glb), HasSubstr("repeat meshes"));
}

TEST(Gltf, stretched_nodes_warn_and_flattening_ones_are_refused) {
  Glb glb = written();
  glb.description["nodes"][0]["scale"] = {1, 2, 3};
  EXPECT_THAT(read(glb).warnings, ElementsAre(HasSubstr("stretches or mirrors")));
  glb.description["nodes"][0]["scale"] = {1, 2, 0};
  EXPECT_THAT(error_of(glb), HasSubstr("flattens"));
}

TEST(Gltf, logarithms_of_the_draft_are_detected) {
  Glb glb = written();
  const GaussianCloud before = read(glb).cloud;
  float* const scales = floats(glb, "KHR_gaussian_splatting:SCALE");
  for (std::size_t i = 0; i < 3 * kCount; ++i) scales[i] = -5 - 0.01f * static_cast<float>(i);
  const Scene scene = read(glb);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("draft")));
  EXPECT_FLOAT_EQ(scene.cloud.log_scales[1].y, -5.04f);
}

// The attributes of the draft of 2024: rotation and scale without prefix, RGBA in COLOR_0.
TEST(Gltf, colours_and_opacities_of_the_draft_are_read) {
  Glb glb = written(1);
  const GaussianCloud before = read(glb).cloud;
  json& d = glb.description;
  auto& primitive = d["meshes"][0]["primitives"][0];
  auto& attributes = primitive["attributes"];
  for (const char* name : {"ROTATION", "SCALE"}) {
    attributes[std::string("_") + name] = attributes[std::string("KHR_gaussian_splatting:") + name];
    attributes.erase(std::string("KHR_gaussian_splatting:") + name);
  }
  attributes.erase("KHR_gaussian_splatting:OPACITY");
  attributes.erase("KHR_gaussian_splatting:SH_DEGREE_0_COEF_0");
  primitive["extensions"]["KHR_gaussian_splatting"] = json::object();
  const std::size_t offset = glb.binary.size();
  for (std::size_t i = 0; i < kCount; ++i)
    for (const int value : {255, 51, 0, 204}) glb.binary.push_back(static_cast<std::byte>(value));
  attributes["COLOR_0"] = d["accessors"].size();
  d["accessors"].push_back({{"bufferView", d["bufferViews"].size()},
                            {"componentType", 5121},
                            {"normalized", true},
                            {"count", kCount},
                            {"type", "VEC4"}});
  d["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", 4 * kCount}});
  d["buffers"][0]["byteLength"] = glb.binary.size();
  const Scene scene = read(glb);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("draft")));
  EXPECT_EQ(scene.cloud.positions, before.positions);
  EXPECT_EQ(scene.cloud.rotations, before.rotations);
  EXPECT_EQ(scene.cloud.log_scales, before.log_scales);
  for (std::size_t i = 0; i < kCount; ++i) {
    EXPECT_NEAR(scene.cloud.opacity_logits[i], std::log(0.8 / 0.2), 1e-5);
    const glm::vec3 color = 0.5f + 0.28209479f * scene.cloud.sh[4 * i];
    EXPECT_NEAR(color.x, 1, 1e-5);
    EXPECT_NEAR(color.y, 0.2, 1e-5);
    EXPECT_NEAR(color.z, 0, 1e-5);
    for (std::size_t k = 1; k < 4; ++k)
      EXPECT_EQ(scene.cloud.sh[4 * i + k], before.sh[4 * i + k]) << i << " " << k;
  }
}

// Appends bytes and returns the number of their bufferView.
std::size_t add_view(Glb& glb, const void* data, std::size_t bytes) {
  json& views = glb.description["bufferViews"];
  const auto* const first = static_cast<const std::byte*>(data);
  while (glb.binary.size() % 4 != 0) glb.binary.push_back(std::byte{0});
  views.push_back({{"buffer", 0}, {"byteOffset", glb.binary.size()}, {"byteLength", bytes}});
  glb.binary.insert(glb.binary.end(), first, first + bytes);
  glb.description["buffers"][0]["byteLength"] = glb.binary.size();
  return views.size() - 1;
}

json& accessor_of(Glb& glb, const std::string& attribute) {
  json& d = glb.description;
  return d["accessors"]
          [d["meshes"][0]["primitives"][0]["attributes"][attribute].get<std::size_t>()];
}

TEST(Gltf, sparse_accessors_replace_elements) {
  const std::vector<float> values = {1, 2, 3, 4, 5, 6};
  const std::vector<std::uint8_t> bytes = {3, 69};
  const std::vector<std::uint16_t> shorts = {3, 69};
  const std::vector<std::uint32_t> words = {3, 69};
  const auto sparse = [&](Glb& glb, const char* attribute, int type, bool keeps_base) {
    const std::size_t indices = type == 5121   ? add_view(glb, bytes.data(), 2)
                                : type == 5123 ? add_view(glb, shorts.data(), 4)
                                               : add_view(glb, words.data(), 8);
    const std::size_t replaced = add_view(glb, values.data(), 24);
    json& accessor = accessor_of(glb, attribute);
    if (!keeps_base) accessor.erase("bufferView");
    accessor["sparse"] = {{"count", 2},
                          {"indices", {{"bufferView", indices}, {"componentType", type}}},
                          {"values", {{"bufferView", replaced}}}};
  };
  const GaussianCloud before = read(written()).cloud;
  for (const int type : {5121, 5123, 5125}) {
    for (const bool keeps_base : {true, false}) {
      SCOPED_TRACE(testing::Message() << type << keeps_base);
      Glb glb = written();
      sparse(glb, "POSITION", type, keeps_base);
      const Scene scene = read(glb);
      EXPECT_THAT(scene.warnings, IsEmpty());
      ASSERT_EQ(scene.cloud.size(), kCount);
      for (std::size_t i = 0; i < kCount; ++i) {
        const glm::vec3 expected = i == 3       ? glm::vec3(-1, -2, 3)
                                   : i == 69    ? glm::vec3(-4, -5, 6)
                                   : keeps_base ? before.positions[i]
                                                : glm::vec3(0);
        EXPECT_EQ(scene.cloud.positions[i], expected) << i;
      }
      EXPECT_EQ(scene.cloud.sh, before.sh);
    }
  }
  const auto broken = [&](const std::function<void(json & sparse)>& change) {
    Glb glb = written();
    sparse(glb, "KHR_gaussian_splatting:SCALE", 5123, true);
    change(accessor_of(glb, "KHR_gaussian_splatting:SCALE"));
    return error_of(glb);
  };
  EXPECT_THAT(broken([](json& a) { a["sparse"]["count"] = 0; }), HasSubstr("cannot be replaced"));
  EXPECT_THAT(broken([](json& a) { a["sparse"]["count"] = 71; }), HasSubstr("cannot be replaced"));
  EXPECT_THAT(broken([](json& a) { a["sparse"]["count"] = 3; }), HasSubstr("do not fit"));
  EXPECT_THAT(broken([](json& a) { a["sparse"]["indices"]["componentType"] = 5126; }),
              HasSubstr("no unsigned integers"));
  EXPECT_THAT(broken([](json& a) { a["sparse"]["indices"]["bufferView"] = 99; }),
              HasSubstr("bufferView 99 does not exist"));
  EXPECT_THAT(broken([](json& a) { a["sparse"]["values"]["byteOffset"] = 4; }),
              HasSubstr("do not fit"));
  EXPECT_THAT(broken([](json& a) { a["sparse"]["values"]["byteOffset"] = -4; }),
              testing::StartsWith("test.glb"));
  EXPECT_THAT(broken([](json& a) { a["sparse"]["indices"]["componentType"] = 5121; }),
              testing::AnyOf(HasSubstr("no error"), HasSubstr("sparse index")));
  EXPECT_THAT(broken([](json& a) {
                a.erase("bufferView");
                a["count"] = 4000000000u;
              }),
              HasSubstr("without values are more"));
  Glb glb = written();
  const std::uint8_t outside[] = {3, 70};
  sparse(glb, "POSITION", 5121, true);
  std::memcpy(glb.binary.data() +
                  glb.description["bufferViews"]
                                 [accessor_of(glb, "POSITION")["sparse"]["indices"]["bufferView"]
                                      .get<std::size_t>()]["byteOffset"]
                                     .get<std::size_t>(),
              outside, 2);
  EXPECT_THAT(error_of(glb), HasSubstr("sparse index 70 is not below 70"));
}

// Every type that the extension allows.
TEST(Gltf, integers_are_read_as_the_extension_says) {
  struct Case {
    const char* attribute;
    int type;
    bool normalized;
    int stored;
    double value;
  };
  const std::string prefix = "KHR_gaussian_splatting:";
  const Case cases[] = {
      {"OPACITY", 5121, true, 51, 0.2},     {"OPACITY", 5123, true, 13107, 0.2},
      {"SCALE", 5121, true, 51, 0.2},       {"SCALE", 5121, false, 3, 3},
      {"SCALE", 5123, true, 13107, 0.2},    {"SCALE", 5123, false, 700, 700},
      {"ROTATION", 5120, true, 127, 0.5},   {"ROTATION", 5120, true, -128, -0.5},
      {"ROTATION", 5122, true, 32767, 0.5}, {"ROTATION", 5122, true, -32768, -0.5}};
  for (const Case& c : cases) {
    SCOPED_TRACE(testing::Message() << c.attribute << " " << c.type << " " << c.stored);
    Glb glb = written(0);
    const std::string name = prefix + c.attribute;
    const std::size_t components = c.attribute[0] == 'O' ? 1 : c.attribute[0] == 'S' ? 3 : 4;
    const std::size_t size = c.type < 5122 ? 1 : 2;
    const std::size_t stride = components * size + (4 - components * size % 4) % 4;
    std::vector<std::byte> bytes(stride * kCount);
    for (std::size_t i = 0; i < kCount; ++i)
      for (std::size_t k = 0; k < components; ++k)  // x stays positive: the sign is the others'
        for (std::size_t b = 0; b < size; ++b)
          bytes[i * stride + k * size + b] = static_cast<std::byte>(c.stored >> (8 * b));
    const std::size_t view = add_view(glb, bytes.data(), bytes.size());
    glb.description["bufferViews"][view]["byteStride"] = stride;
    json& accessor = accessor_of(glb, name);
    accessor["bufferView"] = view;
    accessor["componentType"] = c.type;
    accessor["normalized"] = c.normalized;
    const Scene scene = read(glb);
    if (c.value < 1) {
      EXPECT_THAT(scene.warnings, IsEmpty());
    }
    const GaussianCloud& cloud = scene.cloud;
    for (const std::size_t i : {0u, 69u}) {
      if (components == 1)
        EXPECT_NEAR(cloud.opacity_logits[i], std::log(c.value / (1 - c.value)), 1e-5);
      else if (components == 3)
        EXPECT_NEAR(cloud.log_scales[i].z, std::log(c.value), 1e-5);
      else  // turned about z to RDF: x and y change their sign
        EXPECT_NEAR(cloud.rotations[i].w * c.value, 0.25, 1e-3);
    }
  }
}

TEST(Gltf, linear_colours_are_converted_and_unknown_methods_are_named) {
  Glb glb = written(1);
  auto& extension =
      glb.description["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"];
  float* const base = floats(glb, "KHR_gaussian_splatting:SH_DEGREE_0_COEF_0");
  // 0.5 + C0 * dc; values of the transfer function from IEC 61966-2-1.
  const std::pair<double, double> cases[] = {{0, 0},
                                             {0.001, 0.01292},
                                             {0.0031308, 0.04045},
                                             {0.18, 0.461356},
                                             {0.5, 0.735357},
                                             {0.73, 0.870345},
                                             {1, 1}};
  for (std::size_t i = 0; i < std::size(cases); ++i)
    for (std::size_t c = 0; c < 3; ++c)
      base[3 * i + c] = static_cast<float>((cases[i].first - 0.5) / 0.28209479177387814);
  const GaussianCloud before = read(glb).cloud;
  extension["colorSpace"] = "lin_rec709_display";
  extension["sortingMethod"] = "zDepth";
  extension["projection"] = "fisheye";
  const Scene scene = read(glb);
  EXPECT_THAT(scene.warnings,
              testing::UnorderedElementsAre(HasSubstr("converted to sRGB"),
                                            HasSubstr("Sorting method 'zDepth' is not known"),
                                            HasSubstr("Projection 'fisheye' is not known")));
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    EXPECT_NEAR(0.5 + 0.28209479177387814 * scene.cloud.sh[4 * i].y, cases[i].second, 2e-5);
    // View-dependent parts keep their shape.
    const glm::vec3 &a = before.sh[4 * i + 1], &b = before.sh[4 * i + 2];
    const glm::vec3 &x = scene.cloud.sh[4 * i + 1], &y = scene.cloud.sh[4 * i + 2];
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c] * y[c], b[c] * x[c], 1e-4);
  }
  // A small view-dependent part has the slope of the function: 1.055 / 2.4 * 0.5^(1 / 2.4 - 1).
  float* const first = floats(glb, "KHR_gaussian_splatting:SH_DEGREE_1_COEF_0");
  for (std::size_t k = 0; k < 3; ++k)
    floats(glb, "KHR_gaussian_splatting:SH_DEGREE_1_COEF_" + std::to_string(k))[12] = 0;
  first[12] = 0.01f;
  EXPECT_NEAR(read(glb).cloud.sh[4 * 4 + 1].x / -0.01f, -0.658646 * -1, 2e-3);
}

TEST(Gltf, an_absent_kernel_or_colour_space_is_assumed_and_said) {
  Glb glb = written(0);
  auto& extension =
      glb.description["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"];
  extension.erase("kernel");
  extension.erase("colorSpace");
  EXPECT_THAT(read(glb).warnings, ElementsAre("The file names no kernel; ellipses were assumed.",
                                              "The file names no colour space; sRGB was assumed."));
}

TEST(Gltf, numbers_below_0_and_unknown_required_extensions_are_refused) {
  for (const char* key : {"byteOffset", "count"}) {
    Glb glb = written(0);
    glb.description["accessors"][1][key] = -4;
    EXPECT_THAT(error_of(glb),
                HasSubstr(std::string("accessors[1]: ") + key + " is not a number from 0 on"));
  }
  Glb glb = written(0);
  glb.description["extensionsRequired"] = {"KHR_gaussian_splatting", "EXT_meshopt_compression"};
  EXPECT_THAT(error_of(glb), HasSubstr("requires the glTF extension 'EXT_meshopt_compression'"));
  glb.description["extensionsRequired"] = {"KHR_gaussian_splatting", "KHR_materials_unlit"};
  EXPECT_EQ(read(glb).cloud.size(), kCount);
}

TEST(Gltf, compressed_gaussians_must_be_as_many_as_announced) {
  Glb glb = open_glb(file_bytes(committed_corpus() / "valid/glb_spz2.glb"));
  const GaussianCloud cloud = read(glb).cloud;
  EXPECT_GT(cloud.size(), 0u);
  auto& accessor =
      glb.description["accessors"]
                     [glb.description["meshes"][0]["primitives"][0]["attributes"]["POSITION"]
                          .get<std::size_t>()];
  accessor["count"] = cloud.size() + 1;
  EXPECT_THAT(error_of(glb), HasSubstr("POSITION announces"));
}

TEST(Gltf, the_lengths_of_the_header_and_the_chunks_must_add_up) {
  const auto error_with = [](std::size_t added, std::uint32_t announced) {
    std::vector<std::byte> bytes = make_glb(written());
    const auto length = static_cast<std::uint32_t>(bytes.size()) + announced;
    std::memcpy(bytes.data() + 8, &length, sizeof length);
    bytes.resize(bytes.size() + added);
    Scene scene;
    scene.path = "test.glb";
    ThreadPool pool(1);
    return test::error_of([&] { read_gltf(bytes, scene.path, pool, {}, scene); });
  };
  EXPECT_EQ(error_with(0, 0), "");
  EXPECT_THAT(error_with(4, 0), HasSubstr("test.glb: the header announces "));
  EXPECT_THAT(error_with(4, 4), HasSubstr("test.glb: 4 bytes follow the last chunk"));
}

TEST(Gltf, single_negative_scales_are_no_logarithms) {
  Glb glb = written();
  floats(glb, "KHR_gaussian_splatting:SCALE")[4] = -1e-6f;
  const Scene scene = read(glb);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("negative scale")));
  EXPECT_EQ(scene.cloud.log_scales[1].y, -INFINITY);
}

TEST(Gltf, normalised_integers_are_read) {
  Glb glb = written(0);
  json& d = glb.description;
  const std::size_t accessor =
      d["meshes"][0]["primitives"][0]["attributes"]["KHR_gaussian_splatting:OPACITY"];
  const std::size_t view = d["accessors"][accessor]["bufferView"];
  d["accessors"][accessor]["componentType"] = 5121;
  d["accessors"][accessor]["normalized"] = true;
  const std::size_t offset = d["bufferViews"][view]["byteOffset"];
  for (std::size_t i = 0; i < kCount; ++i) glb.binary[offset + i] = std::byte{51};  // 0.2
  EXPECT_NEAR(read(glb).cloud.opacity_logits[7], std::log(0.2 / 0.8), 1e-6);
}

TEST(Gltf, degree_4_is_cut_to_degree_3) {
  Glb glb = written(3);
  auto& attributes = glb.description["meshes"][0]["primitives"][0]["attributes"];
  const GaussianCloud before = read(glb).cloud;
  for (int k = 0; k < 9; ++k) {
    attributes["KHR_gaussian_splatting:SH_DEGREE_4_COEF_" + std::to_string(k)] =
        attributes["KHR_gaussian_splatting:SH_DEGREE_3_COEF_0"];
  }
  const Scene scene = read(glb);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("degree 4 were cut")));
  EXPECT_EQ(scene.cloud.sh_degree, 3);
  EXPECT_EQ(scene.cloud.sh, before.sh);
}

TEST(Gltf, files_without_gaussians_are_told_apart) {
  Glb glb = written(0);
  glb.description["meshes"][0]["primitives"][0].erase("extensions");
  EXPECT_THAT(error_of(glb), HasSubstr("not a splat file"));
  glb.description["extensionsUsed"] = {"KHR_spz_gaussian_splats_compression"};
  EXPECT_THAT(error_of(glb), HasSubstr("withdrawn draft"));
}

TEST(Gltf, missing_attributes_are_named) {
  Glb glb = written(1);
  auto& attributes = glb.description["meshes"][0]["primitives"][0]["attributes"];
  attributes.erase("KHR_gaussian_splatting:SH_DEGREE_1_COEF_2");
  EXPECT_THAT(error_of(glb), HasSubstr("SH_DEGREE_1_COEF_2 is missing"));
  attributes.erase("KHR_gaussian_splatting:ROTATION");
  EXPECT_THAT(error_of(glb), HasSubstr("ROTATION is missing"));
}

}  // namespace
}  // namespace qs::test
