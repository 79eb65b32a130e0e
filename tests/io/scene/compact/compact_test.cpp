// SPDX-License-Identifier: MIT
//
// The small model that tests/data/make_compact.py wrote with PyTorch and NumPy, in its three forms.
#include "io/scene/compact/compact.h"

#include <cmath>
#include <fstream>

#include <glm/geometric.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/support/zip_archive.h"
#include "raster/field/color_field.h"
#include "raster/field/field_evaluator.h"
#include "raster/kernel/sh.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/field_outputs.h"
#include "support/oracle.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::size_t kCount = 150, kCoefficients = 16;

std::filesystem::path small(const std::string& ending) {
  return committed_corpus() / ("valid/compact_small" + ending);
}

void expect_equal(const GaussianCloud& a, const GaussianCloud& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.log_scales, b.log_scales);
  EXPECT_EQ(a.rotations, b.rotations);
  EXPECT_EQ(a.opacity_logits, b.opacity_logits);
  EXPECT_EQ(a.sh, b.sh);
}

TEST(Compact, all_forms_of_a_model_are_equal) {
  const Scene ply = read_scene(small(".ply"));
  ASSERT_EQ(ply.cloud.size(), kCount);
  EXPECT_EQ(ply.cloud.sh_degree, 3);
  EXPECT_EQ(ply.format, "compact-3dgs, .ply and .pth");
  const Scene npz = read_scene(small(".npz")), processed = read_scene(small("_pp.npz"));
  EXPECT_EQ(npz.format, "compact-3dgs, .npz");
  EXPECT_EQ(processed.format, "compact-3dgs, .npz, post-processed");
  expect_equal(ply.cloud, npz.cloud);
  expect_equal(ply.cloud, processed.cloud);
  for (const Scene* scene : {&ply, &npz, &processed}) {
    ASSERT_TRUE(scene->network);
    EXPECT_EQ(scene->network->field->grid.log2_entries, 6);
    EXPECT_EQ(scene->network->field->grid_values, ply.network->field->grid_values);
    EXPECT_EQ(scene->network->field->weights, ply.network->field->weights);
    EXPECT_EQ(scene->network->rms, ply.network->rms);
  }
}

TEST(Compact, values_are_as_the_program_that_wrote_them_computed_them) {
  const Scene scene = read_scene(small(".npz"));
  const GaussianCloud& cloud = scene.cloud;
  EXPECT_NEAR(cloud.positions[0].x, 0.3, 1e-3);
  EXPECT_EQ(cloud.positions[1], glm::vec3(2.5f, -1, 0.75f));
  EXPECT_EQ(cloud.positions[2], glm::vec3(-8, 40, 3));
  EXPECT_EQ(cloud.positions[0].z, 0.5f);
  EXPECT_EQ(cloud.opacity_logits[0], -INFINITY);  // q = 0
  EXPECT_NEAR(cloud.opacity_logits[1], std::log(255), 1e-5);
  // The grid has -1/4 + q/512, two thirds of it 0.
  const std::vector<float>& grid = scene.network->field->grid_values;
  ASSERT_EQ(grid.size(), 2048u);
  EXPECT_EQ(grid[1], 0);
  EXPECT_EQ(grid[2], 0);
  EXPECT_EQ(grid[3] * 512, std::floor(grid[3] * 512));
  EXPECT_NE(grid[3], 0);
}

// Shapes follow from the quaternions as they are stored.
TEST(Compact, rotations_are_used_as_they_are_stored) {
  const auto bytes = file_bytes(small(".ply"));
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t body = text.find("end_header\n") + 11;
  const GaussianCloud cloud = read_scene(small(".ply")).cloud;
  double longest = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    std::array<float, 14> row;
    std::memcpy(row.data(), text.data() + body + i * sizeof row, sizeof row);
    const double w = row[10], x = row[11], y = row[12], z = row[13];
    glm::dmat3 m(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y),
                 2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
                 2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y));
    for (int axis = 0; axis < 3; ++axis)
      m[axis] *= static_cast<double>(row[7 + static_cast<std::size_t>(axis)]);
    const glm::dmat3 expected = m * glm::transpose(m), actual = covariance(cloud, i);
    for (int column = 0; column < 3; ++column) {
      for (int other = 0; other < 3; ++other)
        EXPECT_NEAR(actual[column][other], expected[column][other], 1e-8) << i;
    }
    longest = std::max(longest, std::abs(w * w + x * x + y * y + z * z - 1));
  }
  EXPECT_GT(longest, 0.05);  // the file has such quaternions
}

TEST(Compact, fitted_colours_differ_from_the_network_by_what_is_reported) {
  const Scene scene = read_scene(small("_pp.npz"));
  const GaussianCloud& cloud = scene.cloud;
  const ColorField& field = *scene.network->field;
  double squares = 0;
  std::size_t values = 0;
  const glm::dvec3 eye(1, 2, -3);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const glm::dvec3 mean(cloud.positions[i]), d = glm::normalize(mean - eye);
    const glm::dvec3 exact = glm::max(
        kSh0 * test::network_output(field, test::grid_features(field, mean), d) + 0.5, 0.0);
    const glm::dvec3 fitted = sh_color(3, d, [&](int k) {
      return glm::dvec3(cloud.sh[i * kCoefficients + static_cast<std::size_t>(k)]);
    });
    const glm::dvec3 difference = fitted - exact;
    squares += glm::dot(difference, difference);
    values += 3;
  }
  const double rms = std::sqrt(squares / static_cast<double>(values));
  EXPECT_GT(scene.network->rms, 0);
  EXPECT_LE(scene.network->rms, scene.network->rms_of_99);
  // 16 coefficients come closer to the 24 values than to the values of other directions.
  EXPECT_GT(rms, scene.network->rms);
  EXPECT_LT(rms, 2 * scene.network->rms);
  EXPECT_GT(-20 * std::log10(rms), 35);  // PSNR, dB
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0], fit_sentence(*scene.network));
}

TEST(Compact, parts_of_the_files_add_up) {
  for (const char* ending : {".ply", ".npz", "_pp.npz"}) {
    const Scene scene = read_scene(small(ending));
    std::uint64_t parts = 0;
    for (const FilePart& part : scene.parts) parts += part.bytes;
    EXPECT_LT(parts, scene.file_bytes) << ending;
    EXPECT_GT(parts, scene.file_bytes * 8 / 10) << ending;
  }
  const Scene ply = read_scene(small(".ply")), npz = read_scene(small(".npz"));
  EXPECT_EQ(ply.file_bytes,
            std::filesystem::file_size(small(".ply")) + std::filesystem::file_size(small(".pth")));
  EXPECT_EQ(npz.file_bytes, std::filesystem::file_size(small(".npz")));
  ASSERT_EQ(ply.parts.size(), 3u);
  EXPECT_EQ(ply.parts[0].bytes, 14 * 4 * kCount);
  EXPECT_EQ(ply.parts[1].bytes, 4 * 2048u);
  EXPECT_EQ(ply.parts[2].bytes, 4 * 8192u);
  const auto part = [&](const std::string& name) {
    for (const FilePart& found : npz.parts)
      if (found.name == name) return found;
    return FilePart();
  };
  // NumPy's headers have 128 bytes.
  EXPECT_EQ(part("xyz").bytes, 128 + 6 * kCount);
  EXPECT_EQ(part("opacity").bytes, 128 + 2 * kCount);
  EXPECT_EQ(part("scale").bytes, 128 + (36 * kCount + 7) / 8);
  EXPECT_EQ(part("hash").bytes, 128 + 2 * 2048u);
  EXPECT_EQ(part("mlp").content, "8192 values of 16 bits");
}

// Models of earlier iterations hold what is trained: logits, logarithms and rotations of any
// length. The first release saved logits in final models too.
TEST(Compact, opacities_outside_of_0_to_1_are_logits_and_scales_inside_are_no_logarithms) {
  const auto bytes = file_bytes(small(".ply"));
  const std::string whole(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t body = whole.find("end_header\n") + 11;
  const TemporaryFolder folder;
  std::filesystem::copy(small(".pth"), folder / "a.pth");
  const GaussianCloud last = read_scene(small(".ply")).cloud;
  for (const bool logarithms : {true, false}) {
    std::string text = whole;
    for (std::size_t i = 0; i < kCount; ++i) {
      std::array<float, 14> row;
      char* const at = text.data() + body + i * sizeof row;
      std::memcpy(row.data(), at, sizeof row);
      row[6] = 1.5f;
      for (std::size_t axis = 7; axis < 10 && logarithms; ++axis) row[axis] = std::log(row[axis]);
      std::memcpy(at, row.data(), sizeof row);
    }
    write_bytes(folder / "a.ply", to_bytes(text));
    const Scene scene = read_scene(folder / "a.ply");
    EXPECT_EQ(scene.cloud.opacity_logits[3], 1.5f);
    if (!logarithms) {
      EXPECT_EQ(scene.format, "compact-3dgs, .ply and .pth, of the first release");
      EXPECT_EQ(scene.cloud.log_scales, last.log_scales);
      EXPECT_EQ(scene.cloud.rotations, last.rotations);
      continue;
    }
    EXPECT_EQ(scene.format, "compact-3dgs, .ply and .pth, before the last iteration");
    std::array<float, 14> row;
    std::memcpy(row.data(), text.data() + body, sizeof row);
    EXPECT_EQ(scene.cloud.log_scales[0], glm::vec3(row[7], row[8], row[9]));
    const glm::quat expected = glm::normalize(glm::quat(row[10], row[11], row[12], row[13]));
    EXPECT_NEAR(std::abs(glm::dot(scene.cloud.rotations[0], expected)), 1, 1e-6);
  }
}

TEST(Compact, every_form_is_found_in_a_model_folder) {
  const TemporaryFolder folder;
  const auto iteration = folder / "model/point_cloud/iteration_30000";
  std::filesystem::create_directories(iteration);
  const auto copy = [&](const char* from, const char* to) {
    std::filesystem::copy(small(from), iteration / to);
    return read_scene(folder / "model").format;
  };
  EXPECT_EQ(copy("_pp.npz", "point_cloud_pp.npz"), "compact-3dgs, .npz, post-processed");
  EXPECT_EQ(copy(".npz", "point_cloud.npz"), "compact-3dgs, .npz");
  std::filesystem::copy(small(".pth"), iteration / "point_cloud.pth");
  EXPECT_EQ(copy(".ply", "point_cloud.ply"), "compact-3dgs, .ply and .pth");
}

TEST(Compact, missing_and_other_files_are_refused_by_name) {
  const TemporaryFolder folder;
  std::filesystem::copy(small(".ply"), folder / "a.ply");
  const auto error = [&](const char* name) {
    return error_of([&] { read_scene(folder / name); }, folder.path());
  };
  EXPECT_EQ(error("a.ply"),
            "a.ply: its Gaussians have no colours (f_dc); Compact-3DGS keeps them in a network, "
            "but a.pth is not beside it");
  std::filesystem::copy(small(".pth"), folder / "b.pth");
  EXPECT_EQ(error("b.pth"),
            "b.pth: a file of PyTorch, such as the network of a Compact-3DGS model: open the .ply "
            "or .npz beside it");
  write_bytes(folder / "a.pth", to_bytes("hello"));
  EXPECT_EQ(error("a.ply"), "a.pth: its pickle: object 101 was not remembered");
}

TEST(Compact, no_thread_number_changes_the_scene) {
  ThreadPool one(1), three(3);
  const Scene a = qs::read_scene(small(".npz"), one), b = qs::read_scene(small(".npz"), three);
  expect_equal(a.cloud, b.cloud);
  EXPECT_EQ(a.network->rms, b.network->rms);
  EXPECT_EQ(a.network->rms_of_99, b.network->rms_of_99);
}

}  // namespace
}  // namespace qs::test
