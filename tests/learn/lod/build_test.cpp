// SPDX-License-Identifier: MIT
//
// Trees of scenes: their leaves are the scene's Gaussians, their bytes depend on nothing but the
// input and the options, and an interrupted call goes on.
#include "learn/lod/build.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <numeric>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "io/bytes/mapped_file.h"
#include "io/cloud/cloud_memory.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "learn/lod/cut.h"
#include "learn/lod/streamed_levels.h"
#include "raster/api/renderer.h"
#include "raster/scene/activated_cloud.h"
#include "raster/scene/image_metrics.h"
#include "support/error_of.h"
#include "support/instances_text.h"
#include "support/lod_cuts.h"
#include "support/paths.h"
#include "support/pool.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Reproducible Gaussians on two walls.
GaussianCloud walls(std::size_t count, int degree) {
  GaussianCloud cloud;
  cloud.resize(count, degree);
  std::uint32_t state = 12345;
  const auto uniform = [&](float low, float high) {
    state = state * 1664525 + 1013904223;
    return low + (high - low) * static_cast<float>(state >> 8) / 16777216.0f;
  };
  for (std::size_t i = 0; i < count; ++i) {
    cloud.positions[i] = {uniform(-2, 2), uniform(-1, 1), i % 2 == 0 ? 3.0f : 5.0f};
    for (int axis = 0; axis < 3; ++axis) cloud.log_scales[i][axis] = uniform(-5, -3);
    cloud.rotations[i] =
        glm::normalize(glm::quat(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
    cloud.opacity_logits[i] = uniform(-2, 4);
  }
  for (glm::vec3& sh : cloud.sh) sh = {uniform(-0.4f, 0.4f), uniform(-0.4f, 0.4f), 0.25f};
  return cloud;
}

class LodBuilding : public testing::Test {
 protected:
  std::filesystem::path write(const GaussianCloud& cloud, const std::string& name = "in.ply") {
    write_scene(cloud, folder_ / name, pool());
    return folder_ / name;
  }

  LodBuild job(const std::filesystem::path& input, const std::string& output = "out.rad") {
    LodBuild build;
    build.inputs = {input};
    build.output = folder_ / output;
    build.warn = [this](const std::string& sentence) { warnings_.push_back(sentence); };
    return build;
  }

  std::string bytes(const std::string& name) {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  bool is_clean() { return !std::filesystem::exists(folder_ / "out.rad.unfinished"); }

  TemporaryFolder folder_;
  std::vector<std::string> warnings_;
};

std::vector<std::size_t> by_position(const GaussianCloud& cloud) {
  std::vector<std::size_t> order(cloud.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    const glm::vec3 &p = cloud.positions[a], &q = cloud.positions[b];
    return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
  });
  return order;
}

// Positions are exact; other values are halves, and SH have 254 steps.
void expect_same_gaussians(const GaussianCloud& expected, const GaussianCloud& got) {
  ASSERT_EQ(expected.size(), got.size());
  ASSERT_EQ(expected.sh_degree, got.sh_degree);
  const auto from = by_position(expected), to = by_position(got);
  const std::size_t stride = expected.sh.size() / expected.size();
  for (std::size_t i = 0; i < from.size(); ++i) {
    const std::size_t a = from[i], b = to[i];
    ASSERT_EQ(expected.positions[a], got.positions[b]);
    // The rotation may be turned by half a turn about an axis of the ellipsoid.
    const auto c = world_covariance(expected, a), d = world_covariance(got, b);
    const double size = c.xx + c.yy + c.zz;
    for (const double difference :
         {c.xx - d.xx, c.xy - d.xy, c.xz - d.xz, c.yy - d.yy, c.yz - d.yz, c.zz - d.zz})
      EXPECT_LT(std::abs(difference), 0.01 * size);
    const auto opacity = [](float logit) { return 1 / (1 + std::exp(-logit)); };
    EXPECT_NEAR(opacity(expected.opacity_logits[a]), opacity(got.opacity_logits[b]), 5e-4f);
    for (std::size_t k = 0; k < stride; ++k)
      EXPECT_LT(glm::length(expected.sh[a * stride + k] - got.sh[b * stride + k]), 0.006f);
  }
}

void expect_same_bits(const GaussianCloud& a, const GaussianCloud& b) {
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a.sh_degree, b.sh_degree);
  const auto same = [](const auto& x, const auto& y) {
    return std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0;
  };
  EXPECT_TRUE(same(a.positions, b.positions));
  EXPECT_TRUE(same(a.log_scales, b.log_scales));
  EXPECT_TRUE(same(a.rotations, b.rotations));
  EXPECT_TRUE(same(a.opacity_logits, b.opacity_logits));
  EXPECT_TRUE(same(a.sh, b.sh));
}

TEST_F(LodBuilding, the_leaves_are_the_gaussians_of_the_scene) {
  for (const int degree : {0, 1, 2, 3}) {
    const GaussianCloud cloud = walls(3000, degree);
    LodBuild build =
        job(write(cloud, fmt::format("{}.ply", degree)), fmt::format("{}.rad", degree));
    const LodReport report = build_lod(build, pool());
    EXPECT_EQ(report.leaves, 3000u);
    EXPECT_EQ(report.sh_degree, degree);
    const Scene scene = read_scene(build.output, pool());
    EXPECT_THAT(scene.warnings, IsEmpty());
    ASSERT_TRUE(scene.levels);
    EXPECT_EQ(scene.levels->nodes, report.nodes);
    EXPECT_EQ(scene.levels->leaves, 3000u);
    expect_same_gaussians(cloud, scene.cloud);
    EXPECT_THAT(warnings_, IsEmpty());
  }
}

TEST_F(LodBuilding, many_buckets_hold_the_same_leaves) {
  const GaussianCloud cloud = walls(9000, 1);
  LodBuild build = job(write(cloud));
  build.memory = 64'000'000 / 32;  // buckets have at least 1,024 Gaussians
  const LodReport report = build_lod(build, pool());
  EXPECT_EQ(report.buckets, 9u);
  expect_same_gaussians(cloud, read_scene(build.output, pool()).cloud);
  EXPECT_TRUE(is_clean());
}

TEST_F(LodBuilding, the_bytes_do_not_depend_on_threads) {
  LodBuild build = job(write(walls(8000, 2)), "1.rad");
  build.memory = 2'000'000;
  build_lod(build, pool(1));
  for (const int threads : {2, 3, 7}) {
    build.output = folder_ / fmt::format("{}.rad", threads);
    build_lod(build, pool(threads));
    EXPECT_EQ(bytes("1.rad"), bytes(fmt::format("{}.rad", threads))) << threads;
  }
}

TEST_F(LodBuilding, several_scenes_become_one_tree) {
  GaussianCloud near = walls(700, 0), far = walls(900, 2);
  for (glm::vec3& position : far.positions) position.x += 20;
  LodBuild build = job(write(near, "near.ply"));
  build.inputs.push_back(write(far, "far.ply"));
  EXPECT_EQ(build_lod(build, pool()).leaves, 1600u);
  const Scene scene = read_scene(build.output, pool());
  EXPECT_EQ(scene.cloud.size(), 1600u);
  EXPECT_EQ(scene.cloud.sh_degree, 2);
}

TEST_F(LodBuilding, a_ply_file_in_parts_gives_the_same_bytes) {
  const GaussianCloud cloud = walls(6000, 2);
  LodBuild build = job(write(cloud), "parts.rad");
  build.memory = 2'000'000;  // parts have 1,024 rows, and so have buckets
  build_lod(build, pool());
  // .spz is read whole; here a .glb, which has all floats.
  build.inputs = {write(cloud, "in.glb")};
  build.output = folder_ / "whole.rad";
  build_lod(build, pool());
  const Scene parts = read_scene(folder_ / "parts.rad", pool()),
              whole = read_scene(build.output, pool());
  expect_same_gaussians(cloud, parts.cloud);
  EXPECT_EQ(parts.levels, whole.levels);
}

TEST_F(LodBuilding, instances_are_read_in_parts) {
  write(walls(700, 1), "one.ply");
  std::vector<Instance> instances(5);
  for (std::size_t i = 0; i < instances.size(); ++i) {
    instances[i].position = {10 * static_cast<double>(i), -3, 1000};
    instances[i].rotation = glm::angleAxis(0.4 * static_cast<double>(i), glm::dvec3(0, 1, 0));
    instances[i].scale = 0.5 + static_cast<double>(i);
  }
  std::ofstream(folder_ / "all.json") << format_instances("one.ply", instances);
  LodBuild build = job(folder_ / "all.json");
  build.memory = 2'000'000;  // a part has one instance
  EXPECT_EQ(build_lod(build, pool()).leaves, 3500u);
  EXPECT_THAT(warnings_, IsEmpty());
  const GaussianCloud whole = read_scene(folder_ / "all.json", pool()).cloud,
                      leaves = read_scene(folder_ / "out.rad", pool()).cloud;
  EXPECT_EQ(leaves.origin, whole.origin);
  expect_same_gaussians(whole, leaves);
}

TEST_F(LodBuilding, a_ply_file_that_is_cut_off_is_one_sentence) {
  const std::filesystem::path path = write(walls(3000, 0));
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 10);
  EXPECT_THAT(error_of([&] { build_lod(job(path), pool()); }, folder_.path()),
              HasSubstr("in.ply: cut off: "));
}

TEST_F(LodBuilding, original_values_keep_the_bits_and_the_order_of_the_leaves) {
  GaussianCloud first = walls(5000, 3), second = walls(1, 1);
  for (glm::vec3& sh : first.sh) sh *= 1.2345f;
  LodBuild build = job(write(first, "first.ply"));
  build.inputs.push_back(write(second, "second.ply"));
  build.memory = 2'000'000;  // several buckets, and parts of the .ply file
  build.original = true;
  build_lod(build, pool());
  const Scene scene = read_scene(build.output, pool());
  EXPECT_TRUE(scene.levels->has_originals);
  const GaussianCloud one = read_scene(build.inputs[1], pool()).cloud;
  GaussianCloud expected = read_scene(build.inputs[0], pool()).cloud;
  const std::size_t count = expected.size();
  expected.resize(count + 1, 3);
  std::fill_n(sh_of(expected, count), 16, glm::vec3(0));
  copy_gaussian(one, 0, expected, count);
  expect_same_bits(scene.cloud, expected);
  build.output = folder_ / "other.rad";
  build.original = false;
  build_lod(build, pool());
  EXPECT_FALSE(read_scene(build.output, pool()).levels->has_originals);
  EXPECT_THAT(bytes("other.rad"), Not(HasSubstr("original")));
}

TEST_F(LodBuilding, small_and_odd_scenes_become_trees) {
  struct Row {
    std::string name;
    GaussianCloud cloud;
  };
  std::vector<Row> rows = {{"one", walls(1, 3)}, {"two", walls(2, 0)}, {"three", walls(3, 1)}};
  GaussianCloud same = walls(3000, 0);
  std::ranges::fill(same.positions, glm::vec3(1, 2, 3));
  rows.push_back({"one place", same});
  GaussianCloud line = walls(500, 0);
  for (glm::vec3& position : line.positions) position.y = position.z = 0;
  rows.push_back({"a line", line});
  GaussianCloud flat = walls(500, 0);
  for (glm::vec3& scale : flat.log_scales) scale.z = -INFINITY;
  rows.push_back({"flat", flat});
  GaussianCloud clear = walls(500, 0), solid = walls(500, 0), far = walls(500, 0),
                huge = walls(500, 0);
  std::ranges::fill(clear.opacity_logits, -INFINITY);
  std::ranges::fill(solid.opacity_logits, INFINITY);
  far.positions[7] = glm::vec3(1e15f);
  huge.log_scales[7] = glm::vec3(30);
  rows.push_back({"clear", clear});
  rows.push_back({"opaque", solid});
  rows.push_back({"one far away", far});
  rows.push_back({"one huge", huge});
  for (const Row& row : rows) {
    LodBuild build = job(write(row.cloud), "out.rad");
    build.memory = 2'000'000;
    build.original = true;
    EXPECT_EQ(build_lod(build, pool()).leaves, row.cloud.size()) << row.name;
    expect_same_bits(read_scene(build.output, pool()).cloud,
                     read_scene(build.inputs[0], pool()).cloud);
    const LodPages tree = whole_tree(build.output);
    EXPECT_EQ(std::ranges::count(tree.pages[0]->nodes, 0, &LodFacts::child_count),
              static_cast<std::ptrdiff_t>(row.cloud.size()))
        << row.name;
    const LodCut root = cut_of(tree, gain_in(even_view(0.01f), tree.footprint), {1}, pool());
    EXPECT_EQ(root.count, 1u);
    EXPECT_TRUE(root.parts[0].mask[0]);
    std::filesystem::remove(build.output);
  }
}

TEST_F(LodBuilding, mip_splatting_is_kept) {
  GaussianCloud cloud = walls(50, 0);
  cloud.antialiased = true;
  LodBuild build = job(write(cloud));
  build_lod(build, pool());
  EXPECT_TRUE(read_scene(build.output, pool()).cloud.antialiased);
}

TEST_F(LodBuilding, georeferenced_scenes_have_one_origin) {
  GaussianCloud cloud = walls(5000, 0);
  cloud.origin = {500'000, 4'650'000, 200};
  LodBuild build = job(write(cloud));
  build.memory = 2'000'000;  // the file is read in parts
  build.original = true;
  std::stop_source stop;  // and the journal keeps the origin
  build.progress = {[&](float done) {
                      if (done >= 0.5f) stop.request_stop();
                    },
                    stop.get_token()};
  EXPECT_THROW(build_lod(build, pool(1)), Cancelled);
  build.progress = {};
  build_lod(build, pool());
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("going on")));
  const GaussianCloud source = read_scene(build.inputs[0], pool()).cloud,
                      leaves = read_scene(build.output, pool()).cloud;
  EXPECT_NE(source.origin, glm::dvec3(0));
  ASSERT_EQ(leaves.size(), 5000u);
  for (std::size_t i = 0; i < 5000; ++i)
    ASSERT_LT(glm::distance(leaves.origin + glm::dvec3(leaves.positions[i]),
                            source.origin + glm::dvec3(source.positions[i])),
              1e-6);
}

TEST_F(LodBuilding, an_interrupted_call_goes_on) {
  LodBuild build = job(write(walls(9000, 1)), "whole.rad");
  build.memory = 2'000'000;
  build_lod(build, pool());
  build.output = folder_ / "out.rad";
  for (const float stop_at : {0.05f, 0.15f, 0.25f, 0.5f, 0.8f, 0.95f}) {
    warnings_.clear();
    std::stop_source stop;
    build.progress = {[&](float done) {
                        if (done >= stop_at) stop.request_stop();
                      },
                      stop.get_token()};
    EXPECT_THROW(build_lod(build, pool(1)), Cancelled) << stop_at;
    EXPECT_FALSE(std::filesystem::exists(build.output));
    EXPECT_FALSE(is_clean());
  }
  build.progress = {};
  warnings_.clear();
  build_lod(build, pool());
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_THAT(warnings_[0], HasSubstr("going on with the work of an earlier call"));
  EXPECT_EQ(bytes("out.rad"), bytes("whole.rad"));
  EXPECT_TRUE(is_clean());
}

TEST_F(LodBuilding, damaged_work_of_an_earlier_call_is_one_sentence) {
  LodBuild build = job(write(walls(5000, 0)));
  build.memory = 2'000'000;
  std::stop_source stop;
  build.progress = {[&](float done) {
                      if (done >= 0.2f) stop.request_stop();
                    },
                    stop.get_token()};
  EXPECT_THROW(build_lod(build, pool(1)), Cancelled);
  build.progress = {};
  const std::filesystem::path bucket = folder_ / "out.rad.unfinished/bucket_000003";
  std::filesystem::resize_file(bucket, std::filesystem::file_size(bucket) / 2);
  const std::string sentence = error_of([&] { build_lod(build, pool()); }, folder_.path());
  EXPECT_THAT(sentence, HasSubstr("out.rad.unfinished: damaged: "));
  EXPECT_THAT(sentence, HasSubstr("of 5000 Gaussians are left"));
  EXPECT_FALSE(std::filesystem::exists(build.output));
}

TEST_F(LodBuilding, work_of_another_input_is_not_used) {
  LodBuild build = job(write(walls(3000, 0)));
  std::stop_source stop;
  build.progress = {[&](float done) {
                      if (done >= 0.8f) stop.request_stop();
                    },
                    stop.get_token()};
  EXPECT_THROW(build_lod(build, pool(1)), Cancelled);
  build.progress = {};
  const GaussianCloud other = walls(2000, 0);
  write(other);
  build_lod(build, pool());
  EXPECT_THAT(warnings_, IsEmpty());
  expect_same_gaussians(other, read_scene(build.output, pool()).cloud);
}

TEST_F(LodBuilding, a_damaged_journal_is_replaced) {
  LodBuild build = job(write(walls(300, 0)));
  for (const char* journal : {"", "{", "[]", "{\"job\": 1}", "null"}) {
    std::filesystem::create_directories(folder_ / "out.rad.unfinished");
    std::ofstream(folder_ / "out.rad.unfinished/journal.json") << journal;
    EXPECT_EQ(build_lod(build, pool()).leaves, 300u) << journal;
    std::filesystem::remove(build.output);
  }
}

TEST_F(LodBuilding, errors_are_one_sentence) {
  const auto error = [&](const LodBuild& build) {
    return error_of([&] { build_lod(build, pool()); }, folder_.path());
  };
  EXPECT_EQ(error(job(folder_ / "none.ply")), "none.ply: does not exist");
  std::ofstream(folder_ / "bad.ply") << "ply\nnonsense\n";
  EXPECT_THAT(error(job(folder_ / "bad.ply")), HasSubstr("bad.ply: "));
  LodBuild nowhere = job(write(walls(10, 0)), "none/out.rad");
  EXPECT_THAT(error(nowhere), HasSubstr("none"));
}

TEST_F(LodBuilding, a_full_disk_is_one_sentence) {
  LodBuild build = job(write(walls(20'000, 3)));
  rlimit kept;
  getrlimit(RLIMIT_FSIZE, &kept);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small = {100'000, kept.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string sentence = error_of([&] { build_lod(build, pool()); }, ErrorKind::input);
  setrlimit(RLIMIT_FSIZE, &kept);
  std::signal(SIGXFSZ, ignored);
  EXPECT_THAT(sentence, HasSubstr("cannot be written: "));
  EXPECT_FALSE(std::filesystem::exists(build.output));
  build_lod(build, pool());
  EXPECT_TRUE(std::filesystem::exists(build.output));
}

TEST_F(LodBuilding, levels_of_a_streamed_sog_have_a_quarter_of_the_level_before) {
  for (const std::size_t count : {std::size_t{1}, std::size_t{5000}}) {
    const GaussianCloud leaves = walls(count, 1);
    const std::filesystem::path folder = folder_ / std::to_string(count);
    build_lod(job(write(leaves)), pool());
    write_streamed_levels(folder_ / "out.rad", folder, pool(), {});
    std::size_t most = count;
    for (std::size_t k = 0; k < kStreamedLevels; ++k, most = std::max<std::size_t>(most / 4, 1)) {
      const Scene level = read_scene(folder / fmt::format("{}_0/meta.json", k), pool());
      EXPECT_LE(level.cloud.size(), most);
      EXPECT_GE(level.cloud.size(), (most + 1) / 2) << "the budget is used";
    }
    const Scene finest = read_scene(folder / "lod-meta.json", pool());
    EXPECT_EQ(finest.cloud.size(), count);
    EXPECT_EQ(finest.levels->levels, kStreamedLevels);
  }
}

TEST_F(LodBuilding, cuts_keep_their_budget_and_cover_every_leaf) {
  LodBuild build = job(source_path("assets/plush.ply"));
  build_lod(build, pool());
  const LodPages tree = whole_tree(build.output);
  const std::vector<LodFacts>& nodes = tree.pages[0]->nodes;
  const Scene leaves = read_scene(build.output, pool());
  const std::size_t count = leaves.cloud.size();
  const auto renderer = make_renderer(Backend::cpu, pool());
  const Camera camera = look_at({0, 0, -4}, {0, 0, 0}, {0, -1, 0}, 0.8, 200, 150);
  RenderSettings settings;
  renderer->upload(leaves.cloud, {});
  const Image full = renderer->render(camera, settings).color;
  const float footprint = 4 / static_cast<float>(camera.focal_px.x);
  double before = 0;
  for (const double share : {0.02, 0.1, 0.3, 0.6, 1.0, 2.0}) {
    const auto budget = static_cast<std::size_t>(share * static_cast<double>(count));
    for (const bool sees : {false, true}) {
      const LodView view = sees ? LodView(camera, 0.01f) : even_view(footprint);
      const LodCut cut = cut_of(tree, gain_in(view, tree.footprint), {budget}, pool());
      EXPECT_LE(cut.count, budget);
      EXPECT_GT(cut.count + 64, std::min(budget, count));
      // Leaves below each node of the cut.
      std::vector<int> covered(nodes.size(), 0);
      cut.parts[0].for_each([&](std::size_t i) { covered[i] = 1; });
      for (std::size_t i = 1; i < nodes.size(); ++i) covered[i] += covered[nodes[i].parent];
      for (std::size_t i = 0; i < nodes.size(); ++i)
        if (nodes[i].child_count == 0 && covered[i] != 1)
          FAIL() << "leaf " << i << " is covered " << covered[i] << " times";
      if (!sees) continue;
      renderer->upload(cut_cloud(tree, cut, view, settings.dilation, pool()), {});
      const double quality = psnr(renderer->render(camera, settings).color, full, pool());
      EXPECT_GE(quality, before - 0.5) << share;
      before = quality;
    }
  }
  EXPECT_EQ(before, INFINITY);  // all leaves
}

}  // namespace
}  // namespace qs::test
