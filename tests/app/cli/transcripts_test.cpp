// SPDX-License-Identifier: MIT
//
// The output and the files of every command, compared with transcripts in tests/golden/transcripts.
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/support/transcript.h"
#include "io/bytes/json_text.h"
#include "support/golden.h"

namespace qs {
namespace {

class Transcripts : public testing::Test {
 protected:
  void expect_golden(const std::string& name) const {
    test::expect_golden_text("transcripts/" + name + ".txt", log_.text());
  }
  void run(const std::vector<std::string>& command_lines) {
    for (const std::string& line : command_lines) log_.run(line);
  }
  void show(const std::vector<std::string>& files) {
    for (const std::string& file : files) log_.show(file);
  }

  test::Transcript log_;
};

TEST_F(Transcripts, render_draws_pictures) {
  run({"render scene.ply --output out.png", "render scene.ply --all-cameras --output all.ppm",
       "render scene.ply --camera-path cameras.json --path-steps 3 --size 20x30 --output path.ppm",
       "render scene.ply --camera-path cameras.json --stats path.json --size 8x6",
       "render scene.ply --all-cameras --shard 2/2 --output shard.ppm",
       "render alone/deep/er/folder/scene.ply --size 60x40 --output framed.png",
       "render scene.ply --camera-index 1 --background 1,0.5,0.25 --sh-degree 0 --splat-scale 1.5 "
       "--tile-size 8 --antialiased on --output styled.png",
       "render scene.ply --cull reference --output reference.pfm"});
  show({"out.png", "all_0000_view0.ppm", "all_0001_view1.ppm", "all_0002.ppm", "path_0001.ppm",
        "shard_0001_view1.ppm", "framed.png", "styled.png", "reference.pfm"});
  const auto stats = parse_json(read_text_file("path.json", 1 << 26), "test");
  EXPECT_EQ(stats["frames"].size(), 32u);
  expect_golden("render");
}

TEST_F(Transcripts, render_measures_and_compares) {
  run({"render scene.ply --camera-index 1 --cull all --psnr --repeats 1 --output modes.png",
       "render scene.ply --cull adr,quadbox --camera-index 2", "render scene.ply --repeats 2",
       "render scene.ply --psnr", "render scene.ply --stats -",
       "render scene.ply --all-cameras --cull 3dgs,exact --repeats 1 --psnr --stats stats.json",
       "render scene.ply --output gray.png --background 0.5,0.5,0.5",
       "render scene.ply --reference gray.png --output out.png --stats - ",
       "render scene.ply --reference gray.png --reference-threshold 99 --output again.png",
       "render scene.ply --reference gray.png --reference-threshold 1 --background 0.5,0.5,0.5"});
  show({"modes_3dgs.png", "stats.json", "out.difference.png"});
  expect_golden("render_measures");
}

TEST_F(Transcripts, render_draws_heat_maps) {
  for (const char* name : {"pairs", "evaluated", "false-positive", "missed"}) {
    log_.run(std::string("render scene.ply --cull dualbox --heatmap ") + name +
             " --output map.png");
    log_.show("map.png");
  }
  run({"render scene.ply --cull quadbox --heatmap missed --output map.png",
       "render scene.ply --camera-index 1 --cull 3dgs,exact --heatmap pairs --heatmap-max 70 "
       "--output maps.png"});
  show({"maps_3dgs.png", "maps_exact.png"});
  expect_golden("render_heatmaps");
}

TEST_F(Transcripts, render_writes_alpha_and_depth) {
  run({"render scene.ply --picture depth --output depth.png",
       "render scene.ply --picture alpha --output alpha.png",
       "render scene.ply --picture median-depth --output median.npy",
       "render scene.ply --picture depth --output depth.jpg",
       "render scene.ply --picture depth --depth-step 1e-6 --output depth.png",
       "render scene.ply --picture alpha --depth-step 1 --output alpha.png",
       "render scene.ply --picture depth --heatmap pairs --output depth.png"});
  show({"depth.png", "alpha.png"});
  expect_golden("render_depth");
}

TEST_F(Transcripts, render_refuses) {
  run({"render scene.ply",
       "render scene.ply --output a.png --cull 3dgs,reference --heatmap pairs",
       "render scene.ply --reference out.png --cull 3dgs,adr",
       "render scene.ply --reference out.png --all-cameras",
       "render scene.ply --output a.png --reference-threshold 0.5",
       "render scene.ply --output a.png --path-steps 3",
       "render scene.ply --output a.png --shard 1/2",
       "render scene.ply --output a.png --all-cameras --shard 1/2 --heatmap pairs",
       "render scene.ply --output a.png --all-cameras --camera-index 0",
       "render scene.ply --output a.png --camera-json {} --camera-index 0",
       "render scene.ply --output a.png --camera-path cameras.json --all-cameras",
       "render scene.ply --output a.png --camera-index 3",
       "render alone/deep/er/folder/scene.ply --output a.png --camera-index 0",
       "render alone/deep/er/folder/scene.ply --output a.png --all-cameras",
       "render scene.ply --output a.png --cull 3dgs,other",
       "render scene.ply --output a.png extra",
       "render",
       "rendr",
       "inspect scene.ply --pixel 48,0",
       "inspect scene.ply --pixel 0,32",
       "inspect scene.ply --pixel 3",
       "inspect scene.ply --pixel 1,2,3",
       "inspect scene.ply --cull 3dgs,adr",
       "inspect scene.ply --all-cameras",
       "inspect scene.ply --cull reference",
       "inspect scene.ply --gaussian 999",
       "compare scene.ply --all-cameras",
       "compare scene.ply --part 1,2,3",
       "compare scene.ply --part 40,0,9,9 --cull adr --against adr",
       "compare scene.ply --part 0,30,8,3 --cull adr --against adr",
       "compare scene.ply --against other",
       "report scene.ply --output no/page.html",
       "report scene.ply --output a.html --backend cuda",
       "bench scene.ply --scaling 2 --replicate 2x1",
       "bench scene.ply --camera-path cameras.json --camera-index 0",
       "bench scene.ply --baseline adr --cull 3dgs,exact",
       "bench scene.ply --baseline reference",
       "bench scene.ply --scaling 2 --camera-path cameras.json",
       "zoom",
       "zoom scene.ply --replay zoom",
       "zoom scene.ply scene.ply",
       "zoom scene.ply --target 1,2",
       "zoom scene.ply --target 1,2,3,4",
       "merge images",
       "eval scene.ply --images images --csv - --json -",
       "eval alone/deep/er/folder/scene.ply --images images",
       "eval scene.ply --images alone",
       "info none.ply",
       "convert scene.ply out.unknown",
       "convert scene.ply out.ply --format other",
       "view none.ply",
       "view scene.ply scene.ply",
       "view scene.ply --tile-size 8"});
  expect_golden("errors");
}

TEST_F(Transcripts, inspect_explains) {
  run({"inspect scene.ply", "inspect scene.ply --pixel 47,31",
       "inspect scene.ply --camera-index 1 --pixel 5,50 --cull 3dgs --tile-size 8 --json -",
       "inspect scene.ply --gaussian 0 --output why.png",
       "inspect scene.ply --pixel 47,31 --output none.png"});
  show({"why.png"});
  // At the borders of the picture and beyond them.
  for (const char* gaussian : {"21", "33", "40", "55", "70", "128", "140"})
    log_.run(std::string("inspect scene.ply --camera-index 1 --cull 3dgs --gaussian ") + gaussian);
  expect_golden("inspect");
}

TEST_F(Transcripts, compare_draws_and_prints) {
  run({"compare scene.ply --output sheet.png",
       "compare scene.ply --camera-index 1 --cull 3dgs,dualbox --part 4,6,20,10 --amplify 8 "
       "--against adr --output crop.png",
       "compare scene.ply --cull dualbox,reference --part 0,0,48,32 --amplify 16 --output "
       "all.png",
       "compare scene.ply --cull dualbox,reference --part 0,0,48,32 --output default.png"});
  show({"sheet.png", "crop.png", "all.png", "default.png"});
  expect_golden("compare");
  // The output has more lines on a machine with a GPU, so it is not part of the transcript.
  run({"compare scene.ply --camera-index 1 --cull quadbox --everywhere"});
  // Rounding may change a value of the picture by 1/255.
  const std::string::size_type row = log_.text().find("\nquadbox, cpu ");
  ASSERT_NE(row, std::string::npos);
  std::istringstream columns(log_.text().substr(row + std::strlen("\nquadbox, cpu ")));
  std::string psnr, largest;
  columns >> psnr >> largest;
  EXPECT_GE(std::strtod(psnr.c_str(), nullptr), 80) << psnr;
  EXPECT_THAT(largest, testing::AnyOf("0/255", "1/255"));
}

TEST_F(Transcripts, bench_writes_its_reports) {
  run({"bench scene.ply --camera-index 0 --cull quadbox --out-dir default",
       "bench scene.ply alone/deep/er/folder/scene.ply --size 24x40 --frames 2 --warmup 1 "
       "--rounds 2 --psnr --cull 3dgs,exact --out-dir two",
       "bench scene.ply --replicate 2x3 --camera-index 1,0 --frames 1 --warmup 0 --cull adr",
       "bench scene.ply --camera-path cameras.json --path-steps 2 --frames 1 --warmup 0 --cull adr",
       "bench scene.ply --camera-path cameras.json --frames 1 --warmup 0 --cull adr",
       "bench scene.ply --scaling 2 --size 30x20 --frames 1 --warmup 0 --cull adr --out-dir grid",
       "bench scene.ply --load --rounds 1",
       "bench scene.ply --camera-index 0,1 --cull 3dgs,adr,exact --baseline adr --frames 3 "
       "--warmup 0 --rounds 2 --out-dir paired",
       "bench scene.ply --camera-index 0 --cull 3dgs,adr --baseline 3dgs --frames 1 --warmup 0 "
       "--out-dir single"});
  show({"default/bench.json", "two/bench.csv", "two/bench.md", "grid/bench.json",
        "paired/ratios.csv", "paired/bench.md", "single/ratios.csv", "single/bench.json"});
  expect_golden("bench");
}

TEST_F(Transcripts, zoom_and_its_replay) {
  run({"zoom scene.ply --target 0,0,3 --steps 3 --frames 1 --warmup 0 --cull 3dgs,quadbox",
       "zoom scene.ply --from-camera 1 --steps 4 --closest 0.125 --frames 1 --warmup 0 --cull "
       "quadbox --background 0.1,0.2,0.3 --out-dir zoom",
       "zoom --replay zoom", "zoom --replay zoom --out-dir again --frames 1",
       "zoom scene.ply --cull quadbox,adr --frames 1 --warmup 0 --out-dir default"});
  show({"zoom/zoom.csv", "zoom/zoom.json", "zoom/step_0002.png", "again/zoom.csv",
        "default/step_0031.png"});
  const auto whole = parse_json(read_text_file("default/zoom.json", 1 << 26), "test");
  EXPECT_EQ(whole["steps"], 32);
  EXPECT_EQ(whole["rows"].size(), 64u);
  EXPECT_EQ(whole["closest"], 0.05);
  auto bundle = parse_own_json(read_text_file("zoom/zoom.json", 1 << 26));
  bundle["rows"][2]["pairs"] = 12345;
  std::ofstream("zoom/zoom.json") << bundle;
  run({"zoom --replay zoom"});
  expect_golden("zoom");
}

TEST_F(Transcripts, merge_joins_shards) {
  run({"bench scene.ply --frames 1 --warmup 0 --cull adr,exact --shard 1/2 --out-dir one",
       "bench scene.ply --frames 1 --warmup 0 --cull adr,exact --shard 2/2 --out-dir two",
       "merge two one --out-dir both", "merge one", "merge one one", "merge one images",
       "render scene.ply --all-cameras --stats one/stats.json --shard 1/2",
       "merge one --out-dir both"});
  show({"both/bench.md", "both/bench.csv", "both/stats.json"});
  expect_golden("merge");
}

TEST_F(Transcripts, eval_measures_quality) {
  run({"eval scene.ply --images images --cull 3dgs,quadbox --out-dir out --save saved",
       "eval scene.ply --images images --images-scale 2 --csv -",
       "eval scene.ply --images images --holdout 2 --json -",
       "eval scene.ply --images images --shard 2/2 --size 24x16"});
  show({"out/eval.csv", "saved/view_view1_photograph.png", "saved/view_view0_3dgs.png"});
  std::filesystem::remove("images/view1.ppm");
  run({"eval scene.ply --images images --json eval.json",
       "eval scene.ply --images images --size 30x30"});
  show({"eval.json"});
  expect_golden("eval");
}

TEST_F(Transcripts, scene_files_are_described_and_converted) {
  run({"info scene.ply", "info scene.ply alone/deep/er/folder/scene.ply --json -",
       "convert scene.ply small.ply --keep-largest 20 --sh-degree 0", "info small.ply",
       "convert scene.ply out.splat", "convert scene.ply any.name --format splat",
       "convert scene.ply turned.ply --axes LUB", "info turned.ply",
       "convert scene.ply part.ply --crop -1,-1,0,1,1,4", "convert scene.ply x.ply --drop-floaters",
       "convert scene.ply nothing.ply --crop 90,90,90,91,91,91",
       "convert scene.ply nothing.ply --crop 0,0,1,1,1,0",
       "convert scene.ply scene.ply --drop-floaters"});
  expect_golden("scenes");
}

TEST_F(Transcripts, report_writes_a_page) {
  run({"report scene.ply --views 2 --output page.html",
       "report scene.ply --camera-path cameras.json --path-steps 9 --size 24x16 --output out"});
  show({"page.html", "out/report.html"});
  expect_golden("report");
}

// A replacement of gnuplot copies its script, so that the page embeds the scripts.
TEST_F(Transcripts, report_embeds_its_plots) {
  log_.install_gnuplot("/bin/cp \"$1\" \"${1%.gp}.png\"; exec /bin/cp \"$1\" \"${1%.gp}.svg\"");
  run({"report scene.ply --views 1 --size 60x40 --output one.html",
       "report scene.ply --views 2 --output two.html", "merge images"});
  show({"one.html"});
  run({"bench scene.ply --camera-index 0 --frames 1 --warmup 0 --cull adr --out-dir out"});
  EXPECT_TRUE(std::filesystem::exists("out/fps.png"));
  log_.install_gnuplot("/bin/sleep 0.1\nexit 3");
  run({"bench scene.ply --camera-index 0 --frames 1 --warmup 0 --cull adr --out-dir out",
       "report scene.ply --views 1 --size 60x40 --output none.html"});
  expect_golden("report_plots");
  show({"two.html"});
  EXPECT_NE(log_.text().find("scene, 2 views, 48 x 32 pixels"), std::string::npos);
}

}  // namespace
}  // namespace qs
