// SPDX-License-Identifier: MIT
//
// SOG scenes built here from PlayCanvas's definition: both versions, every number of bands, trees,
// and every limit with its message.
#include "io/scene/sog/sog.h"

#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <webp/encode.h>

#include "base/error.h"
#include "io/bytes/file_source.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using Rgba = std::array<std::uint8_t, 4>;

void write_picture(const std::filesystem::path& path, int width, int height,
                   const std::function<Rgba(std::size_t texel)>& color) {
  std::vector<std::uint8_t> rgba;
  for (std::size_t i = 0; i < static_cast<std::size_t>(width * height); ++i) {
    for (const std::uint8_t value : color(i)) rgba.push_back(value);
  }
  std::uint8_t* packed = nullptr;
  const std::size_t size = WebPEncodeLosslessRGBA(rgba.data(), width, height, 4 * width, &packed);
  ASSERT_GT(size, 0u);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(packed), static_cast<std::streamsize>(size));
  WebPFree(packed);
}

std::uint8_t stored(std::size_t texel, std::size_t field) {
  return static_cast<std::uint8_t>((texel * 61 + field * 37 + 5) % 255 + 1);
}
Rgba stored_4(std::size_t texel, std::size_t field) {
  return {stored(texel, field), stored(texel, field + 1), stored(texel, field + 2),
          stored(texel, field + 3)};
}

constexpr std::size_t kCount = 20, kPalette = 70;
constexpr int kWidth = 7, kHeight = 3;  // of the pictures

json codebook(double first, double step) {
  json list = json::array();
  for (int i = 0; i < 256; ++i) list.push_back(first + step * i);
  return list;
}

// The description, and the pictures beside it.
json make_scene(const std::filesystem::path& folder, int version, std::size_t bands) {
  std::filesystem::create_directories(folder);
  const auto picture = [&](const char* name, const std::function<Rgba(std::size_t)>& color) {
    write_picture(folder / name, kWidth, kHeight, color);
  };
  const auto opaque = [](std::size_t texel, std::size_t field) {
    Rgba rgba = stored_4(texel, field);
    rgba[3] = 255;
    return rgba;
  };
  picture("low.webp", [&](std::size_t i) { return opaque(i, 0); });
  picture("high.webp", [&](std::size_t i) { return opaque(i, 3); });
  picture("scales.webp", [&](std::size_t i) { return opaque(i, 6); });
  picture("quats.webp", [&](std::size_t i) {
    Rgba rgba = opaque(i, 9);
    for (std::size_t k = 0; k < 3; ++k)  // shorter than 1
      rgba[k] = static_cast<std::uint8_t>(64 + rgba[k] / 2);
    rgba[3] = static_cast<std::uint8_t>(252 + i % 4);
    return rgba;
  });
  picture("sh0.webp", [&](std::size_t i) { return stored_4(i, 12); });
  json meta;
  meta["means"] = {
      {"mins", {-2, -1, 0.5}}, {"maxs", {1, 3, 2}}, {"files", {"low.webp", "high.webp"}}};
  meta["scales"]["files"] = {"scales.webp"};
  meta["quats"]["files"] = {"quats.webp"};
  meta["sh0"]["files"] = {"sh0.webp"};
  if (version == 2) {
    meta["version"] = 2;
    meta["count"] = kCount;
    meta["scales"]["codebook"] = codebook(-8, 0.03);
    meta["sh0"]["codebook"] = codebook(-1.5, 0.015);
  } else {
    meta["means"]["shape"] = {kCount, 3};
    meta["scales"]["mins"] = {-8, -7, -6};
    meta["scales"]["maxs"] = {0, 1, 2};
    meta["sh0"]["mins"] = {-1, -2, -3, -6};
    meta["sh0"]["maxs"] = {2, 1, 0, 7};
    meta["quats"]["encoding"] = "quaternion_packed";
  }
  if (bands == 0) return meta;
  const int rest = static_cast<int>((bands + 1) * (bands + 1) - 1);
  picture("labels.webp", [](std::size_t i) {
    return Rgba{static_cast<std::uint8_t>((7 * i + 1) % kPalette), 0, 0, 255};
  });
  write_picture(folder / "centroids.webp", 64 * rest, 2,
                [&](std::size_t i) { return opaque(i, 20); });
  meta["shN"]["files"] = {"centroids.webp", "labels.webp"};
  if (version == 2) {
    meta["shN"]["count"] = kPalette;
    meta["shN"]["bands"] = bands;
    meta["shN"]["codebook"] = codebook(-0.7, 0.005);
  } else {
    meta["shN"]["mins"] = -0.5;
    meta["shN"]["maxs"] = 0.75;
  }
  return meta;
}

void save(const std::filesystem::path& path, const json& description) {
  std::ofstream(path) << description;
}

double evenly(double low, double high, std::uint8_t byte) {
  return low + (high - low) * byte / 255;
}

void expect_gaussian(const GaussianCloud& cloud, std::size_t i, std::size_t texel, int version,
                     std::size_t bands) {
  SCOPED_TRACE(testing::Message() << "Gaussian " << texel);
  const double mins[] = {-2, -1, 0.5}, maxs[] = {1, 3, 2};
  const std::size_t n = static_cast<std::size_t>((cloud.sh_degree + 1) * (cloud.sh_degree + 1));
  for (std::size_t a = 0; a < 3; ++a) {
    const int axis = static_cast<int>(a);
    const double t = (stored(texel, a) + 256.0 * stored(texel, 3 + a)) / 65535;
    const double v = mins[a] + (maxs[a] - mins[a]) * t;
    EXPECT_NEAR(cloud.positions[i][axis], (v < 0 ? -1 : 1) * (std::exp(std::abs(v)) - 1), 2e-6);
    const double low = -8.0 + axis;
    EXPECT_NEAR(cloud.log_scales[i][axis],
                version == 2 ? -8 + 0.03 * stored(texel, 6 + a)
                             : evenly(low, low + 8, stored(texel, 6 + a)),
                1e-6);
    EXPECT_NEAR(cloud.sh[i * n][axis],
                version == 2 ? -1.5 + 0.015 * stored(texel, 12 + a)
                             : evenly(-1.0 - axis, 2.0 - axis, stored(texel, 12 + a)),
                1e-6);
  }
  const double alpha = stored(texel, 15) / 255.0;
  if (version == 2 && alpha == 1) {
    EXPECT_EQ(cloud.opacity_logits[i], INFINITY);
  } else {
    EXPECT_NEAR(cloud.opacity_logits[i],
                version == 2 ? std::log(alpha / (1 - alpha)) : evenly(-6, 7, stored(texel, 15)),
                1e-5);
  }
  const glm::quat& q = cloud.rotations[i];
  const float wxyz[] = {q.w, q.x, q.y, q.z};
  double square = 0;
  for (std::size_t k = 0, next = 0; k < 4; ++k) {
    if (k == texel % 4) continue;
    const int byte = 64 + stored(texel, 9 + next++) / 2;
    const double value = (byte / 127.5 - 1) * std::sqrt(0.5);
    square += value * value;
    EXPECT_NEAR(wxyz[k], value, 1e-6);
  }
  EXPECT_NEAR(wxyz[texel % 4], std::sqrt(1 - square), 1e-6);
  const std::size_t rest = (bands + 1) * (bands + 1) - 1, label = (7 * texel + 1) % kPalette;
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const std::size_t at = label / 64 * 64 * rest + label % 64 * rest + k;
    for (std::size_t c = 0; c < 3; ++c) {
      const double value =
          version == 2 ? -0.7 + 0.005 * stored(at, 20 + c) : evenly(-0.5, 0.75, stored(at, 20 + c));
      EXPECT_NEAR(cloud.sh[i * n + 1 + k][static_cast<int>(c)], k < rest ? value : 0, 1e-6) << k;
    }
  }
}

std::string error_of(const std::filesystem::path& path) {
  return test::error_of([&] { read_scene(path); }, path.parent_path());
}

TEST(Sog, values_of_both_versions_and_all_bands_are_read) {
  for (const int version : {1, 2}) {
    for (const std::size_t bands : {0u, 1u, 2u, 3u}) {
      SCOPED_TRACE(testing::Message() << "version " << version << ", bands " << bands);
      const TemporaryFolder folder;
      save(folder / "meta.json", make_scene(folder.path(), version, bands));
      const Scene scene = read_scene(folder / "meta.json");
      EXPECT_EQ(scene.format, "sog, version " + std::to_string(version) + ", folder");
      EXPECT_THAT(scene.warnings, IsEmpty());
      ASSERT_EQ(scene.cloud.size(), kCount);
      ASSERT_EQ(scene.cloud.sh_degree, static_cast<int>(bands));
      std::uint64_t bytes = 0;
      for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        bytes += entry.file_size();
      EXPECT_EQ(scene.file_bytes, bytes);
      for (std::size_t i = 0; i < kCount; ++i) expect_gaussian(scene.cloud, i, i, version, bands);
    }
  }
}

TEST(Sog, the_model_says_how_the_gaussians_were_trained) {
  const TemporaryFolder folder;
  json meta = make_scene(folder.path(), 2, 0);
  const auto read_with = [&](const json& model) {
    if (!model.is_null()) meta["model"] = model;
    save(folder / "meta.json", meta);
    return read_scene(folder / "meta.json");
  };
  EXPECT_FALSE(read_with(nullptr).cloud.antialiased);
  EXPECT_TRUE(read_with("antialiased").cloud.antialiased);
  EXPECT_THAT(read_with("antialiased").warnings, IsEmpty());
  EXPECT_FALSE(read_with("default").cloud.antialiased);
  EXPECT_THAT(read_with("default").warnings, IsEmpty());
  EXPECT_THAT(read_with("2dgs").warnings, ElementsAre(testing::HasSubstr("2D Gaussians")));
  EXPECT_THAT(read_with("3dcs").warnings, ElementsAre(testing::HasSubstr("'3dcs' is not known")));
}

TEST(Sog, the_model_of_a_tree_holds_for_parts_without_one) {
  const TemporaryFolder folder;
  for (const char* of_tree : {"", "default", "antialiased"}) {
    for (const char* of_part : {"", "default", "antialiased"}) {
      SCOPED_TRACE(testing::Message() << of_tree << " " << of_part);
      json meta = make_scene(folder / "0", 2, 0);
      if (*of_part != 0) meta["model"] = of_part;
      save(folder / "0/meta.json", meta);
      json tree = {{"lodLevels", 1},
                   {"filenames", {"0/meta.json"}},
                   {"tree", {{"lods", {{"0", {{"file", 0}, {"offset", 0}, {"count", 4}}}}}}}};
      if (*of_tree != 0) tree["model"] = of_tree;
      save(folder / "lod-meta.json", tree);
      const std::string model = *of_part != 0 ? of_part : of_tree;
      EXPECT_EQ(read_scene(folder / "lod-meta.json").cloud.antialiased, model == "antialiased");
    }
  }
}

// Ten and more levels: as texts, "10" comes before "9".
TEST(Sog, the_finest_level_of_a_tree_has_the_lowest_number) {
  const TemporaryFolder folder;
  save(folder / "0/meta.json", make_scene(folder / "0", 2, 0));
  const auto part = [](int offset, int count) {
    return json{{"file", 0}, {"offset", offset}, {"count", count}};
  };
  const json tree = {
      {"filenames", {"0/meta.json"}},
      {"tree",
       {{"children",
         {{{"lods", {{"9", part(0, 4)}, {"10", part(4, 2)}, {"11", part(6, 1)}}}},
          {{"lods", {{"0", part(7, 3)}, {"1", part(10, 2)}, {"12", part(12, 1)}}}}}}}}};
  save(folder / "lod-meta.json", tree);
  const Scene scene = read_scene(folder / "lod-meta.json");
  EXPECT_EQ(scene.cloud.size(), 7u);
  EXPECT_EQ(scene.levels, (LevelsOfDetail{.levels = 6, .nodes = 3, .leaves = 7, .merged = 6}));
}

TEST(Sog, version_3_is_refused_by_name) {
  const TemporaryFolder folder;
  for (json meta : {json{{"version", 3}}, json{{"version", 3}, {"means", {}}, {"quats", {}}}}) {
    save(folder / "meta.json", meta);
    EXPECT_THAT(error_of(folder / "meta.json"),
                testing::HasSubstr("SOG version 3, but versions 1 and 2 are read"));
  }
}

TEST(Sog, gaussians_without_a_rotation_or_a_label_are_counted) {
  const TemporaryFolder folder;
  json meta = make_scene(folder.path(), 2, 1);
  meta["shN"]["count"] = 64;
  save(folder / "meta.json", meta);
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < kCount; ++i) beyond += (7 * i + 1) % kPalette >= 64 ? 1 : 0;
  ASSERT_GT(beyond, 0u);
  write_picture(folder / "quats.webp", kWidth, kHeight, [](std::size_t i) {
    return Rgba{128, 128, 128, static_cast<std::uint8_t>(i < 3 ? 251 : 252)};
  });
  EXPECT_THAT(read_scene(folder / "meta.json").warnings,
              ElementsAre("3 of 20 Gaussians have no valid rotation and were left unrotated.",
                          std::to_string(beyond) +
                              " Gaussians have only their base colour: their spherical harmonics "
                              "are not in the palette."));
}

TEST(Sog, a_description_at_a_limit_is_read_and_one_beyond_is_refused) {
  const TemporaryFolder folder;
  const json good = make_scene(folder.path(), 2, 2), old = make_scene(folder.path(), 1, 2);
  struct Row {
    const json& base;
    const char* pointer;
    json value;  // null: removed
    const char* message;
  };
  json long_book = codebook(0, 1), text_book = codebook(0, 1);
  long_book.push_back(1);
  text_book[255] = "1";
  const Row rows[] = {
      {good, "/version", 2.0, ""},
      {good, "/version", 3, "meta.json: SOG version 3, but versions 1 and 2 are read"},
      {good, "/version", 0, "meta.json: SOG version 0, but versions 1 and 2 are read"},
      {good, "/count", 21, ""},
      {good, "/count", 1, ""},
      {good, "/count", 22, "meta.json: low.webp: 7 x 3 pixels are too few for 22 Gaussians"},
      {good, "/count", 0, "meta.json: count is 0, but must be a whole number from 1 up"},
      {good, "/count", 2.5, "meta.json: count is 2.5, but must be a whole number from 1 up"},
      {good, "/count", 2e12,
       "meta.json: count is 2000000000000, but must be a whole number from 1 up"},
      {good, "/count", "20", "meta.json: count is not a number"},
      {good, "/count", nullptr, "meta.json: count is missing"},
      {good, "/means", 3, "meta.json: means is not an object"},
      {good, "/means/files", {"low.webp"}, "meta.json: means: files is not a list of 2 names"},
      {good, "/scales/files", {"a", "b"}, "meta.json: scales: files is not a list of 1 names"},
      {good, "/quats/files", {4}, "meta.json: quats: files is not a list of 1 names"},
      {good, "/means/mins", {1, 2}, "meta.json: means: mins is not a list of 3 numbers"},
      {good, "/means/maxs", {1, 2, "3"}, "meta.json: means: maxs is not a number"},
      {good,
       "/scales/codebook",
       {1, 2},
       "meta.json: scales: codebook is not a list of 256 numbers"},
      {good, "/sh0/codebook", long_book, "meta.json: sh0: codebook is not a list of 256 numbers"},
      {good, "/shN/codebook", text_book, "meta.json: shN: codebook is not a number"},
      {good, "/shN/bands", 4, "meta.json: shN: 4 bands, 1 to 3 exist"},
      {good, "/shN/bands", 3, "meta.json: centroids.webp: 512 pixels wide, 3 bands need 960"},
      {good, "/shN/bands", 1, "meta.json: centroids.webp: 512 pixels wide, 1 bands need 192"},
      {good, "/shN/count", 128, ""},
      {good, "/shN/count", 129,
       "meta.json: centroids.webp: 512 x 2 pixels are too few for 129 rows of coefficients"},
      {good, "/shN/files", {"centroids.webp"}, "meta.json: shN: files is not a list of 2 names"},
      {old, "/means/shape", {20}, ""},
      {old, "/means/shape", json::array(), "meta.json: means: shape is not a list of numbers"},
      {old, "/means/shape", 20, "meta.json: means: shape is not a list of numbers"},
      {old,
       "/means/shape",
       {0.5},
       "meta.json: means: shape is 0.5, but must be a whole number from 1 up"},
      {old, "/scales/shape", {20, 3}, ""},
      {old,
       "/scales/shape",
       {21, 3},
       "meta.json: scales: the shape has 21 Gaussians, that of means 20"},
      {old,
       "/sh0/shape",
       {19, 1, 4},
       "meta.json: sh0: the shape has 19 Gaussians, that of means 20"},
      {old,
       "/quats/shape",
       {19, 4},
       "meta.json: quats: the shape has 19 Gaussians, that of means 20"},
      {old, "/shN/shape", {2, 24}, "meta.json: shN: the shape has 2 Gaussians, that of means 20"},
      {old, "/scales/mins", {1}, "meta.json: scales: mins is not a list of 3 numbers"},
      {old, "/scales/maxs", nullptr, "meta.json: scales: maxs is missing"},
      {old, "/sh0/mins", {1, 2, 3}, "meta.json: sh0: mins is not a list of 4 numbers"},
      {old, "/sh0/maxs", {1, 2, 3}, "meta.json: sh0: maxs is not a list of 4 numbers"},
      {old, "/quats/encoding", "euler", "meta.json: quats: encoding 'euler' is not known"},
      {old, "/quats/encoding", nullptr, ""},
      {old, "/shN/mins", {1}, "meta.json: shN: mins is not a number"},
      {old, "/shN/maxs", nullptr, "meta.json: shN: maxs is missing"},
      {old,
       "/scales/files",
       {"missing.webp"},
       "meta.json: the file missing.webp that it names is missing"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(testing::Message() << row.pointer << " = " << row.value);
    json meta = row.base;
    meta[json::json_pointer(row.pointer)] = row.value;
    save(folder / "meta.json", meta);
    EXPECT_EQ(error_of(folder / "meta.json"), row.message);
  }
}

TEST(Sog, pictures_may_be_as_large_as_their_gaussians_need_and_not_larger) {
  const TemporaryFolder folder;
  json meta = make_scene(folder.path(), 2, 3);
  const auto plain = [](std::size_t) { return Rgba{90, 0, 0, 255}; };
  meta["count"] = 2;
  save(folder / "meta.json", meta);
  write_picture(folder / "scales.webp", 580, 113, plain);  // 2 * 2 + 65536
  EXPECT_EQ(error_of(folder / "meta.json"), "");
  write_picture(folder / "scales.webp", 3121, 21, plain);
  EXPECT_EQ(error_of(folder / "meta.json"),
            "meta.json: scales.webp: 3121 x 21 pixels are more than its 2 Gaussians need");
  std::filesystem::resize_file(folder / "scales.webp", 5 * 65540 + 65536);
  EXPECT_THAT(error_of(folder / "meta.json"), HasSubstr("scales.webp: 3121 x 21 pixels"));
  std::filesystem::resize_file(folder / "scales.webp", 5 * 65540 + 65536 + 1);
  EXPECT_EQ(
      error_of(folder / "meta.json"),
      "meta.json: the file scales.webp has 393237 bytes, more than the 393236 that make sense");

  write_picture(folder / "scales.webp", kWidth, kHeight, plain);
  write_picture(folder / "centroids.webp", 960, 1024, plain);
  EXPECT_EQ(error_of(folder / "meta.json"), "");
  write_picture(folder / "centroids.webp", 960, 1025, plain);
  EXPECT_EQ(error_of(folder / "meta.json"),
            "meta.json: centroids.webp: 960 x 1025 pixels are more than its 2 Gaussians need");
}

TEST(Sog, a_byte_of_pictures_holds_at_most_eight_gaussians) {
  const TemporaryFolder folder;
  json meta = make_scene(folder.path(), 2, 0);
  std::uint64_t bytes = 0;
  for (const char* name : {"low.webp", "high.webp", "scales.webp", "quats.webp", "sh0.webp"}) {
    write_picture(folder / name, 120, 100, [](std::size_t) { return Rgba{90, 80, 70, 255}; });
    bytes += std::filesystem::file_size(folder / name);
  }
  ASSERT_LT(8 * bytes, 120u * 100);
  meta["count"] = 8 * bytes;
  save(folder / "meta.json", meta);
  EXPECT_EQ(error_of(folder / "meta.json"), "");
  meta["count"] = 8 * bytes + 1;
  save(folder / "meta.json", meta);
  EXPECT_EQ(error_of(folder / "meta.json"), "meta.json: " + std::to_string(8 * bytes + 1) +
                                                " Gaussians are announced, more than pictures of " +
                                                std::to_string(bytes) + " bytes can hold");
}

TEST(Sog, descriptions_have_at_most_4_mib) {
  const TemporaryFolder folder;
  std::string text = make_scene(folder.path(), 2, 0).dump();
  text.resize(4u << 20, ' ');
  std::ofstream(folder / "meta.json") << text;
  EXPECT_EQ(error_of(folder / "meta.json"), "");
  std::ofstream(folder / "meta.json") << text << ' ';
  EXPECT_EQ(error_of(folder / "meta.json"), "meta.json: too long for a SOG scene's description");
}

TEST(Sog, is_recognised_by_the_keys_of_its_description) {
  const auto recognised = [](const std::string& text) {
    return recognises_sog(to_bytes(text), "");
  };
  EXPECT_TRUE(recognised(" \t\r\n{\"means\":1,\"quats\":2}"));
  EXPECT_FALSE(recognised("{\"means\":1}"));
  EXPECT_FALSE(recognised("{\"quats\":1}"));
  EXPECT_FALSE(recognised("[\"means\",\"quats\"]"));
  EXPECT_FALSE(recognised("  "));
  EXPECT_TRUE(recognised("PK\x03\x04"));
  EXPECT_TRUE(recognised("PK\x05\x06"));
  const auto tree = [](const std::string& text) {
    return recognises_streamed_sog(to_bytes(text), "");
  };
  EXPECT_TRUE(tree("{\"filenames\":1,\"tree\":2,\"lods\":3}"));
  EXPECT_TRUE(tree("{\"filenames\":1,\"tree\":2}"));
  EXPECT_FALSE(tree("{\"a\":{\"filenames\":1,\"tree\":2}}"));
  EXPECT_FALSE(tree("{\"filenames\":1,\"lods\":2}"));
  EXPECT_FALSE(tree("{\"tree\":1,\"lods\":2}"));
  EXPECT_FALSE(tree("[\"filenames\",\"tree\",\"lods\"]"));
}

// ---- trees of levels of detail ------------------------------------------------------------------
json leaf(json file, json offset, json count) {
  return {{"lods",
           {{"0", {{"file", file}, {"offset", offset}, {"count", count}}},
            {"1", {{"file", 0}, {"offset", 0}, {"count", 1}}}}}};
}

class StreamedSog : public testing::Test {
 protected:
  StreamedSog() {
    const std::pair<const char*, std::size_t> scenes[] = {{"a", 2}, {"b", 1}, {"sky", 0}};
    for (const auto& [name, bands] : scenes) {
      const json meta = make_scene(folder_ / name, 2, bands);
      save(folder_ / name / "meta.json", meta);
    }
  }

  std::string error(const std::vector<json>& leaves) {
    save(tree_, tree(leaves));
    return error_of(tree_);
  }
  static json tree(const std::vector<json>& leaves) {
    return {{"filenames", {"a/meta.json", "b/meta.json"}},
            {"tree", {{"children", {{{"children", leaves}}}}}}};
  }

  TemporaryFolder folder_;
  std::filesystem::path tree_ = folder_ / "lod-meta.json";
};

TEST_F(StreamedSog, takes_the_finest_level_of_each_leaf_and_then_the_environment) {
  json description = tree({leaf(1, 4, 6), leaf(0, 15, 5), leaf(1, 12, 8), leaf(0, 2, 0)});
  description["environment"] = "sky/meta.json";
  save(tree_, description);
  std::vector<float> reported;
  ThreadPool pool(1);  // the first worker reports
  const Scene scene = qs::read_scene(
      tree_, pool, {.progress = {[&](float done) { reported.push_back(done); }, {}}});
  EXPECT_EQ(scene.format, "streamed sog, finest level");
  EXPECT_THAT(scene.warnings, IsEmpty());
  ASSERT_EQ(scene.cloud.size(), 6 + 5 + 8 + kCount);
  ASSERT_EQ(scene.cloud.sh_degree, 2);
  std::uint64_t bytes = std::filesystem::file_size(tree_);
  for (const char* name : {"a", "b", "sky"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / name))
      bytes += entry.file_size();
  }
  EXPECT_EQ(scene.file_bytes, bytes);
  for (std::size_t i = 0; i < 6; ++i) expect_gaussian(scene.cloud, i, 4 + i, 2, 1);
  for (std::size_t i = 0; i < 5; ++i) expect_gaussian(scene.cloud, 6 + i, 15 + i, 2, 2);
  for (std::size_t i = 0; i < 8; ++i) expect_gaussian(scene.cloud, 11 + i, 12 + i, 2, 1);
  for (std::size_t i = 0; i < kCount; ++i) expect_gaussian(scene.cloud, 19 + i, i, 2, 0);
  EXPECT_THAT(reported, ElementsAre(0, 0.125f, 0.25f, 0.375f, 0.5f, 0.5f, 1));
}

TEST_F(StreamedSog, leaves_must_name_existing_gaussians_once) {
  EXPECT_EQ(error({leaf(0, 0, 20)}), "");
  EXPECT_EQ(error({leaf(0, 0, 8), leaf(0, 8, 12)}), "");
  EXPECT_EQ(error({leaf(0, 20, 0), leaf(1, 0, 1)}), "");
  EXPECT_EQ(error({leaf(0, 1, 20)}),
            "lod-meta.json: a leaf names Gaussians 1 to 21 of a file with 20");
  EXPECT_EQ(error({leaf(0, 21, 0)}),
            "lod-meta.json: a leaf names Gaussians 21 to 21 of a file with 20");
  EXPECT_EQ(error({leaf(0, 0, 8), leaf(0, 7, 13)}),
            "lod-meta.json: its leaves name more Gaussians than their files have");
  EXPECT_EQ(error({leaf(0, 0, 0)}), "lod-meta.json: holds no Gaussians");
  EXPECT_EQ(error({leaf(2, 0, 1)}), "lod-meta.json: file 2 is not in the list of files");
  EXPECT_EQ(error({leaf(-1, 0, 1)}),
            "lod-meta.json: file is -1, but must be a whole number from 0 up");
  EXPECT_EQ(error({leaf(0, 0.5, 1)}),
            "lod-meta.json: offset is 0.5, but must be a whole number from 0 up");
  EXPECT_EQ(error({leaf(0, 0, 2e12)}),
            "lod-meta.json: count is 2000000000000, but must be a whole number from 0 up");
  EXPECT_EQ(error({leaf(0, 0, "1")}), "lod-meta.json: count is not a number");
}

// Every leaf() has 1 Gaussian in level 1.
TEST_F(StreamedSog, totals_that_the_description_states_are_those_of_its_tree) {
  const auto message = [&](const json& totals) {
    json description = tree({leaf(0, 0, 8), leaf(1, 0, 5)});
    description["environment"] = "sky/meta.json";  // does not count
    description.update(totals);
    save(tree_, description);
    return error_of(tree_);
  };
  EXPECT_EQ(message({{"count", 15}, {"counts", {13, 2}}}), "");
  EXPECT_EQ(message({{"counts", {13, 2, 0}}}), "");
  EXPECT_EQ(message({{"count", 14}}), "lod-meta.json: count is 14, but its tree has 15 Gaussians");
  EXPECT_EQ(message({{"count", 35}}), "lod-meta.json: count is 35, but its tree has 15 Gaussians");
  EXPECT_EQ(message({{"counts", {12, 3}}}),
            "lod-meta.json: counts has 12 Gaussians in level 0, but its tree has 13");
  EXPECT_EQ(message({{"counts", {13}}}),
            "lod-meta.json: counts has 0 Gaussians in level 1, but its tree has 2");
  EXPECT_EQ(message({{"counts", {13, 2, 1}}}),
            "lod-meta.json: counts has 1 Gaussians in level 2, but its tree has 0");
  EXPECT_EQ(message({{"counts", 15}}), "lod-meta.json: counts is not a list");
  EXPECT_EQ(message({{"counts", {"a", 2}}}), "lod-meta.json: counts is not a number");
}

TEST_F(StreamedSog, wrong_kinds_of_values_are_named) {
  const auto message = [&](const char* pointer, const json& value) {
    json description = tree({leaf(0, 0, 20)});
    description[json::json_pointer(pointer)] = value;
    save(tree_, description);
    return error_of(tree_);
  };
  EXPECT_EQ(message("/filenames", "a"), "lod-meta.json: filenames is not a list");
  EXPECT_EQ(message("/filenames/1", 3), "lod-meta.json: filenames has something else than names");
  EXPECT_EQ(message("/tree", 3), "lod-meta.json: not a tree of levels of detail");
  EXPECT_EQ(message("/tree/children", 3), "lod-meta.json: children is not a list");
  EXPECT_EQ(message("/tree/children/0", 3), "lod-meta.json: not a tree of levels of detail");
  EXPECT_EQ(message("/environment", 3), "lod-meta.json: environment is not a string");
  EXPECT_EQ(message("/environment", "none/meta.json"),
            "lod-meta.json: the file none/meta.json that it names is missing");
}

}  // namespace
}  // namespace qs::test
