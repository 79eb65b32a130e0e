// SPDX-License-Identifier: MIT
//
// Small files that claim much memory: by the sizes they announce, by compression, or by naming data
// repeatedly.
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <zip.h>

#include "base/error.h"
#include "io/scene/reader.h"
#include "io/scene/spz/spz.h"
#include "io/support/limits.h"
#include "support/corpus.h"
#include "support/gzip.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using Bytes = std::vector<std::byte>;

std::string codebooks() {
  std::string zeros = "0";
  for (int i = 1; i < 256; ++i) zeros += ",0";
  const std::string entry = R"("codebook":[)" + zeros + R"(],"files":["a"]},)";
  return R"("scales":{)" + entry + R"("sh0":{)" + entry;
}

TEST(Bombs, in_gzip_are_refused_before_memory_is_taken) {
  Bytes plain = gunzip(file_bytes(committed_corpus() / "broken/spz_frac0.spz"));
  plain[11] = std::byte{0x17};  // 386 million Gaussians
  ThreadPool pool(2);
  Scene scene;
  EXPECT_THROW(read_spz(gzip(plain, 1), "bomb", pool, {}, scene), Error);
  EXPECT_TRUE(scene.cloud.empty());
}

// Otherwise 20 bytes of JSON could allocate the whole file once more.
TEST(Bombs, buffers_that_name_one_file_share_it) {
  const TemporaryFolder folder;
  const std::size_t big = 8 << 20;
  write_bytes(folder / "big.bin", Bytes(big));
  std::ifstream stream(committed_corpus() / "valid/gltf_datauri.gltf");
  nlohmann::json gltf = nlohmann::json::parse(stream);
  for (const char* name : {"big.bin", "./big.bin", ".//./big.bin", "big.bin"}) {
    for (int i = 0; i < 10; ++i) gltf["buffers"].push_back({{"byteLength", 1}, {"uri", name}});
  }
  write_bytes(folder / "a.gltf", to_bytes(gltf.dump()));
  const HeapPeak heap;
  EXPECT_EQ(read_scene(folder / "a.gltf").file_bytes,
            std::filesystem::file_size(folder / "a.gltf") + big);
  EXPECT_LT(heap.bytes(), 2 * big);
}

TEST(Bombs, scenes_of_a_tree_are_one_under_all_their_names) {
  const TemporaryFolder folder;
  const auto scene_file = folder / "tree/lod-meta.json";
  std::filesystem::copy(committed_corpus() / "valid/lod_of_sog_v1", folder / "tree",
                        std::filesystem::copy_options::recursive);
  std::filesystem::remove(scene_file);
  const auto leaf = [](int file) {
    return R"({"lods":{"0":{"file":)" + std::to_string(file) + R"(,"offset":0,"count":800}}})";
  };
  write_bytes(scene_file, to_bytes(R"({"filenames":["0/meta.json","./0/meta.json"],"lodLevels":1,)"
                                   R"("tree":{"children":[)" +
                                   leaf(0) + "," + leaf(1) + "]}}"));
  try {
    read_scene(scene_file);
    ADD_FAILURE() << "900 Gaussians were read as 1600";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("more Gaussians than their files have"),
              std::string::npos);
  }
}

// 64 MiB of zeros in an archive of 64 KiB.
TEST(Bombs, in_a_zip_are_refused_before_memory_is_taken) {
  const TemporaryFolder folder;
  const auto path = folder / "bomb.sog";
  const std::string meta = R"({"version":2,"count":100000000,)" + codebooks() +
                           R"("means":{"mins":[0,0,0],"maxs":[1,1,1],"files":["a","a"]},)"
                           R"("quats":{"files":["a"]}})";
  const std::string zeros(64 << 20, '\0');
  zip_t* const archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
  ASSERT_NE(archive, nullptr);
  const auto add = [archive](const char* name, const std::string& content) {
    zip_source_t* const source = zip_source_buffer(archive, content.data(), content.size(), 0);
    return zip_file_add(archive, name, source, 0) >= 0;
  };
  ASSERT_TRUE(add("meta.json", meta) && add("a", zeros));
  ASSERT_EQ(zip_close(archive), 0);
  ASSERT_LT(std::filesystem::file_size(path), 100u << 10);

  const HeapPeak heap;
  try {
    read_scene(path);
    ADD_FAILURE() << "a bomb was read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("more bytes unpacked"), std::string::npos)
        << error.what();
  }
  EXPECT_LT(heap.bytes(), 8u << 20);
}

}  // namespace
}  // namespace qs::test
