// SPDX-License-Identifier: MIT
//
// quadsplat film as users run it. A script replaces ffmpeg; where ffmpeg is installed, its films
// are measured with ffprobe.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <set>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/film/film.h"
#include "app/support/run_program.h"
#include "io/bytes/json_text.h"
#include "io/picture/image_file.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using test::ProgramRun;
using test::run_quadsplat;
using testing::ElementsAre;
using testing::HasSubstr;

class FilmProgram : public testing::Test {
 protected:
  FilmProgram() : path_variable_(std::getenv("PATH")) {
    GaussianCloud cloud = test::random_cloud(100, 1, 4);
    test::write_scene(cloud, folder_ / "scene.ply");
    std::filesystem::create_directory(folder_ / "out");
    std::filesystem::create_directory(folder_ / "bin");
    Camera second = test::front_camera(48, 32);
    second.view_from_world[3].x = 0.5;
    test::write_cameras({test::front_camera(48, 32), second}, folder_ / "cameras.json");
  }
  ~FilmProgram() override { setenv("PATH", path_variable_.c_str(), 1); }

  // From now on ffmpeg is a shell script with these commands, and no other program is on the PATH.
  void install_ffmpeg(const std::string& commands) {
    std::ofstream(folder_ / "bin/ffmpeg") << "#!/bin/sh\n" << commands << "\n";
    std::filesystem::permissions(folder_ / "bin/ffmpeg", std::filesystem::perms::owner_all);
    setenv("PATH", (folder_ / "bin").c_str(), 1);
  }

  ProgramRun film(const std::string& output, std::vector<std::string> more,
                  const std::function<void(pid_t)>& meanwhile = {}) {
    std::vector<std::string> words = {"film",      (folder_ / "scene.ply").string(),
                                      "--backend", "cpu",
                                      "--output",  (folder_ / "out" / output).string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_quadsplat(words, meanwhile);
  }
  std::set<std::string> written() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "out"))
      names.insert(entry.path().filename().string());
    return names;
  }
  std::string text_of(const std::string& name) const {
    return read_text_file(folder_ / name, 1 << 26);
  }

  TemporaryFolder folder_;
  std::string path_variable_;
};

TEST_F(FilmProgram, a_folder_of_pictures_needs_no_ffmpeg) {
  setenv("PATH", "", 1);
  const ProgramRun run = film("pictures", {"--size", "48x32", "--seconds", "0.5", "--fps", "8"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("out/pictures (4 pictures, 48 x 32, 8 per second)\n"));
  EXPECT_EQ(run.out, "");
  for (int i = 0; i < 4; ++i) {
    const Image picture = read_image(folder_ / "out/pictures" / fmt::format("frame_{:05}.png", i));
    EXPECT_EQ(picture.width, 48);
    EXPECT_EQ(picture.height, 32);
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/pictures/frame_00004.png"));
}

TEST_F(FilmProgram, without_ffmpeg_one_sentence_says_what_to_do) {
  setenv("PATH", (folder_ / "bin").c_str(), 1);
  const ProgramRun run = film("film.mp4", {"--seconds", "0.1"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("film.mp4: ffmpeg encodes films and is not installed; a name "
                                 "without an ending, such as film, is a folder of PNG files"));
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1);
  EXPECT_THAT(written(), testing::IsEmpty());
}

TEST_F(FilmProgram, heat_maps_lie_over_the_colours_with_their_scale_at_the_top) {
  const std::vector<std::string> plain = {"--size", "400x300", "--seconds", "0.1",       "--fps",
                                          "10",     "--cull",  "quadbox",   "--heatmap", "pairs"};
  std::vector<std::string> fixed = plain;
  fixed.insert(fixed.end(), {"--heatmap-max", "77"});
  const ProgramRun run = film("fitted", plain);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("heat map pairs: colours from 0 to "));
  EXPECT_THAT(film("fixed", fixed).err,
              HasSubstr("heat map pairs: colours from 0 to 77 pairs per tile\n"));
  const Image a = read_image(folder_ / "out/fitted/frame_00000.png");
  const Image b = read_image(folder_ / "out/fixed/frame_00000.png");
  int top = 0;  // pixels in which the texts of the scales differ
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 400; ++x) top += a.at(x, y, 0) != b.at(x, y, 0);
  EXPECT_GT(top, 20);
}

TEST_F(FilmProgram, ffmpeg_gets_the_pixels_the_size_and_the_rate) {
  const std::string seen = (folder_ / "words").string();
  install_ffmpeg("echo \"$@\" > " + seen +
                 "\nfor last; do :; done\nexec /bin/cat > \"${last#file:}\"");
  const std::vector<std::string> more = {"--camera-path", (folder_ / "cameras.json").string(),
                                         "--size",        "48x32",
                                         "--fps",         "2.5",
                                         "--cull",        "3dgs,exact",
                                         "--numbers",     "off",
                                         "--seconds",     "1.2"};
  const ProgramRun run = film("film.mp4", more);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("film.mp4 (3 pictures, 48 x 32, 2.5 per second)\n"));
  EXPECT_THAT(run.out, HasSubstr("\n3dgs "));
  EXPECT_THAT(run.out, HasSubstr("\nexact "));
  EXPECT_THAT(text_of("words"), HasSubstr(" -video_size 48x32 -framerate 2.5 "));
  EXPECT_THAT(text_of("words"), HasSubstr(" -pix_fmt rgb24 "));
  // The same film as pictures.
  ASSERT_EQ(film("pictures", more).exit_code, 0);
  const std::string bytes = text_of("out/film.mp4");
  ASSERT_EQ(bytes.size(), 3u * 48 * 32 * 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const Image picture = read_image(folder_ / "out/pictures" / fmt::format("frame_{:05}.png", i));
    for (std::size_t k = 0; k < picture.values.size(); ++k)
      ASSERT_EQ(static_cast<unsigned char>(bytes[i * 48 * 32 * 3 + k]), to_8bit(picture.values[k]));
  }
  EXPECT_THAT(written(), ElementsAre("film.mp4", "pictures"));
}

TEST_F(FilmProgram, numbers_are_part_of_the_picture_with_several_modes) {
  const std::vector<std::string> plain = {"--size", "400x200", "--seconds", "0.1",
                                          "--fps",  "10",      "--cull",    "exact,quadbox"};
  std::vector<std::string> without = plain, one = plain;
  without.insert(without.end(), {"--numbers", "off"});
  one.back() = "quadbox";
  ASSERT_EQ(film("with", plain).exit_code, 0);
  ASSERT_EQ(film("without", without).exit_code, 0);
  ASSERT_EQ(film("one", one).exit_code, 0);
  const auto picture = [&](const char* name) {
    return read_image(folder_ / "out" / name / "frame_00000.png");
  };
  const Image a = picture("with"), b = picture("without"), c = picture("one");
  const auto differ = [](const Image& one_of_them, const Image& other, int top, int bottom) {
    int count = 0;
    for (int y = top; y < bottom; ++y)
      for (int x = 0; x < 400; ++x)
        count += std::abs(x - 200) > 2 && one_of_them.at(x, y, 0) != other.at(x, y, 0);
    return count;
  };
  EXPECT_GT(differ(a, b, 150, 200), 1000);
  EXPECT_EQ(differ(a, b, 0, 100), 0);
  EXPECT_EQ(differ(b, c, 0, 200), 0);  // both modes are lossless
}

TEST_F(FilmProgram, what_ffmpeg_complains_about_is_the_message_and_no_file_is_left) {
  install_ffmpeg(
      "for last; do :; done\necho half > \"${last#file:}\"\n"
      "echo 'the codec is missing' >&2\necho later >&2\nexit 4");
  const ProgramRun run = film("film.mp4", {"--size", "400x300", "--seconds", "1"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("film.mp4: ffmpeg "));
  EXPECT_THAT(run.err, HasSubstr(": the codec is missing\n"));
  EXPECT_THAT(written(), testing::IsEmpty());
  install_ffmpeg("/bin/cat > /dev/null\necho 'the disk is full' >&2\nexit 1");
  EXPECT_THAT(film("film.mp4", {"--size", "48x32", "--seconds", "0.1"}).err,
              HasSubstr("film.mp4: ffmpeg failed: the disk is full\n"));
}

TEST_F(FilmProgram, an_interrupted_film_leaves_no_file) {
  const std::filesystem::path begun = folder_ / "begun";
  install_ffmpeg(
      "for last; do :; done\necho half > \"${last#file:}\"\n"
      "echo > " +
      begun.string() + "\nexec /bin/cat > /dev/null");
  for (const int signal : {SIGINT, SIGTERM}) {
    std::filesystem::remove(begun);
    // Of 36,000 s: it cannot end before the signal arrives.
    const ProgramRun run =
        film("film.mp4", {"--size", "48x32", "--seconds", "36000"}, [&](pid_t pid) {
          for (int i = 0; i < 60000 && !std::filesystem::exists(begun); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
          kill(pid, signal);
        });
    EXPECT_TRUE(std::filesystem::exists(begun));
    EXPECT_EQ(run.exit_code, 130);
    EXPECT_EQ(run.err, "quadsplat: interrupted: nothing was written\n");
    EXPECT_THAT(written(), testing::IsEmpty());
  }
}

TEST_F(FilmProgram, options_that_exclude_each_other_are_refused) {
  const std::string path = (folder_ / "cameras.json").string();
  EXPECT_THAT(film("a", {"--turntable", "--camera-path", path}).err,
              HasSubstr("film: --turntable and --camera-path exclude each other"));
  EXPECT_THAT(film("a", {"--arc", "90", "--camera-path", path}).err,
              HasSubstr("film: --arc is the angle of a turntable"));
  EXPECT_THAT(film("a", {"--loop"}).err, HasSubstr("film: --loop needs a --camera-path"));
  EXPECT_THAT(film("a", {"--heatmap", "pairs", "--picture", "depth"}).err,
              HasSubstr("film: --heatmap is drawn over colours, not over --picture depth"));
  EXPECT_THAT(film("a", {"--heatmap", "pairs", "--cull", "reference"}).err,
              HasSubstr("film: --heatmap pairs: mode reference has no tile lists"));
}

TEST_F(FilmProgram, ffmpeg_s_films_have_the_size_the_rate_and_the_number_of_pictures) {
  if (!ffmpeg_is_installed() || std::system("ffprobe -version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "ffmpeg is not installed";
  for (const std::string ending : {".mp4", ".webm", ".gif"}) {
    const ProgramRun run = film("film" + ending, {"--size", "64x48", "--seconds", "1.4", "--fps",
                                                  "5", "--cull", "3dgs,quadbox"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const std::string facts = (folder_ / "facts").string();
    const std::string line =
        "ffprobe -v error -count_frames -of csv=p=0 -show_entries "
        "stream=width,height,r_frame_rate,nb_read_frames " +
        (folder_ / "out" / ("film" + ending)).string() + " > " + facts;
    ASSERT_EQ(std::system(line.c_str()), 0);
    EXPECT_EQ(text_of("facts"), "64,48,5/1,7\n") << ending;
  }
}

}  // namespace
}  // namespace qs
