// SPDX-License-Identifier: MIT
//
// Written .sog files: the texels by PlayCanvas's definition, the codebooks and palettes.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/bytes/zip.h"
#include "io/picture/webp_image.h"
#include "io/scene/sog/palette.h"
#include "raster/scene/cloud_order.h"
#include "support/corpus.h"
#include "support/pool.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;

struct SogFile {
  std::vector<std::string> names;
  json meta;
  std::map<std::string, std::pair<WebpSize, Array<std::uint8_t>>> pictures;

  const std::uint8_t* texel(const std::string& name, std::size_t i) const {
    return &pictures.at(name).second[4 * i];
  }
};

SogFile written_sog(const GaussianCloud& cloud) {
  const TemporaryFolder folder;
  write_scene(cloud, folder / "a.sog");
  const auto bytes = file_bytes(folder / "a.sog");
  SogFile file;
  for (const ZippedFile& entry : zip_directory(bytes, "a.sog")) {
    EXPECT_EQ(entry.method, 0) << entry.name << " is compressed already";
    file.names.push_back(entry.name);
    const auto content = unzipped(entry, "a.sog");
    if (entry.name == "meta.json")
      file.meta = json::parse(reinterpret_cast<const char*>(content.data()),
                              reinterpret_cast<const char*>(content.data()) + content.size());
    else
      file.pictures[entry.name] = {webp_size(content, entry.name),
                                   decode_webp(content, entry.name)};
  }
  return file;
}

TEST(SogWriter, texels_are_as_playcanvas_defines_them) {
  GaussianCloud cloud = random_cloud(300, 2, 7);
  cloud.antialiased = true;
  const SogFile file = written_sog(cloud);
  EXPECT_THAT(file.names,
              ElementsAre("meta.json", "means_l.webp", "means_u.webp", "scales.webp", "quats.webp",
                          "sh0.webp", "shN_centroids.webp", "shN_labels.webp"));
  EXPECT_EQ(file.meta["version"], 2);
  EXPECT_EQ(file.meta["count"], 300);
  EXPECT_EQ(file.meta["model"], "antialiased");
  EXPECT_EQ(file.meta["shN"]["bands"], 2);
  EXPECT_EQ(file.meta["shN"]["count"], 300);
  for (const auto& [name, picture] : file.pictures) {
    const bool is_palette = name == "shN_centroids.webp";
    EXPECT_EQ(picture.first.width, is_palette ? 64u * 8 : 20u) << name;
    EXPECT_EQ(picture.first.height, is_palette ? 5u : 16u) << name;
  }
  const GaussianCloud ordered = select(cloud, morton_order(cloud));
  const json &means = file.meta["means"], &sh = file.meta["shN"];
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    const auto* low = file.texel("means_l.webp", i);
    const auto* high = file.texel("means_u.webp", i);
    const auto* quat = file.texel("quats.webp", i);
    const auto* color = file.texel("sh0.webp", i);
    const auto* label_texel = file.texel("shN_labels.webp", i);
    const std::size_t label = label_texel[0] + 256u * label_texel[1];
    ASSERT_LT(label, 300u);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double from = means["mins"][axis], to = means["maxs"][axis];
      const double stored = from + (to - from) * (low[axis] + 256 * high[axis]) / 65535;
      const double position = ordered.positions[i][static_cast<int>(axis)];
      EXPECT_NEAR(stored, std::copysign(std::log(std::abs(position) + 1), position),
                  (to - from) / 65535 * 0.501);
      for (std::size_t k = 0; k < 8; ++k) {
        const std::size_t at = label / 64 * 64 * 8 + label % 64 * 8 + k;
        const double value = sh["codebook"][file.texel("shN_centroids.webp", at)[axis]];
        EXPECT_NEAR(value, ordered.sh[9 * i + 1 + k][static_cast<int>(axis)], 0.03) << k;
      }
    }
    const double opacity = 1 / (1 + std::exp(-static_cast<double>(ordered.opacity_logits[i])));
    EXPECT_NEAR(color[3] / 255.0, opacity, 0.501 / 255);
    const glm::quat& q = ordered.rotations[i];
    const double wxyz[] = {q.w, q.x, q.y, q.z};
    const std::size_t largest = quat[3] - 252u;
    ASSERT_LT(largest, 4u);
    const double sign = wxyz[largest] < 0 ? -1 : 1;
    for (std::size_t k = 0, next = 0; k < 4; ++k) {
      EXPECT_GE(std::abs(wxyz[largest]), std::abs(wxyz[k]) - 1e-6);
      if (k == largest) continue;
      EXPECT_NEAR((quat[next++] / 255.0 * 2 - 1) / std::sqrt(2), sign * wxyz[k], 0.0028);
    }
  }
}

TEST(SogWriter, infinite_logits_and_flat_gaussians_are_kept) {
  GaussianCloud cloud = random_cloud(4, 0, 7);
  cloud.opacity_logits = {INFINITY, -INFINITY, 0, 1};
  for (glm::vec3& scale : cloud.log_scales) scale = glm::vec3(-INFINITY, -2, -1);
  cloud.positions = {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}, {1, 2, 3}};  // without an extent
  const TemporaryFolder folder;
  write_scene(cloud, folder / "a.sog");
  const Scene scene = read_scene(folder / "a.sog");
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.cloud.opacity_logits[0], INFINITY);
  EXPECT_EQ(scene.cloud.opacity_logits[1], -INFINITY);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(scene.cloud.log_scales[i], glm::vec3(-30, -2, -1));
    EXPECT_NEAR(scene.cloud.positions[i].x, 1, 1e-6);
    EXPECT_NEAR(scene.cloud.positions[i].z, 3, 1e-6);
  }
}

// More Gaussians than the palette has entries.
TEST(SogWriter, equal_sh_of_many_gaussians_are_one_entry) {
  constexpr std::size_t kMany = 70000;
  GaussianCloud cloud = random_cloud(kMany, 1, 7);
  for (std::size_t i = 0; i < kMany; ++i)
    for (std::size_t k = 1; k < 4; ++k) cloud.sh[4 * i + k] = glm::vec3(0.25f, -0.5f, 0.125f);
  const SogFile file = written_sog(cloud);
  EXPECT_EQ(file.meta["shN"]["count"], 1);
  for (std::size_t i = 0; i < kMany; ++i) ASSERT_EQ(file.texel("shN_labels.webp", i)[0], 0);
}

TEST(Codebook, few_values_are_exact_and_many_have_small_errors) {
  Array<float> few;
  for (int i = 0; i < 5000; ++i) few.push_back(static_cast<float>(i % 250) * 0.37f - 20);
  const Codebook exact = make_codebook(few);
  for (const float value : few) ASSERT_EQ(exact.values[exact.nearest(value)], value);
  EXPECT_TRUE(std::ranges::is_sorted(exact.values));

  Array<float> many;
  std::mt19937 engine(3);
  std::normal_distribution<float> normal(-5, 1.5f);
  for (int i = 0; i < 100000; ++i) many.push_back(normal(engine));
  many.push_back(25);  // an outlier takes one entry
  const Codebook codebook = make_codebook(many);
  EXPECT_EQ(codebook.values.back(), 25);
  double square = 0;
  for (const float value : many) {
    const float stored = codebook.values[codebook.nearest(value)];
    square += std::pow(static_cast<double>(stored - value), 2);
    // No other entry is nearer.
    for (const float other : codebook.values)
      ASSERT_LE(std::abs(stored - value), std::abs(other - value));
  }
  // The least possible rms of 256 entries is sigma sqrt(sqrt(3) pi / 2) / 256 (Panter and Dite).
  EXPECT_LT(std::sqrt(square / static_cast<double>(many.size())), 1.1 * 1.5 * 1.6495 / 256);
}

TEST(Codebook, a_sample_of_many_vectors_has_all_axes) {
  Array<float> vectors(2'400'000);
  for (std::size_t i = 0; i < vectors.size(); ++i)
    vectors[i] = static_cast<float>(i % 3) + static_cast<float>(i % 977) / 1000;
  const Codebook codebook = make_codebook(vectors);
  for (const float axis : {0.0f, 1.0f, 2.0f})
    EXPECT_GE(
        std::ranges::count_if(codebook.values, [&](float v) { return std::floor(v) == axis; }), 80);
}

TEST(Codebook, one_value_fills_it) {
  const Codebook codebook = make_codebook({-3.5f});
  for (const float value : codebook.values) EXPECT_EQ(value, -3.5f);
  EXPECT_EQ(codebook.values[codebook.nearest(100)], -3.5f);
  EXPECT_EQ(codebook.nearest(-100), 0);
}

// 40 blobs in 6 dimensions.
Array<float> blobs(std::size_t count) {
  std::mt19937 engine(9);
  std::normal_distribution<float> normal;
  std::vector<float> centres(40 * 6);
  for (float& value : centres) value = 3 * normal(engine);
  Array<float> rows;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t d = 0; d < 6; ++d)
      rows.push_back(centres[i % 40 * 6 + d] + 0.1f * normal(engine));
  return rows;
}

double rms(const Array<float>& rows, const Palette& palette) {
  double square = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    square += std::pow(rows[i] - palette.values[palette.label[i / 6] * 6 + i % 6], 2);
  return std::sqrt(square / static_cast<double>(rows.size()));
}

TEST(Palette, as_many_entries_as_rows_are_exact) {
  ThreadPool pool(2);
  const Array<float> rows = blobs(500);
  EXPECT_EQ(rms(rows, make_palette({rows.data(), 500, 6, 6}, 500, pool, {})), 0);
}

TEST(Palette, errors_shrink_with_the_entries) {
  ThreadPool pool(2);
  const Array<float> rows = blobs(40000);
  double before = INFINITY;
  for (const std::size_t most : {1u, 40u, 200u, 1000u, 5000u, 20000u}) {
    const Palette palette = make_palette({rows.data(), 40000, 6, 6}, most, pool, {});
    EXPECT_LE(palette.size(), most);
    EXPECT_GT(palette.size(), most * 2 / 3);
    for (const std::uint32_t label : palette.label) ASSERT_LT(label, palette.size());
    const double error = rms(rows, palette);
    // The least rms of a blob with N entries is about 0.1225 N^(-1/6) (Zador, with the lattice
    // E6*).
    if (most >= 1000 && most <= 5000) {
      EXPECT_LT(error, 1.25 * 0.1225 * std::pow(static_cast<double>(most) / 40, -1.0 / 6)) << most;
    }
    EXPECT_LT(error, before) << most;
    before = error;
  }
}

}  // namespace
}  // namespace qs::test
