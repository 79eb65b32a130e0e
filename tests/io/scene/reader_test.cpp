// SPDX-License-Identifier: MIT
//
// Choice of the reader for a path: model directories, recognition by content, and messages about
// files that are not splat files.
#include "io/scene/reader.h"

#include <iterator>
#include <stop_token>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "io/scene/writer.h"
#include "support/corpus.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::string error_of(const std::filesystem::path& path, int iteration = -1) {
  try {
    read_scene(path, {.iteration = iteration});
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::input);
    EXPECT_THAT(error.what(), StartsWith(path.string()));
    EXPECT_THAT(error.what(), Not(HasSubstr("\n")));
    return error.what();
  }
  return "no error";
}

// A model whose iteration N has N/1000 Gaussians.
void make_model(const std::filesystem::path& model) {
  for (const std::size_t thousands : {7u, 30u, 9u}) {
    const auto folder = model / "point_cloud" / ("iteration_" + std::to_string(1000 * thousands));
    std::filesystem::create_directories(folder);
    write_scene(random_cloud(thousands, 0, 1), folder / "point_cloud.ply");
  }
  std::filesystem::create_directories(model / "point_cloud/iteration_99000");  // still empty
  std::filesystem::create_directories(model / "point_cloud/iteration_100000.bak");
}

TEST(Reader, model_directory_gives_its_highest_iteration) {
  const TemporaryFolder folder;
  make_model(folder.path());
  const Scene scene = read_scene(folder.path());
  EXPECT_EQ(scene.cloud.size(), 30u);
  EXPECT_EQ(scene.path, folder / "point_cloud/iteration_30000/point_cloud.ply");
  EXPECT_EQ(read_scene(folder / "point_cloud").cloud.size(), 30u);
  EXPECT_EQ(read_scene(folder / "point_cloud/iteration_7000").cloud.size(), 7u);
}

TEST(Reader, model_directory_gives_the_chosen_iteration) {
  const TemporaryFolder folder;
  make_model(folder.path());
  EXPECT_EQ(read_scene(folder.path(), {.iteration = 9000}).cloud.size(), 9u);
  EXPECT_THAT(error_of(folder.path(), 8000), HasSubstr("no iteration 8000; there are: 7000 9000"));
}

TEST(Reader, content_decides_over_the_extension) {
  const TemporaryFolder folder;
  const auto valid = committed_corpus() / "valid";
  std::filesystem::copy_file(valid / "spz_v4_sh3.spz", folder / "a.ply");
  std::filesystem::copy_file(valid / "splatapult_test.ply", folder / "b.spz");
  std::filesystem::copy_file(valid / "compressed_n1.compressed.ply", folder / "c.PLY");
  EXPECT_EQ(read_scene(folder / "a.ply").format, "spz, version 4");
  EXPECT_EQ(read_scene(folder / "b.spz").format, "ply, binary little endian");
  EXPECT_EQ(read_scene(folder / "c.PLY").format, "compressed.ply, binary little endian");
}

TEST(Reader, files_without_splats_get_a_message_of_one_sentence) {
  const TemporaryFolder folder;
  write_bytes(folder / "empty.ply", {});
  write_bytes(folder / "notes.txt", to_bytes("some text"));
  write_bytes(folder / "notes.ply", to_bytes("some text"));
  write_bytes(folder / "gzip.ply", to_bytes("\x1f\x8b\x08"));
  EXPECT_THAT(error_of(folder / "missing.ply"), HasSubstr("does not exist"));
  EXPECT_THAT(error_of(folder / "empty.ply"), HasSubstr("empty"));
  EXPECT_THAT(error_of(folder / "notes.txt"), AllOf(HasSubstr("unknown format"), HasSubstr("spz")));
  EXPECT_THAT(error_of(folder / "notes.ply"), HasSubstr("not a .ply file"));
  EXPECT_THAT(error_of(folder / "gzip.ply"), HasSubstr("gzip"));
  EXPECT_THAT(error_of(folder.path()), HasSubstr("point_cloud/iteration_*"));
  EXPECT_THAT(error_of("/dev/null"), HasSubstr("not a regular file"));
}

TEST(Reader, files_that_only_have_the_extension_are_refused_by_its_reader) {
  const TemporaryFolder folder;
  const auto message_for = [&](const char* name, const char* content) {
    write_bytes(folder / name, to_bytes(content));
    return error_of(folder / name);
  };
  EXPECT_THAT(message_for("noname", "glTF\2"), HasSubstr("cut off"));
  EXPECT_THAT(message_for("a.gltf", "{}"), HasSubstr("not valid glTF"));
  EXPECT_THAT(message_for("a.splat", "text"), HasSubstr("cut off"));
  EXPECT_THAT(message_for("a.ksplat", "text"), HasSubstr("cut off"));
  EXPECT_THAT(message_for("a.sog", "text"), HasSubstr("not valid JSON"));
}

TEST(Reader, axes_of_a_file_can_be_overruled) {
  const auto valid = committed_corpus() / "valid";
  const glm::vec3 as_rub = read_scene(valid / "spz_v4_sh3.spz").cloud.positions[5];
  const Scene scene = read_scene(valid / "spz_v4_sh3.spz", {.axes = "RDF"});
  EXPECT_EQ(scene.axes, "RDF");
  EXPECT_EQ(scene.cloud.positions[5], as_rub * glm::vec3(1, -1, -1));
  Scene again = scene;
  assume_axes(again, "RUB");
  EXPECT_EQ(again.cloud.positions[5], as_rub);
  EXPECT_THROW(assume_axes(again, "XYZ"), Error);
}

TEST(Reader, sog_names_that_leave_the_folder_are_refused) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "inner");
  std::filesystem::copy(committed_corpus() / "valid/sog_v1_folder", folder / "inner");
  std::filesystem::rename(folder / "inner/quats.webp", folder / "quats.webp");
  auto text = file_bytes(folder / "inner/meta.json");
  std::string meta(reinterpret_cast<const char*>(text.data()), text.size());
  meta.replace(meta.find("quats.webp"), 10, "../quats.webp");
  std::filesystem::remove(folder / "inner/meta.json");
  write_bytes(folder / "inner/meta.json", to_bytes(meta));
  EXPECT_THAT(error_of(folder / "inner/meta.json"), HasSubstr("unsafe file name"));
}

std::ptrdiff_t threads_of_this_process() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

TEST(Reader, readers_and_writers_start_no_threads) {
  const TemporaryFolder folder;
  ThreadPool pool(1);
  const std::ptrdiff_t before = threads_of_this_process();
  const Progress progress{[&](float) { EXPECT_EQ(threads_of_this_process(), before); }, {}};
  for (const CorpusFile& file : corpus_files(committed_corpus())) {
    SCOPED_TRACE(file.name);
    if (file.valid()) qs::read_scene(file.path, pool, {.progress = progress});
  }
  for (const WriterRow& writer : writers()) {
    SCOPED_TRACE(writer.name);
    const auto path = folder / (std::string("a") + writer.extension);
    qs::write_scene(random_cloud(40000, 1, 1), path, pool, progress, writer.name);
  }
}

TEST(Reader, stopping_cancels) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(read_scene(committed_corpus() / "valid/splatapult_test.ply",
                          {.progress = {{}, stop.get_token()}}),
               Cancelled);
}

TEST(Reader, every_format_reports_progress_and_can_be_stopped_on_the_way) {
  for (const CorpusFile& file : corpus_files(committed_corpus())) {
    if (!file.valid()) continue;
    SCOPED_TRACE(file.name);
    std::stop_source stop;
    float last = 0;
    const Progress progress{[&](float fraction) {
                              EXPECT_GE(fraction, last);
                              last = fraction;
                              stop.request_stop();
                            },
                            stop.get_token()};
    EXPECT_THROW(read_scene(file.path, {.progress = progress}), Cancelled);
    EXPECT_LT(last, 1);
  }
}

TEST(Reader, unpacking_gzip_can_be_stopped_on_the_way) {
  const TemporaryFolder folder;
  write_scene(random_cloud(50000, 3, 1), folder / "a.spz");  // 3.2 MB unpacked
  std::stop_source stop;
  float last = 0;
  const Progress progress{[&](float fraction) {
                            last = fraction;
                            if (fraction > 0) stop.request_stop();
                          },
                          stop.get_token()};
  EXPECT_THROW(read_scene(folder / "a.spz", {.progress = progress}), Cancelled);
  EXPECT_GT(last, 0);
  EXPECT_LT(last, 0.5f);
}

TEST(Reader, progress_rises_to_one) {
  const TemporaryFolder folder;
  ThreadPool pool(1);
  for (const WriterRow& writer : writers()) {
    SCOPED_TRACE(writer.name);
    const auto path = folder / (std::string("a") + writer.extension);
    qs::write_scene(random_cloud(40000, 1, 1), path, pool, {}, writer.name);
    std::vector<float> values;
    qs::read_scene(path, pool,
                   {.progress = {[&](float fraction) { values.push_back(fraction); }, {}}});
    EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
    EXPECT_GT(values.size(), 3u);
    EXPECT_EQ(values.back(), 1);
  }
}

TEST(Reader, progress_of_a_container_rises_to_one) {
  float last = -1;
  const Progress progress{[&](float fraction) {
                            EXPECT_GE(fraction, last);
                            last = fraction;
                          },
                          {}};
  read_scene(committed_corpus() / "valid/spz_v4_sh3.spz", {.progress = progress});
  EXPECT_EQ(last, 1);
}

TEST(Reader, a_sample_holds_every_nth_gaussian_of_the_scene_in_every_format) {
  const TemporaryFolder folder;
  for (const WriterRow& writer : writers()) {
    for (const char* axes : {"", "LUB"}) {
      SCOPED_TRACE(std::string(writer.name) + axes);
      const auto path = folder / (std::string("a") + writer.extension);
      ThreadPool pool(1);
      qs::write_scene(random_cloud(2000, 1, 1), path, pool, {}, writer.name);
      std::vector<SceneSample> samples;
      float reached = 0, reached_by_sample = -1;
      ReadOptions options{.axes = axes};
      options.progress.report = [&](float fraction) { reached = fraction; };
      options.sampling.most = 300;
      options.sampling.fewest = 2000;
      options.sampling.take = [&](SceneSample sample) {
        reached_by_sample = reached;
        samples.push_back(std::move(sample));
      };
      const Scene scene = qs::read_scene(path, pool, options);
      ASSERT_EQ(samples.size(), 1u);
      const GaussianCloud &some = samples[0].scene.cloud, &all = scene.cloud;
      EXPECT_EQ(samples[0].of, 2000u);
      EXPECT_EQ(samples[0].step, 7u);
      EXPECT_EQ(samples[0].scene.path, path);
      EXPECT_EQ(samples[0].scene.vertical_axis, scene.vertical_axis);
      ASSERT_EQ(some.size(), 286u);
      const auto coefficients = static_cast<std::size_t>(sh_coefficient_count(all.sh_degree));
      for (std::size_t k = 0; k < some.size(); ++k) {
        EXPECT_EQ(some.positions[k], all.positions[7 * k]);
        EXPECT_EQ(some.log_scales[k], all.log_scales[7 * k]);
        EXPECT_EQ(some.rotations[k], all.rotations[7 * k]);
        EXPECT_EQ(some.opacity_logits[k], all.opacity_logits[7 * k]);
        EXPECT_EQ(some.sh[k], all.sh[7 * k * coefficients]);
      }
      if (std::string_view(writer.name) == "spz") {
        EXPECT_LT(reached_by_sample, 0.5f) << "SH are not unpacked yet";
      }
      samples.clear();
      options.sampling.fewest = 2001;
      qs::read_scene(path, pool, options);
      EXPECT_TRUE(samples.empty()) << "it is read in a moment";
    }
  }
}

}  // namespace
}  // namespace qs::test
