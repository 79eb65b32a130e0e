// SPDX-License-Identifier: MIT
//
// A case that is not in the corpus: SH of degree 4.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/scene/ply/ply.h"
#include "io/scene/writer.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::size_t kCount = 20, kDegree3 = 15, kDegree4 = 24;  // values per channel

Scene read(const std::vector<std::byte>& bytes) {
  Scene scene;
  scene.path = "test.compressed.ply";
  ThreadPool pool(2);
  read_compressed_ply(bytes, scene.path, pool, {}, scene);
  return scene;
}

std::vector<std::byte> written() {
  const TemporaryFolder folder;
  write_scene(random_cloud(kCount, 3, 8), folder / "a.compressed.ply");
  return file_bytes(folder / "a.compressed.ply");
}

// The same file with nine more values per channel.
std::vector<std::byte> with_degree_4(const std::vector<std::byte>& bytes) {
  std::string file(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string rows = file.substr(file.size() - kCount * 3 * kDegree3);
  file.resize(file.size() - rows.size());
  std::string names;
  for (std::size_t i = 3 * kDegree3; i < 3 * kDegree4; ++i) {
    names += "property uchar f_rest_" + std::to_string(i) + "\n";
  }
  file.insert(file.find("end_header"), names);
  for (std::size_t at = 0; at < rows.size(); at += kDegree3) {
    file += rows.substr(at, kDegree3) + std::string(kDegree4 - kDegree3, '\xff');
  }
  return to_bytes(file);
}

TEST(CompressedPly, degree_4_is_cut_to_degree_3) {
  const auto bytes = written();
  const Scene scene = read(with_degree_4(bytes));
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("degree 4 were cut")));
  EXPECT_EQ(scene.cloud.sh_degree, 3);
  EXPECT_EQ(scene.cloud.sh, read(bytes).cloud.sh);
}

// A count in the header is changed, and `added` bytes follow the rows of the chunks.
std::string error_with(const std::string& count, const std::string& changed, std::size_t added) {
  const auto bytes = written();
  std::string file(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  file.replace(file.find(count), count.size(), changed);
  file.insert(file.find("end_header\n") + 11, std::string(added, '\0'));
  return error_of([&] { read(to_bytes(file)); });
}

TEST(CompressedPly, the_counts_of_its_elements_must_agree) {
  EXPECT_EQ(error_with("element chunk 1", "element chunk 1", 0), "");
  EXPECT_THAT(error_with("element chunk 1", "element chunk 2", 18 * 4),
              HasSubstr("2 chunks for 20 Gaussians, 1 are needed"));
  EXPECT_THAT(error_with("element sh 20", "element sh 19", 0),
              HasSubstr("19 rows of element sh for 20 Gaussians"));
}

}  // namespace
}  // namespace qs::test
