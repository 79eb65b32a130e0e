// SPDX-License-Identifier: MIT
//
// The answers to wrong command lines that new users type, by topic, compared with transcripts in
// tests/golden/transcripts/errors_*.txt. Each answer is one sentence that names who, where and
// what.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "app/support/transcript.h"
#include "io/bytes/json_text.h"
#include "io/picture/image_file.h"
#include "support/golden.h"

namespace qs {
namespace {

namespace fs = std::filesystem;

void write_text_to(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

// The transcript's files, and files that are damaged, foreign or something else than needed.
class Refusals : public testing::Test {
 protected:
  Refusals() {
    fs::create_directories("empty");
    fs::copy_file("scene.ply", "copy.ply");
    fs::create_symlink("scene.ply", "link.ply");
    fs::create_hard_link("scene.ply", "hard.ply");
    const std::string scene = read_text_file("scene.ply", 1 << 20);
    write_text_to("cut.ply", scene.substr(0, scene.size() - 100));
    write_text_to("head.ply", scene.substr(0, 60));
    write_text_to("empty.ply", "");
    write_text_to("cut.json", read_text_file("cameras.json", 1 << 20).substr(0, 200));
    write_text_to("list.json", "[]");
    write_text_to("other.json", R"({"a": 1})");
    write_text_to("noframes.json", R"({"camera_angle_x": 0.7, "frames": []})");
    for (const char* name : {"notes.txt", "mine.png", "mine.json", "mine.csv", "mine.html",
                             "mine.mp4", "mine.spz", "none.so"})
      write_text_to(name, "somebody's\n");
    write_image(Image(48, 32, 3), "picture.png");
    const std::string picture = read_text_file("picture.png", 1 << 20);
    write_text_to("cut.png", picture.substr(0, picture.size() / 2));
    fs::remove("none.so");
    // The layout of D-NeRF: no sizes, names without endings, times.
    fs::create_directories("dnerf/train");
    write_image(Image(48, 32, 3), "dnerf/train/r_000.png");
    write_text_to("dnerf/transforms.json",
                  R"({"camera_angle_x": 0.7, "frames": [{"file_path": "./train/r_000",
"rotation": 0.03, "time": 0.0,
"transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 4], [0, 0, 0, 1]]}]})");
  }

  void expect_answers(const std::string& topic, const std::vector<std::string>& command_lines) {
    for (const std::string& line : command_lines) log_.run(line);
    test::expect_golden_text("transcripts/errors_" + topic + ".txt", log_.text());
  }

  test::Transcript log_;
};

TEST_F(Refusals, misspelled_words_are_named_with_the_nearest_word) {
  expect_answers("words", {"--verison",
                           "--list-gpu",
                           "help",
                           "version",
                           "Render scene.ply",
                           "convrt scene.ply out.ply",
                           "scnee.ply",
                           "''",
                           "--cull exact render scene.ply",
                           "scene.ply render",
                           "scene.ply --heatmpa pairs",
                           "render scene.ply --heatmpa pairs",
                           "render scene.ply --heatmap pair --output a.png",
                           "render scene.ply --ouput a.png",
                           "render scene.ply -output a.png",
                           "render scene.ply --output=a.png --siez=8x8",
                           "render scene.ply --output",
                           "render scene.ply --cull quadboxx --output a.png",
                           "render scene.ply --cull QuadBox --output a.png",
                           "render scene.ply --cull quadbox, --output a.png",
                           "render scene.ply --backend gpu --output a.png",
                           "render scene.ply --pipeline fst --output a.png",
                           "render scene.ply --picture dept --output a.png",
                           "film scene.ply --ouput film.mp4",
                           "film scene.ply --output frames --ease end",
                           "train dnerf --iteratons 10",
                           "train dnerf --out-dir model --strategy mcm",
                           "bench scene.ply --baseline quadboxx",
                           "compare scene.ply --against quadboxx",
                           "view scene.ply --beside quadboxx",
                           "info scene.ply --jsno -",
                           "merge images --mixd",
                           "zoom scene.ply --fames 3",
                           "judge images images --shet-views 2",
                           "eval scene.ply --images images --hold-out 8",
                           "report scene.ply --backnd cpu",
                           "inspect scene.ply --pixels 1,1",
                           "conformance --jugde kit",
                           "convert scene.ply out.plyy",
                           "convert scene.ply out.ksplat",
                           "convert scene.ply out.ply --format plly",
                           "convert scene.ply out.ply --format PLY",
                           "convert scene.ply out.ply --format ''"});
}

TEST_F(Refusals, values_out_of_range_are_named_with_the_range) {
  expect_answers("values", {"render scene.ply --output a.png --size 0x0",
                            "render scene.ply --output a.png --size 99999x99999",
                            "render scene.ply --output a.png --size 640",
                            "render scene.ply --output a.png --size ''",
                            "render scene.ply --output ''",
                            "render '' --output a.png",
                            "render scene.ply --output a.png --camera-index -1",
                            "render scene.ply --output a.png --camera-index one",
                            "render scene.ply --output a.png --camera-index ''",
                            "render scene.ply --output a.png --splat-scale nan",
                            "render scene.ply --output a.png --splat-scale 1,5",
                            "render scene.ply --output a.png --tile-size 15",
                            "render scene.ply --output a.png --threads 0",
                            "render scene.ply --output a.png --sh-degree 5",
                            "render scene.ply --output a.png --background red",
                            "render scene.ply --output a.png --background 255,0,0",
                            "render scene.ply --output a.png --up w",
                            "render scene.ply --output a.png --axes XYZ",
                            "render scene.ply --output a.png --shard 3/2",
                            "render scene.ply --output a.png --shard 1",
                            "inspect scene.ply --pixel -1,0",
                            "inspect scene.ply --gaussian all",
                            "compare scene.ply --amplify 0",
                            "judge images images --flip-max 2",
                            "bench scene.ply --frames ten",
                            "bench scene.ply --replicate 2",
                            "bench scene.ply --plugin ,",
                            "zoom scene.ply --steps 1",
                            "zoom scene.ply --closest 2",
                            "film scene.ply --output frames --fps fast",
                            "film scene.ply --output frames --arc 400",
                            "film scene.ply --output film.mp4 --size 33x33",
                            "report scene.ply --output page.html --views 0",
                            "eval scene.ply --images images --holdout 0",
                            "train dnerf --out-dir model --iterations 0",
                            "train dnerf --out-dir model --photo-memory lots",
                            "train dnerf --out-dir ''",
                            "convert scene.ply out.ply --keep-largest 1.5",
                            "convert scene.ply out.ply --crop 1,2,3"});
}

TEST_F(Refusals, files_that_cannot_be_read_are_named_with_the_reason) {
  expect_answers("files", {"render none/scene.ply --output a.png",
                           "render scene.ply/ --output a.png",
                           "render empty.ply --output a.png",
                           "render head.ply --output a.png",
                           "render cut.ply --output a.png",
                           "render picture.png --output a.png",
                           "render images --output a.png",
                           "render cameras.json --output a.png",
                           "render dnerf/transforms.json --output a.png",
                           "render scene.ply --output a.png --reference none.png",
                           "render scene.ply --output a.png --reference cut.png",
                           "info picture.png",
                           "info empty",
                           "inspect notes.txt",
                           "compare scene.ply picture.png",
                           "compare scene.ply copy.ply link.ply",
                           "convert none.ply out.ply",
                           "film none.ply --output frames",
                           "report none.ply --output page.html",
                           "bench scene.ply none.ply",
                           "zoom none.ply",
                           "zoom --replay none",
                           "zoom --replay images",
                           "zoom --replay scene.ply",
                           "merge none",
                           "merge scene.ply",
                           "judge images none",
                           "judge images empty",
                           "judge images picture.png",
                           "eval scene.ply --images none",
                           "eval scene.ply --images picture.png",
                           "conformance --judge none",
                           "conformance --judge images",
                           "conformance --judge scene.ply",
                           "train none --out-dir model",
                           "train empty --out-dir model",
                           "train scene.ply --out-dir model",
                           "train . --images empty --out-dir model",
                           "train . --images notes.txt --out-dir model",
                           "train . --init picture.png --out-dir model",
                           "train . --out-dir model --resume"});
}

TEST_F(Refusals, cameras_that_are_not_cameras_are_named) {
  expect_answers("cameras", {"render scene.ply --cameras dnerf/transforms.json --output dnerf.png",
                             "render scene.ply --cameras none.json --output a.png",
                             "render scene.ply --cameras scene.ply --output a.png",
                             "render scene.ply --cameras picture.png --output a.png",
                             "render scene.ply --cameras empty.ply --output a.png",
                             "render scene.ply --cameras empty --output a.png",
                             "render scene.ply --cameras cut.json --output a.png",
                             "render scene.ply --cameras list.json --output a.png",
                             "render scene.ply --cameras other.json --output a.png",
                             "render scene.ply --cameras noframes.json --output a.png",
                             "render scene.ply --camera-json {} --output a.png",
                             "render scene.ply --camera-json cameras.json --output a.png",
                             "render scene.ply --camera-json '' --output a.png",
                             "render scene.ply --camera-path none.json --output a.png",
                             "render scene.ply --camera-path scene.ply --output a.png",
                             "render scene.ply --camera-path images --output a.png",
                             "render scene.ply --camera-path list.json --output a.png",
                             "film scene.ply --camera-path dnerf/transforms.json --output frames",
                             "bench scene.ply --camera-index 5",
                             "zoom scene.ply --from-camera 9",
                             "judge scene.ply images --camera-index 7",
                             "report scene.ply --camera-index 3 --output page.html",
                             "compare scene.ply --path-steps 3",
                             "bench scene.ply --path-steps 3"});
}

TEST_F(Refusals, results_never_replace_inputs_nor_each_other_nor_the_files_of_others) {
  expect_answers("results", {"convert scene.ply scene.ply --overwrite",
                             "convert scene.ply link.ply --overwrite",
                             "convert scene.ply hard.ply --overwrite",
                             "convert scene.ply empty/../scene.ply --overwrite",
                             "convert scene.ply copy.ply",
                             "convert scene.ply mine.spz",
                             "convert scene.ply images",
                             "convert scene.ply no/out.ply",
                             "lod scene.ply scene.ply --overwrite",
                             "lod scene.ply mine --original",
                             "lod scene.ply mine.rad --memory 1M",
                             "lod scene.ply no/out.rad",
                             "lod none.ply out.rad",
                             "lod scene.ply",
                             "render scene.ply --output mine.png",
                             "render scene.ply --output scene.ply --overwrite",
                             "render scene.ply --output images",
                             "render scene.ply --output a",
                             "render scene.ply --stats cameras.json --overwrite",
                             "render scene.ply --output a.png --stats ./a.png",
                             "inspect scene.ply --output why",
                             "inspect scene.ply --json hard.ply --overwrite",
                             "inspect scene.ply --json why.png --output why.png",
                             "compare scene.ply --output link.ply --overwrite",
                             "compare scene.ply copy.ply --csv copy.ply --overwrite",
                             "judge images images --json a --csv a",
                             "judge images images --csv images/view0.ppm",
                             "judge images images --out-dir notes.txt",
                             "info scene.ply --json hard.ply --overwrite",
                             "info scene.ply --json no/info.json",
                             "bench scene.ply --out-dir notes.txt",
                             "zoom scene.ply --out-dir notes.txt",
                             "eval scene.ply --images images --json link.ply --overwrite",
                             "eval scene.ply --images images --csv e.csv --json e.csv",
                             "eval scene.ply --images images --save notes.txt",
                             "eval scene.ply --images images --csv mine.csv",
                             "report scene.ply --output mine.html",
                             "report scene.ply --output page.pdf",
                             "film scene.ply --output film.avi",
                             "film scene.ply --output images",
                             "train . --out-dir images",
                             "train . --out-dir notes.txt",
                             "conformance --out-dir images",
                             "conformance --out-dir notes.txt",
                             "conformance --judge images --report mine.html"});
}

TEST_F(Refusals, options_that_exclude_or_need_each_other_are_named) {
  expect_answers("pairs", {"convert scene.ply",
                           "convert scene.ply a.ply b.ply",
                           "convert --output out.ply scene.ply",
                           "info",
                           "film scene.ply --output film.mp4",
                           "film scene.ply --output frames --loop",
                           "film scene.ply --output frames --turntable --camera-path cameras.json",
                           "film scene.ply --output frames --arc 90 --camera-path cameras.json",
                           "film scene.ply --output frames --heatmap pairs --picture depth",
                           "compare scene.ply --csv x.csv",
                           "compare scene.ply copy.ply --part auto --everywhere",
                           "judge images images --cull 3dgs,adr",
                           "judge images images --csv - --json -",
                           "bench scene.ply --load --camera-index 0",
                           "bench scene.ply --load --out-dir out",
                           "conformance",
                           "conformance --report page.html",
                           "train .",
                           "train . model",
                           "eval scene.ply",
                           "view --beside copy.ply"});
}

TEST_F(Refusals, a_folder_that_does_not_allow_writing_is_named) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::permissions("empty", fs::perms::owner_read | fs::perms::owner_exec);
  expect_answers("locked",
                 {"convert scene.ply empty/out.ply", "render scene.ply --output empty/a.png",
                  "info scene.ply --json empty/info.json",
                  "film scene.ply --seconds 0.1 --size 8x8 --output empty/frames",
                  "bench scene.ply --out-dir empty/deep/out"});
}

}  // namespace
}  // namespace qs
