// SPDX-License-Identifier: MIT
//
// Files in the place of a scene: pointers of Git LFS, zip archives of one .ply, and model folders
// of LiteGS.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "io/scene/reader.h"
#include "io/support/zip_archive.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/scene_files.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

void write_at(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

const char* const kPointer =
    "version https://git-lfs.github.com/spec/v1\noid sha256:0f4a\nsize 12345\n";
const char* const kSentence = "a Git LFS pointer, not the file: git lfs pull";

std::string one_gaussian(float x) {
  return fmt::format(
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
      "property float opacity\nproperty float scale_0\nproperty float scale_1\n"
      "property float scale_2\nproperty float rot_0\nproperty float rot_1\nproperty float rot_2\n"
      "property float rot_3\nend_header\n{} 0 0 0 0 0 0 0 0 0 1 0 0 0\n",
      x);
}

TEST(WrappedFiles, pointers_of_git_lfs_are_named_in_every_format) {
  const TemporaryFolder folder;
  for (const char* name :
       {"a.ply", "a.compressed.ply", "a.spz", "a.splat", "a.ksplat", "a.sog", "a.zip", "meta.json",
        "lod-meta.json", "a.glb", "a.gltf", "a.npz", "a"}) {
    SCOPED_TRACE(name);
    write_at(folder / name, kPointer);
    EXPECT_THAT(test::error_of([&] { read_scene(folder / name); }, folder.path()),
                EndsWith(std::string(name) + ": " + kSentence));
  }
  for (const char* name : {"cameras.json", "transforms.json", "images.bin", "images.txt"}) {
    SCOPED_TRACE(name);
    write_at(folder / name, kPointer);
    EXPECT_THAT(test::error_of([&] { read_cameras(folder / name); }), HasSubstr(kSentence));
  }
  for (const char* name : {"a.png", "a.jpg", "a.ppm", "a.npy"}) {
    SCOPED_TRACE(name);
    write_at(folder / name, kPointer);
    EXPECT_THAT(test::error_of([&] { read_image(folder / name); }), HasSubstr(kSentence));
  }
}

TEST(WrappedFiles, a_zip_with_one_ply_is_read) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "scene.zip";
  for (const bool deflated : {false, true}) {
    for (const ZipEntries& entries : std::initializer_list<ZipEntries>{
             {{"a.ply", one_gaussian(7)}},
             {{"folder/a.ply", one_gaussian(7)}},
             {{"a.PLY", one_gaussian(7)}},
             {{"licence.txt", "free"}, {"a.ply", one_gaussian(7)}},
             {{"a.ply", one_gaussian(7)}, {"cameras.json", "[]"}},
             {{"__MACOSX/._a.ply", "x"}, {"a.ply", one_gaussian(7)}}}) {
      write_zip(file, entries, deflated);
      const Scene scene = read_scene(file);
      EXPECT_EQ(scene.cloud.positions[0].x, 7);
      EXPECT_THAT(scene.format, HasSubstr("zipped ply"));
    }
  }
  write_zip(file, {{"a.ply", one_gaussian(7)}, {"b.ply", one_gaussian(8)}});
  EXPECT_THAT(test::error_of([&] { read_scene(file); }), HasSubstr("several: unpack it"));
  write_zip(file, {{"a.ply", "ply\nformat ascii 1.0\n"}});
  EXPECT_THAT(test::error_of([&] { read_scene(file); }),
              HasSubstr("a.ply: the .ply header ends early"));
  write_zip(file, {{"readme.txt", "nothing"}});
  EXPECT_THAT(test::error_of([&] { read_scene(file); }),
              HasSubstr("a zip archive without meta.json"));
}

TEST(WrappedFiles, the_last_model_of_litegs_is_in_the_folder_finish) {
  const TemporaryFolder folder;
  write_at(folder / "point_cloud/finish/point_cloud.ply", one_gaussian(1));
  EXPECT_EQ(read_scene(folder.path()).cloud.positions[0].x, 1);
  EXPECT_EQ(read_scene(folder / "point_cloud").cloud.positions[0].x, 1);
  write_at(folder / "point_cloud/iteration_100/point_cloud.ply", one_gaussian(2));
  EXPECT_EQ(read_scene(folder.path()).cloud.positions[0].x, 1);
  ReadOptions earlier;
  earlier.iteration = 100;
  EXPECT_EQ(read_scene(folder.path(), earlier).cloud.positions[0].x, 2);
}

}  // namespace
}  // namespace qs::test
