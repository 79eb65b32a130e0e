// SPDX-License-Identifier: MIT
#include <cmath>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/scene/compact/compact_model.h"
#include "io/support/zip_archive.h"
#include "io/tensor/npy.h"
#include "io/tensor/torch_tensor.h"
#include "raster/kernel/half.h"
#include "support/compact_models.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

float half(float value) { return float_of_any_half(round_to_half(value)); }

std::vector<float> halves(std::vector<float> values) {
  for (float& value : values) value = half(value);
  return values;
}

CompactModel read_npz(const std::filesystem::path& path) {
  const auto content = file_bytes(path);
  return read_compact_npz(content, path, {});
}

TEST(CompactWriter, a_ply_and_its_pth_are_read_back_to_equal_values) {
  const TemporaryFolder folder;
  for (const std::size_t count : {1, 77}) {
    for (const bool activated : {true, false}) {
      SavedModel saved = saved_model(count);
      if (!activated) {
        saved.model.opacities[0] = -2;
        for (glm::vec3& scale : saved.model.scales) scale -= 4.0f;
      }
      write_compact_ply(saved.model, folder / "point_cloud.ply");
      const auto content = file_bytes(folder / "point_cloud.ply");
      const CompactModel read = read_compact_ply(content, folder / "point_cloud.ply", {});
      EXPECT_EQ(read.activated_opacities, activated);
      EXPECT_EQ(read.activated_shapes, activated);
      EXPECT_EQ(read.means, saved.model.means);
      EXPECT_EQ(read.scales, saved.model.scales);
      EXPECT_EQ(read.rotations, saved.model.rotations);
      EXPECT_EQ(read.opacities, saved.model.opacities);
      EXPECT_EQ(read.field.grid_values, saved.model.field.grid_values);
      EXPECT_EQ(read.field.weights, saved.model.field.weights);
      EXPECT_EQ(read.field.grid.log2_entries, saved.model.field.grid.log2_entries);
    }
  }
}

TEST(CompactWriter, an_npz_is_read_back_to_the_coded_values) {
  const TemporaryFolder folder;
  for (const std::size_t count : {1, 77}) {
    const SavedModel saved = saved_model(count);
    write_compact_npz(saved.model, saved.scales, saved.rotations, folder / "a.npz");
    const CompactModel read = read_npz(folder / "a.npz");
    EXPECT_EQ(read.means, saved.model.means);  // halves
    EXPECT_EQ(read.scales, saved.model.scales);
    EXPECT_EQ(read.rotations, saved.model.rotations);
    EXPECT_EQ(read.opacities, halves(saved.model.opacities));
    EXPECT_EQ(read.field.grid_values, halves(saved.model.field.grid_values));
    EXPECT_EQ(read.field.weights, halves(saved.model.field.weights));
  }
}

TEST(CompactWriter, a_processed_npz_is_read_back_to_the_quantised_values) {
  const TemporaryFolder folder;
  for (const std::size_t count : {1, 77}) {
    const SavedModel saved = saved_model(count);
    write_compact_processed(saved.model, saved.scales, saved.rotations, folder / "a_pp.npz");
    const CompactModel read = read_npz(folder / "a_pp.npz");
    EXPECT_EQ(read.form, ".npz, post-processed");
    EXPECT_EQ(read.means, saved.model.means);
    EXPECT_EQ(read.scales, saved.model.scales);
    EXPECT_EQ(read.rotations, saved.model.rotations);
    const QuantisedValues opacities = quantise(saved.model.opacities, 0);
    const QuantisedValues grid = quantise(saved.model.field.grid_values, 0.1f);
    ASSERT_EQ(read.opacities.size(), count);
    for (std::size_t i = 0; i < count; ++i) EXPECT_EQ(read.opacities[i], opacities.value(i));
    ASSERT_EQ(read.field.grid_values.size(), grid.numbers.size());
    for (std::size_t i = 0; i < grid.numbers.size(); ++i)
      ASSERT_EQ(read.field.grid_values[i], grid.value(i)) << i;
  }
}

TEST(CompactWriter, quantised_values_are_within_half_a_step) {
  std::vector<float> values;
  for (int i = 0; i < 1000; ++i) values.push_back(std::sin(static_cast<float>(i)));
  const QuantisedValues quantised = quantise(values, 0);
  const float step = (quantised.high - quantised.low) / 255;
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_LE(std::abs(quantised.value(i) - values[i]), 0.5001f * step);
  const QuantisedValues without = quantise(values, 0.1f);
  EXPECT_EQ(without.low, quantised.low);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::abs(values[i]) > 0.1f) continue;
    EXPECT_LE(std::abs(without.value(i)), 0.5001f * step);
  }
  EXPECT_EQ(quantise(std::vector<float>{3, 3}, 0).value(1), 3);
  EXPECT_TRUE(quantise({}, 0).numbers.empty());
}

TEST(CompactWriter, all_forms_open_as_scenes_and_equal_files_are_written_twice) {
  const TemporaryFolder folder;
  const SavedModel saved = saved_model(40);
  for (const char* name : {"a", "b"}) {
    const std::string base = (folder / name).string();
    write_compact_ply(saved.model, base + ".ply");
    write_compact_npz(saved.model, saved.scales, saved.rotations, base + ".npz");
    write_compact_processed(saved.model, saved.scales, saved.rotations, base + "_pp.npz");
  }
  for (const char* ending : {".ply", ".npz", "_pp.npz"}) {
    const auto a = folder / (std::string("a") + ending), b = folder / (std::string("b") + ending);
    EXPECT_EQ(read_scene(a).cloud.size(), 40u);
    EXPECT_EQ(file_bytes(a), file_bytes(b)) << ending;
  }
}

TEST(CompactWriter, the_arrays_are_those_of_the_published_program) {
  const TemporaryFolder folder;
  const SavedModel saved = saved_model(5);
  write_compact_npz(saved.model, saved.scales, saved.rotations, folder / "a.npz");
  const auto arrays = [](const std::filesystem::path& path) {
    std::map<std::string, std::string> types;
    const ZipEntries entries = zip_entries(path);
    for (const auto& [name, content] : entries)
      types[name] = std::string(parse_npy_header(content, name).type);
    return types;
  };
  EXPECT_EQ(arrays(folder / "a.npz"), arrays(committed_corpus() / "valid/compact_small.npz"));
  write_compact_processed(saved.model, saved.scales, saved.rotations, folder / "a_pp.npz");
  EXPECT_EQ(arrays(folder / "a_pp.npz"), arrays(committed_corpus() / "valid/compact_small_pp.npz"));
}

TEST(ResidualCodebook, encodes_to_the_nearest_codes_layer_by_layer) {
  const SavedModel saved = saved_model(30);
  const ResidualCodebook& codebook = saved.scales.codebook;
  for (std::size_t i = 0; i < 30; ++i) {
    std::vector<std::uint16_t> numbers(codebook.layers);
    const float vector[3] = {saved.model.scales[i].x, saved.model.scales[i].y,
                             saved.model.scales[i].z};
    codebook.encode(vector, numbers);
    // No other code of the first layer is nearer.
    const auto distance = [&](std::size_t number) {
      float sum = 0;
      for (std::size_t k = 0; k < 3; ++k)
        sum += std::pow(vector[k] - codebook.code(0, number)[k], 2.0f);
      return sum;
    };
    for (std::size_t number = 0; number < codebook.codes(); ++number)
      EXPECT_LE(distance(numbers[0]), distance(number));
  }
}

}  // namespace
}  // namespace qs::test
