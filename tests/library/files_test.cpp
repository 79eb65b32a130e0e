// SPDX-License-Identifier: MIT
// Cameras of files, and scenes as files, as the program reads and writes them.
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "app/support/run_program.h"
#include "io/camera/cameras.h"
#include "library/opened_scene.h"
#include "support/error_of.h"
#include "support/paths.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

void expect_same(const QsCamera& found, const Camera& camera) {
  const QsCamera expected = test::c_camera(camera);
  EXPECT_EQ(std::vector<double>(found.view_from_world, found.view_from_world + 12),
            std::vector<double>(expected.view_from_world, expected.view_from_world + 12));
  EXPECT_EQ(found.focal_px[0], expected.focal_px[0]);
  EXPECT_EQ(found.focal_px[1], expected.focal_px[1]);
  EXPECT_EQ(found.center_px[0], expected.center_px[0]);
  EXPECT_EQ(found.center_px[1], expected.center_px[1]);
  EXPECT_EQ(found.width, expected.width);
  EXPECT_EQ(found.height, expected.height);
  EXPECT_EQ(found.near_depth, expected.near_depth);
}

TEST(LibraryCameras, of_every_format_are_the_programs) {
  const std::filesystem::path data = test::source_path("tests/data/cameras");
  for (const char* name : {"cameras.json", "images.bin", "images.txt", "transforms.json"}) {
    SCOPED_TRACE(name);
    std::vector<std::string> names;
    const std::vector<QsCamera> found = quadsplat::read_cameras((data / name).string(), &names);
    const std::vector<Camera> expected = read_cameras(data / name);
    ASSERT_EQ(found.size(), expected.size());
    ASSERT_FALSE(found.empty());
    for (std::size_t i = 0; i < found.size(); ++i) {
      expect_same(found[i], expected[i]);
      EXPECT_EQ(names[i], expected[i].name);
    }
  }
}

TEST(LibraryCameras, with_lenses_have_the_model_and_its_parameters) {
  const std::filesystem::path data = test::source_path("tests/data/lenses");
  std::vector<std::string> names;
  const QsCamera face = quadsplat::read_cameras((data / "cameras.json").string()).at(0);
  const QsCamera taken =
      quadsplat::read_cameras((data / "cameras.json").string(), &names, true).at(0);
  EXPECT_EQ(face.model[0], 0);
  EXPECT_EQ(face.width, 46);
  EXPECT_STREQ(taken.model, "OPENCV_FISHEYE");
  EXPECT_EQ(taken.width, 64);
  EXPECT_EQ(taken.parameter_count, 8u);
  EXPECT_EQ(std::vector<double>(taken.parameters, taken.parameters + 9),
            (std::vector<double>{20.4, 20.4, 32, 32, 0.01, 0, 0, 0, 0}));
  // The face looks to the right of a lens that looks along z, from (0, 0, 1).
  for (int i = 0; i < 12; ++i)
    EXPECT_DOUBLE_EQ(taken.view_from_world[i], i == 11 ? -1 : i % 5 == 0 ? 1 : 0) << i;
  QsCamera small = taken;
  quadsplat::check(qs_camera_resize, &small, 80, 32);
  EXPECT_EQ(std::vector<double>(small.parameters, small.parameters + 5),
            (std::vector<double>{10.2, 10.2, 40, 16, 0.01}));
  QsCamera pinhole = test::plush_camera(0, 60, 40);
  const QsCamera before = pinhole;
  test::set_model(pinhole, "PINHOLE",
                  {before.focal_px[0], before.focal_px[1], before.center_px[0] + 0.5,
                   before.center_px[1] + 0.5});
  quadsplat::check(qs_camera_resize, &pinhole, 60, 40);
  EXPECT_EQ(pinhole.model[0], 0);
  EXPECT_EQ(pinhole.parameter_count, 0u);
  EXPECT_DOUBLE_EQ(pinhole.focal_px[0], before.focal_px[0]);
  EXPECT_DOUBLE_EQ(pinhole.center_px[1], before.center_px[1]);
}

TEST(LibraryCameras, are_resized_as_by_the_program) {
  QsCamera camera = quadsplat::read_cameras(test::plush_cameras().string()).at(4);
  const Camera before = read_cameras(test::plush_cameras()).at(4);
  expect_same(camera, before);
  quadsplat::check(qs_camera_resize, &camera, 333, 55);
  expect_same(camera, before.resized(333, 55));
}

TEST(LibraryCameras, that_cannot_be_read_have_the_sentence_of_the_program) {
  const TemporaryFolder folder;
  std::ofstream(folder / "cameras.json") << "[{\"width\": 0}]";
  for (const char* name : {"missing.json", "cameras.json"}) {
    const std::string path = (folder / name).string();
    EXPECT_EQ(test::sentence_of([&] { quadsplat::read_cameras(path); }, QS_INPUT),
              test::error_of([&] { read_cameras(path); }, ErrorKind::input));
  }
}

class LibraryConvert : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void expect_as_program(const std::string& name, const QsConversion& conversion,
                         const std::vector<std::string>& options) {
    scene_.convert(path("library" + name), conversion);
    std::vector<std::string> words = {"convert", test::plush().string(), path("program" + name)};
    words.insert(words.end(), options.begin(), options.end());
    const test::ProgramRun run = test::run_quadsplat(words);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const std::string bytes = test::content_of(path("library" + name));
    EXPECT_TRUE(bytes == test::content_of(path("program" + name))) << name;
    EXPECT_GT(bytes.size(), 1000u);
  }

  TemporaryFolder folder_;
  quadsplat::Context context_ = test::cpu();
  quadsplat::Scene scene_ = context_.load(test::plush().string());
};

TEST_F(LibraryConvert, writes_the_bytes_of_the_program) {
  for (const WriterRow& row : writers()) {
    QsConversion conversion = QS_CONVERSION;
    conversion.format = row.name;
    expect_as_program(std::string("_") + row.name + row.extension, conversion,
                      {"--format", row.name});
  }
  QsConversion less = QS_CONVERSION;
  less.sh_degree = 1;
  less.keep_largest = 1000;
  expect_as_program("_less.ply", less, {"--sh-degree", "1", "--keep-largest", "1000"});
  QsConversion cropped = QS_CONVERSION;
  for (int axis = 0; axis < 3; ++axis) {
    cropped.crop_low[axis] = -4;
    cropped.crop_high[axis] = 4.5f;
  }
  cropped.drops_floaters = 1;
  cropped.keep_largest = 500;
  expect_as_program("_cropped.ply", cropped,
                    {"--crop", "-4,-4,-4,4.5,4.5,4.5", "--drop-floaters", "--keep-largest", "500"});
  QsConversion old = QS_CONVERSION;  // of a caller whose struct ends before the box
  old.size = 32;
  old.crop_low[0] = 1;
  expect_as_program("_old.ply", old, {});
  scene_.convert(path("by_ending.ply"));
  EXPECT_TRUE(test::content_of(path("by_ending.ply")) == test::content_of(path("library_ply.ply")));
}

TEST_F(LibraryConvert, replaces_a_file_only_if_allowed_and_never_the_scenes) {
  const std::string target = path("scene.ply");
  scene_.convert(target);
  const std::string before = test::content_of(target);
  QsConversion conversion = QS_CONVERSION;
  conversion.keep_largest = 10;
  EXPECT_EQ(
      test::sentence_of([&] { scene_.convert(target, conversion); }),
      target + ": exists already: choose another name, or replace it with the option overwrite");
  EXPECT_TRUE(test::content_of(target) == before);
  conversion.overwrite = 1;
  quadsplat::Scene copy = context_.load(target);
  scene_.convert(target, conversion);
  EXPECT_LT(test::content_of(target).size(), before.size());
  EXPECT_EQ(test::sentence_of([&] { copy.convert(target, conversion); }),
            target + ": is an input of this command, which never writes onto its inputs");
}

TEST_F(LibraryConvert, names_what_cannot_be_written) {
  const std::string unknown = path("scene.xyz");
  EXPECT_EQ(test::sentence_of([&] { scene_.convert(unknown); }),
            test::error_of([&] { test::write_scene(GaussianCloud(), unknown); }));
  const std::string nowhere = path("no_folder/scene.ply");
  EXPECT_EQ(test::sentence_of([&] { scene_.convert(nowhere); }, QS_INPUT),
            nowhere + ": cannot be written: the folder " + path("no_folder") + " does not exist");
  const GaussianCloud none;
  quadsplat::Scene empty = context_.wrap(test::gaussians_of(none));
  EXPECT_EQ(test::sentence_of([&] { empty.convert(path("empty.ply")); }),
            "qs_convert: scene: has no Gaussian to write");
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(LibraryConvert, of_wrapped_gaussians_reads_back) {
  const GaussianCloud cloud = test::random_cloud(200, 2, 4);
  quadsplat::Scene wrapped = context_.wrap(test::gaussians_of(cloud));
  wrapped.convert(path("wrapped.ply"));
  const Scene read = test::read_scene(path("wrapped.ply"));
  EXPECT_EQ(read.cloud.positions, cloud.positions);
  EXPECT_EQ(read.cloud.sh, cloud.sh);
  EXPECT_EQ(read.cloud.opacity_logits, cloud.opacity_logits);
}

// A mapped file would kill the process.
TEST(LibraryFiles, that_another_program_truncates_during_reading_are_errors) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder / "scene.ply";
  test::write_scene(test::random_cloud(1000, 3, 1), path);
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  std::jthread other([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::filesystem::resize_file(path, 64 << 20);
      std::this_thread::sleep_for(std::chrono::microseconds(500));
      std::filesystem::resize_file(path, bytes);
    }
  });
  quadsplat::Context context = test::cpu(1);
  std::string sentence;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (sentence.empty() && std::chrono::steady_clock::now() < end)
    sentence = test::sentence_of([&] { context.load(path.string()); }, QS_INPUT);
  EXPECT_NE(sentence.find("another program truncated it during reading"), std::string::npos)
      << sentence;
}

}  // namespace
}  // namespace qs
