// SPDX-License-Identifier: MIT
//
// The files that commands write: never onto an input, never onto somebody else's file, and whole
// folders or none. Signals end every command within a second and leave nothing unfinished.
#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "app/cli/command.h"
#include "app/measure/camera_path.h"
#include "app/support/program_in_folder.h"
#include "io/picture/image_file.h"
#include "raster/kernel/cull/mode.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

namespace fs = std::filesystem;
using test::ProgramRun;
using test::run_quadsplat;
using testing::HasSubstr;
using testing::Not;
using Words = std::vector<std::string>;

class OutputFiles : public test::ProgramInFolder {
 protected:
  void write_path() const {
    const Camera camera = test::front_camera(32, 24);
    std::ofstream(folder_ / "path.json") << format_camera_path({{0, camera}, {9, camera}});
  }

  static std::string text_of(const fs::path& file) { return test::content_of(file); }

  // Every file below the folder.
  std::map<std::string, std::string> files() const {
    std::map<std::string, std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(folder_.path()))
      all[entry.path().lexically_relative(folder_.path()).string()] =
          entry.is_directory() ? "folder" : text_of(entry.path());
    return all;
  }
};

constexpr const char* kFew = " --frames 1 --warmup 0 --backend cpu --cull quadbox";

TEST_F(OutputFiles, no_command_writes_onto_one_of_its_inputs) {
  fs::create_symlink(path("scene.ply"), folder_ / "link.ply");
  fs::create_hard_link(path("scene.ply"), folder_ / "hard.ply");
  ASSERT_EQ(run("bench @scene.ply --out-dir @bench" + std::string(kFew)).exit_code, kExitOk);
  ASSERT_EQ(run("zoom @scene.ply --steps 2 --out-dir @zoom" + std::string(kFew)).exit_code,
            kExitOk);
  write_image(Image(32, 24, 3), folder_ / "truth.png");
  const auto before = files();
  const std::string lines[] = {
      "convert @scene.ply @scene.ply --keep-largest 100",
      "convert @scene.ply @link.ply --keep-largest 100",
      "convert @scene.ply @hard.ply --keep-largest 100",
      "convert @scene.ply @images/../scene.ply",
      "convert @link.ply @scene.ply",
      "render @scene.ply --output @scene.ply --stats @cameras.json",
      "render @scene.ply --stats @cameras.json",
      "render @scene.ply --reference @truth.png --output @truth.png",
      "film @scene.ply --camera-path @cameras.json --output @cameras.json",
      "inspect @scene.ply --json @cameras.json",
      "inspect @scene.ply --json @scene.ply",
      "info @scene.ply --json @scene.ply",
      "compare @scene.ply @hard.ply --json @scene.ply",
      "judge @images @scene.ply --csv @images/view.pfm",
      "merge @bench --out-dir @bench",
      "zoom --replay @zoom --out-dir @zoom" + std::string(kFew),
  };
  for (const std::string& line : lines) {
    for (const char* more : {"", " --overwrite"}) {
      const ProgramRun refused = run(line + more);
      EXPECT_NE(refused.exit_code, kExitOk) << line << more;
      if (*more == '\0' || line.starts_with("film")) continue;  // a .json is no film
      EXPECT_THAT(refused.err, HasSubstr("is an input of this command")) << line;
    }
  }
  auto after = files();
  for (const auto& [name, text] : before) EXPECT_EQ(after[name], text) << name;
}

TEST_F(OutputFiles, scenes_films_models_and_files_of_others_are_replaced_with_permission_only) {
  for (const char* name : {"other.ply", "film.gif", "picture.png", "bench/bench.csv", "a.json"}) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << "somebody's";
  }
  fs::create_directories(folder_ / "frames");
  std::ofstream(folder_ / "frames/frame_00000.png") << "somebody's";
  const std::string lines[] = {
      "convert @scene.ply @other.ply",
      "film @scene.ply --size 16x16 --seconds 0.1 --output @frames",
      "render @scene.ply --output @picture.png",
      "render @scene.ply --all-cameras --stats @a.json",
      "bench @scene.ply --out-dir @bench" + std::string(kFew),
      "inspect @scene.ply --json @a.json",
      "judge @scene.ply @scene.ply --size 16x16 --json @a.json --backend cpu",
      "conformance --out-dir @frames",
  };
  for (const std::string& line : lines) {
    const ProgramRun refused = run(line);
    EXPECT_EQ(refused.exit_code, kExitUsage) << line << refused.err;
    EXPECT_THAT(refused.err, HasSubstr("exists already")) << line;
    EXPECT_THAT(refused.err, HasSubstr("--overwrite")) << line;
  }
  for (const char* name : {"other.ply", "film.gif", "picture.png", "bench/bench.csv", "a.json",
                           "frames/frame_00000.png"})
    EXPECT_EQ(text_of(folder_ / name), "somebody's") << name;
  const ProgramRun replaced = run("convert @scene.ply @other.ply --overwrite");
  EXPECT_EQ(replaced.exit_code, kExitOk);
  EXPECT_THAT(replaced.err, HasSubstr("replaced 1 file of an earlier run\n"));
}

TEST_F(OutputFiles, own_pictures_and_reports_are_replaced_and_a_line_counts_them) {
  const std::pair<std::string, const char*> lines[] = {
      {"render @scene.ply --cull 3dgs,quadbox --repeats 1 --output @a.png --stats @stats.json",
       "replaced 3 files"},
      {"bench @scene.ply --out-dir @bench" + std::string(kFew), "replaced "},
      {"zoom @scene.ply --steps 2 --out-dir @zoom" + std::string(kFew), "replaced "},
      {"judge @scene.ply @scene.ply --size 16x16 --backend cpu --out-dir @judged",
       "replaced 3 files"},
      {"report @scene.ply --output @page.html", "replaced 1 file "},
      {"compare @scene.ply --cull quadbox --against adr --output @sheet.png", "replaced 1 file "},
      {"inspect @scene.ply --gaussian 0 --output @why.png", "replaced 1 file "}};
  for (const auto& [line, sentence] : lines) {
    const ProgramRun first = run(line), second = run(line);
    EXPECT_EQ(first.exit_code, kExitOk) << line << first.err;
    EXPECT_THAT(first.err, Not(HasSubstr("replaced"))) << line;
    EXPECT_EQ(second.exit_code, kExitOk) << line << second.err;
    EXPECT_THAT(second.err, HasSubstr(sentence)) << line;
  }
}

TEST_F(OutputFiles, a_full_disk_leaves_no_part_of_a_report) {
  struct rlimit kept {};
  getrlimit(RLIMIT_FSIZE, &kept);
  const rlimit small = {4000, kept.rlim_max};  // the table is smaller, the JSON is not
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  const ProgramRun full =
      run("bench @scene.ply --out-dir @bench" + std::string(kFew) + " --cull all");
  setrlimit(RLIMIT_FSIZE, &kept);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(full.exit_code, kExitInput);
  EXPECT_THAT(full.out, HasSubstr("| `quadbox` |"));
  EXPECT_THAT(full.err, HasSubstr(path("bench") + "/"));
  EXPECT_FALSE(fs::exists(folder_ / "bench"));
  for (const auto& [name, text] : files()) EXPECT_FALSE(name.starts_with('.')) << name;
}

// ---- signals ------------------------------------------------------------------------------------
class Interrupted : public OutputFiles {
 protected:
  // True once the process catches the signal; before that, on a busy machine, it would end it.
  static bool catches(pid_t process, int signal) {
    std::ifstream status(fmt::format("/proc/{}/status", process));
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with("SigCgt:"))
        return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
    }
    return true;  // the process has ended
  }
  // The command is interrupted as soon as it has run for a while.
  ProgramRun interrupt(const std::string& line, int signal = SIGINT) const {
    return run(line, [&](pid_t process) {
      while (!catches(process, signal)) std::this_thread::sleep_for(std::chrono::milliseconds(2));
      std::this_thread::sleep_for(std::chrono::milliseconds(400));
      kill(process, signal);
    });
  }
};

TEST_F(Interrupted, commands_end_with_130_say_what_is_kept_and_leave_nothing_unfinished) {
  const auto before = files();
  // Each takes hours.
  const std::string lines[] = {
      "bench @scene.ply --frames 100000 --backend cpu --out-dir @out",
      "zoom @scene.ply --steps 10000 --frames 1000 --backend cpu --out-dir @out",
      "report @scene.ply --views 100000 --camera-path @path.json --path-steps 1000000 --output "
      "@out",
      "judge @scene.ply @scene.ply --camera-path @path.json --path-steps 1000000 --out-dir @out",
      "film @scene.ply --seconds 36000 --size 64x48 --backend cpu --output @out",
  };
  write_path();
  for (const std::string& line : lines) {
    for (const int signal : {SIGINT, SIGTERM}) {
      const ProgramRun ended = interrupt(line, signal);
      EXPECT_EQ(ended.exit_code, 130) << line << ended.err;
      EXPECT_THAT(ended.err, HasSubstr("quadsplat: interrupted: nothing was written\n")) << line;
    }
  }
  fs::remove(folder_ / "path.json");
  EXPECT_EQ(files(), before);
}

// The pictures of all modes are drawn before the frames that are measured.
TEST_F(Interrupted, pictures_of_an_unfinished_measurement_are_kept) {
  const fs::path last = folder_ / fmt::format("out_{}.png", mode_name(culler_count()));
  const ProgramRun ended =
      run("render @scene.ply --repeats 100000 --cull all --backend cpu --output @out.png",
          [&](pid_t process) {
            while (!fs::exists(last)) std::this_thread::sleep_for(std::chrono::milliseconds(2));
            std::this_thread::sleep_for(std::chrono::milliseconds(100));
            kill(process, SIGINT);
          });
  EXPECT_EQ(ended.exit_code, 130);
  EXPECT_THAT(ended.err,
              HasSubstr(fmt::format(" {} finished files are kept, the last is ", culler_count())));
}

TEST_F(Interrupted, finished_pictures_are_kept_and_named) {
  write_path();
  const ProgramRun ended = run(
      "render @scene.ply --camera-path @path.json --path-steps 1000000 --size 32x24 --backend cpu "
      "--output @out.png",
      [&](pid_t process) {
        while (!fs::exists(folder_ / "out_0003.png"))
          std::this_thread::sleep_for(std::chrono::milliseconds(2));
        kill(process, SIGINT);
      });
  EXPECT_EQ(ended.exit_code, 130);
  EXPECT_THAT(ended.err, HasSubstr(" finished files are kept, the last is " + path("out_")));
  for (const auto& [name, text] : files()) EXPECT_THAT(name, Not(testing::StartsWith(".")));
}

}  // namespace
}  // namespace qs
