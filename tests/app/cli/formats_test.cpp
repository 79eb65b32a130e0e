// SPDX-License-Identifier: MIT
//
// The formats as users see them: the table in the docs, `convert` and `--axes`.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "app/measure/load_times.h"
#include "app/support/run_program.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "support/corpus.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/shared.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::HasSubstr;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Formats, documentation_has_the_table_of_readers_and_writers) {
  EXPECT_THAT(text_of(source_path("docs/formats.md")),
              HasSubstr("<!-- formats -->\n" + format_list() + "<!-- /formats -->"));
}

TEST(Formats, names_and_endings_are_told_apart) {
  std::set<std::string> names;
  for (const ReaderRow& row : readers()) EXPECT_TRUE(names.insert(row.name).second) << row.name;
  names.clear();
  for (const WriterRow& row : writers()) EXPECT_TRUE(names.insert(row.name).second) << row.name;
}

TEST(Formats, loading_is_measured_by_stages) {
  ThreadPool pool(2);
  const LoadTimes times =
      measure_loading(committed_corpus() / "valid/spz_v3_ext_coordsys_rdf.spz", pool, 1);
  EXPECT_EQ(times.gaussians, 1873u);
  EXPECT_GT(times.fill_ms, 0);
  EXPECT_GT(times.inflate_ms, 0);
  EXPECT_GE(times.total_ms, times.fill_ms + times.unpack_ms);
  EXPECT_THAT(format_load_times({times}), HasSubstr("| 1,873 |"));
}

TEST(Formats, convert_writes_every_format_and_keeps_the_largest) {
  const TemporaryFolder folder;
  const auto input = (committed_corpus() / "valid/spz_v4_sh3.spz").string();
  for (const WriterRow& row : writers()) {
    SCOPED_TRACE(row.name);
    const auto output = folder / (std::string(row.name) + row.extension);
    const ProgramRun run = run_quadsplat({"convert", input, output.string(), "--format", row.name,
                                          "--keep-largest", "100", "--sh-degree", "1"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Scene scene = test::read_scene(output);
    EXPECT_EQ(scene.cloud.size(), 100u);
    EXPECT_EQ(scene.cloud.sh_degree, std::min(row.max_sh_degree, 1));
    EXPECT_THAT(run.err, HasSubstr(row.max_sh_degree == 0 ? "SH degree 0" : "SH degree 1"));
  }
}

TEST(Formats, info_prints_the_levels_of_a_file_and_convert_takes_its_leaves) {
  const TemporaryFolder folder;
  for (const char* name : {"lod_tree.rad", "lod_tree.spz", "lod_tree.hier", "lod_halves.hier"}) {
    SCOPED_TRACE(name);
    const auto input = (committed_corpus() / "valid" / name).string();
    EXPECT_THAT(
        run_quadsplat({"info", input}).out,
        HasSubstr("  levels         3, in a tree of 21 nodes: 16 leaves were read, 5 merged "
                  "Gaussians were left out\n"));
    EXPECT_THAT(run_quadsplat({"info", "--json", "-", input}).out, HasSubstr("\"merged\": 5"));
    const auto output = folder / (std::string(name) + ".ply");
    EXPECT_EQ(run_quadsplat({"convert", input, output.string()}).exit_code, 0);
    EXPECT_EQ(test::read_scene(output).cloud.size(), 16u);
  }
  const auto plain = (committed_corpus() / "valid/spz_v3_sh1.spz").string();
  EXPECT_THAT(run_quadsplat({"info", plain}).out, testing::Not(HasSubstr("levels")));
}

// `compare` measures the loss of a format, and `convert` prints it.
TEST(Formats, compare_shows_the_loss_of_each_written_format) {
  struct Loss {
    const char* format;
    double db;  // of plush.ply, which was read from .spz; above 100: equal within rounding
    const char* said;
  };
  constexpr Loss kLosses[] = {
      {"compressed.ply", 43.6, "; its picture: "}, {"ply", INFINITY, "MB)"},
      {"spz", 140, "; the same picture)"},         {"spz-v4", 140, "; the same picture)"},
      {"splat", 38.65, "; its picture: "},         {"sog", 65.5, "; its picture: "},
      {"glb", 140, "; the same picture)"},         {"usda", 140, "; the same picture)"},
      {"usdz", 140, "; the same picture)"}};
  const TemporaryFolder folder;
  const auto input = (folder / "scene.ply").string();  // without cameras beside it
  std::filesystem::copy(source_path("assets/plush.ply"), input);
  ASSERT_EQ(writers().size(), std::size(kLosses));
  for (const Loss& loss : kLosses) {
    SCOPED_TRACE(loss.format);
    const auto output = (folder / "out").string() + find_writer("", loss.format)->extension;
    const ProgramRun written =
        run_quadsplat({"convert", input, output, "--format", loss.format, "--overwrite"});
    ASSERT_EQ(written.exit_code, 0) << written.err;
    EXPECT_THAT(written.err, HasSubstr(loss.said));
    const ProgramRun judged =
        run_quadsplat({"compare", input, output, "--backend", "cpu", "--size", "320x180"});
    ASSERT_EQ(judged.exit_code, 0) << judged.err;
    const std::string mean = "mean of 1";
    const double db = std::stod(judged.out.substr(judged.out.find(mean) + mean.size()));
    if (loss.db > 100) {
      EXPECT_GE(db, std::min(loss.db, 150.0) - 20);
    } else {
      EXPECT_NEAR(db, loss.db, 0.7);
    }
  }
}

TEST(Formats, scenes_of_huge_gaussians_are_drawn_or_refused_in_time) {
  const TemporaryFolder folder;
  const auto picture = (folder / "a.png").string();
  std::vector<std::filesystem::path> bombs = {committed_corpus() / "broken/ply_scale_huge.ply"};
  const auto shared = shared_path("corpus/broken/ply_overdraw_bomb.ply");
  if (std::filesystem::exists(shared)) bombs.push_back(shared);
  for (const auto& bomb : bombs) {
    const ProgramRun run = run_quadsplat(
        {"render", bomb.string(), "--size", "160x120", "--backend", "cpu", "--output", picture});
    EXPECT_THAT(run.exit_code, testing::AnyOf(0, 3)) << run.err;
    EXPECT_THAT(run.err, HasSubstr("warning: ")) << bomb;
  }
}

TEST(Formats, axes_can_be_overruled_on_the_command_line) {
  const auto file = (committed_corpus() / "valid/spz_v4_sh3.spz").string();
  EXPECT_THAT(run_quadsplat({"info", file}).out, HasSubstr("RUB"));
  EXPECT_THAT(run_quadsplat({"info", file, "--axes", "RDF"}).out, HasSubstr("RDF"));
  EXPECT_EQ(run_quadsplat({"info", file, "--axes", "XYZ"}).exit_code, 1);
}

}  // namespace
}  // namespace qs::test
