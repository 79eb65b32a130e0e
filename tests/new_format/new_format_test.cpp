// SPDX-License-Identifier: MIT
//
// The scene format that docs/extending.md shows, added to the tables of readers and writers as that
// page says. The commands find it there.
#include <fstream>

#include <gtest/gtest.h>

#include "app/cli/command.h"
#include "io/scene/reader.h"
#include "io/scene/writer.h"
#include "support/error_of.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::error_of;

// The output of the program with these words.
std::string output_of(const std::vector<std::string>& words) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_program(words), kExitOk);
  return testing::internal::GetCapturedStdout();
}

class NewFormat : public testing::Test {
 protected:
  void SetUp() override {
    cloud_ = test::random_cloud(150, 1, 11);
    write_scene(cloud_, folder_ / "scene.ply", pool_);
  }

  const TemporaryFolder folder_;
  ThreadPool pool_{2};
  GaussianCloud cloud_;
};

TEST_F(NewFormat, is_written_by_convert_and_found_by_info) {
  const std::string from = (folder_ / "scene.ply").string(), to = (folder_ / "a.dots").string();
  output_of({"convert", from, to});
  EXPECT_EQ(std::filesystem::file_size(to), 8 + 150 * 32);
  const std::string info = output_of({"info", to});
  EXPECT_NE(info.find("  format         dots\n"), std::string::npos) << info;
  EXPECT_NE(info.find("  Gaussians      150\n"), std::string::npos) << info;
}

TEST_F(NewFormat, keeps_positions_opacities_and_colours) {
  write_scene(cloud_, folder_ / "a.dots", pool_);
  const Scene scene = read_scene(folder_ / "a.dots", pool_);
  EXPECT_EQ(scene.cloud.positions, cloud_.positions);
  EXPECT_EQ(scene.cloud.opacity_logits, cloud_.opacity_logits);
  ASSERT_EQ(scene.cloud.sh.size(), cloud_.size());
  for (std::size_t i = 0; i < cloud_.size(); ++i) EXPECT_EQ(scene.cloud.sh[i], cloud_.sh[4 * i]);
}

TEST_F(NewFormat, is_recognised_by_its_content_under_any_name) {
  write_scene(cloud_, folder_ / "a.dots", pool_);
  std::filesystem::rename(folder_ / "a.dots", folder_ / "a.bin");
  EXPECT_EQ(read_scene(folder_ / "a.bin", pool_).format, "dots");
}

TEST_F(NewFormat, is_refused_with_a_sentence_if_it_is_cut_off) {
  const std::filesystem::path file = folder_ / "a.dots";
  write_scene(cloud_, file, pool_);
  std::filesystem::resize_file(file, 8 + 149 * 32);
  EXPECT_EQ(error_of([&] { read_scene(file, pool_); }, ErrorKind::input),
            file.string() + ": cut off: 150 Gaussians need more than 4768 bytes");
}

TEST_F(NewFormat, is_in_the_list_of_formats) {
  const std::string list = output_of({"--list-formats"});
  EXPECT_NE(list.find("| dots | `.dots` | round Gaussians of one colour |"), std::string::npos);
  EXPECT_NE(list.find("| dots | `.dots` | round Gaussians | RDF | 0 |"), std::string::npos);
}

}  // namespace
}  // namespace qs
