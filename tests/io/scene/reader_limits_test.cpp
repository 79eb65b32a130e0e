// SPDX-License-Identifier: MIT
//
// Limits and messages of the building blocks of readers: a value at a limit is read, a value one
// beyond is refused with the whole sentence. Limits of .ksplat and SOG are in the tests of these
// formats.
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <zip.h>

#include "base/error.h"
#include "io/bytes/base64.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/file_source.h"
#include "io/bytes/json_text.h"
#include "io/bytes/json_value.h"
#include "io/camera/cameras.h"
#include "io/camera/colmap.h"
#include "io/picture/image_file.h"
#include "io/scene/gltf/gltf.h"
#include "io/scene/ply/ply.h"
#include "io/scene/splat/splat.h"
#include "io/scene/spz/spz.h"
#include "support/corpus.h"
#include "support/error_of.h"
#include "support/glb.h"
#include "support/gzip.h"
#include "support/scene_files.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace qs::test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

// The error's text without the folder, or "".
// ---- bytes --------------------------------------------------------------------------------------
TEST(ReaderLimits, bytes_are_taken_up_to_the_last_one) {
  const auto bytes = to_bytes("abcdef");
  ByteCursor cursor(bytes, "file");
  cursor.take(2, "two");
  EXPECT_EQ(error_of([&] { cursor.take(5, "five"); }),
            "file: cut off: five needs 5 bytes at offset 2, 4 are left");
  EXPECT_EQ(error_of([&] { cursor.take(4, "four"); }), "");
  EXPECT_EQ(cursor.left(), 0u);
}

TEST(ReaderLimits, text_files_are_read_up_to_a_size) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "12345";
  EXPECT_EQ(read_text_file(folder / "a", 5), "12345");
  EXPECT_EQ(error_of([&] { read_text_file(folder / "a", 4); }, folder.path()),
            "a: 5 bytes are more than the 4 that are read");
  EXPECT_EQ(error_of([&] { read_text_file(folder / "b", 4); }, folder.path()),
            "b: cannot be read: no such file");
}

TEST(ReaderLimits, json_is_read_up_to_a_depth_and_a_number_of_values) {
  const auto message = [](const std::string& text, std::size_t values) {
    return error_of([&] { parse_json(text, "a.json", values); });
  };
  const std::string deep(64, '['), ends(64, ']');
  EXPECT_EQ(message(deep + ends, 99), "");
  EXPECT_EQ(message("[" + deep + ends + "]", 99),
            "a.json: not valid JSON: more than 64 levels of brackets");
  EXPECT_EQ(message("[1,2,3]", 3), "");
  EXPECT_EQ(message("[1,2,3]", 2), "a.json: JSON of more than 2 values");
  EXPECT_EQ(message(R"({"a":[1,{}]})", 4), "");
  EXPECT_EQ(message(R"({"a":[1,{}]})", 3), "a.json: JSON of more than 3 values");
  EXPECT_EQ(message(R"(["\",[\\",",{"])", 2), "");
  EXPECT_EQ(message("[1,\n2,\nx]", 9), "a.json: not valid JSON: error in line 3, at byte 7");
  EXPECT_EQ(message("", 9), "a.json: not valid JSON: error in line 1, at byte 0");
  EXPECT_EQ(message("[1e999]", 9), "a.json: not valid JSON: a number is out of range");
}

TEST(ReaderLimits, fields_of_json_are_checked_with_their_names) {
  const json object = parse_json(
      R"({"one":1,"low":0.999,"most":65535,"more":65536,"half":2.5,"zero":0,"minus":-1,"tiny":1e-300,"text":"t","list":[1,2]})",
      "test");
  const std::string where = "file: record 3";
  const JsonEntry entry{object, where};
  const auto side = [&](const char* key) { return error_of([&] { entry.side(key); }); };
  EXPECT_EQ(side("one"), "");
  EXPECT_EQ(side("most"), "");
  EXPECT_EQ(side("low"),
            "file: record 3: low is 0.999, but must be a whole number from 1 to 65535");
  EXPECT_EQ(side("more"),
            "file: record 3: more is 65536, but must be a whole number from 1 to 65535");
  EXPECT_EQ(side("half"),
            "file: record 3: half is 2.5, but must be a whole number from 1 to 65535");
  EXPECT_EQ(side("text"), "file: record 3: text is not a number");
  EXPECT_EQ(side("none"), "file: record 3: none is missing");
  const auto positive = [&](const char* key) { return error_of([&] { entry.positive(key); }); };
  EXPECT_EQ(positive("tiny"), "");
  EXPECT_EQ(positive("zero"), "file: record 3: zero is 0, but must be above 0");
  EXPECT_EQ(positive("minus"), "file: record 3: minus is -1, but must be above 0");
  EXPECT_EQ(error_of([&] { entry.text("one"); }), "file: record 3: one is not a string");
  EXPECT_EQ(error_of([&] { entry.vector<3>(object["list"], "list"); }),
            "file: record 3: list is not a list of 3 numbers");
  EXPECT_EQ(entry.vector<2>(object["list"], "list"), glm::dvec2(1, 2));
  EXPECT_EQ(error_of([&] { entry.number(json(INFINITY), "far"); }),
            "file: record 3: far is not finite");
}

TEST(ReaderLimits, base64_has_whole_groups_and_at_most_two_equals_signs) {
  const auto decoded = [](const std::string& text) {
    const auto bytes = decode_data_uri("data:;base64," + text, "here");
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  };
  EXPECT_EQ(decoded("QUJD"), "ABC");
  EXPECT_EQ(decoded("QUI="), "AB");
  EXPECT_EQ(decoded("QQ=="), "A");
  EXPECT_EQ(decoded("+/+/"), "\xfb\xff\xbf");
  const auto message = [&](const std::string& text) { return error_of([&] { decoded(text); }); };
  EXPECT_EQ(message("QQ"), "here: damaged base64: 2 characters");
  EXPECT_EQ(message("QQ==="), "here: damaged base64: 5 characters");
  EXPECT_EQ(message("Q==="), "here: damaged base64");
  EXPECT_EQ(message("Q@=="), "here: damaged base64");
  const auto marked_after = [](std::size_t before) {
    return error_of(
        [&] { decode_data_uri("data:" + std::string(before - 5, 'x') + ";base64,QUJD", "here"); });
  };
  EXPECT_EQ(marked_after(256 - 8), "");
  EXPECT_EQ(marked_after(256 - 7), "here: a data URI that is not base64");
}

// Files beside a scene and in an archive, up to the announced size.
TEST(ReaderLimits, files_beside_a_scene_are_read_up_to_a_size) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a") << "12345";
  const auto files = files_beside(folder / "scene");
  EXPECT_EQ(files->read("a", 5).size(), 5u);
  EXPECT_EQ(error_of([&] { files->read("a", 4); }, folder.path()),
            "scene: the file a has 5 bytes, more than the 4 that make sense");
  EXPECT_EQ(error_of([&] { files->read("b", 4); }, folder.path()),
            "scene: the file b that it names is missing");
  EXPECT_EQ(error_of([&] { checked_file_name("a\\b\n", "s"); }),
            "s: unsafe file name 'a\\b?': only files in its own folder are read");
  EXPECT_EQ(
      error_of([&] { checked_file_name("/" + std::string(99, 'x'), "s"); }),
      "s: unsafe file name '/" + std::string(79, 'x') + "': only files in its own folder are read");
}

struct ZipFile {
  std::string name, content;
};

std::vector<std::byte> make_zip(const std::vector<ZipFile>& files, std::size_t size = 0) {
  const TemporaryFolder folder;
  const auto path = folder / "a.zip";
  const auto write = [&](const std::string& comment) {
    zip_t* const archive = zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, nullptr);
    for (const ZipFile& file : files) {
      zip_source_t* const source =
          zip_source_buffer(archive, file.content.data(), file.content.size(), 0);
      zip_file_add(archive, file.name.c_str(), source, 0);
    }
    zip_set_archive_comment(archive, comment.data(), static_cast<zip_uint16_t>(comment.size()));
    EXPECT_EQ(zip_close(archive), 0);
  };
  write("");
  if (size > 0) write(std::string(size - std::filesystem::file_size(path), 'c'));
  return file_bytes(path);
}

TEST(ReaderLimits, archives_unpack_to_16_times_their_size_and_8_mib) {
  const std::size_t size = 20000, most = 16 * size + (8u << 20);
  for (const std::size_t extra : {0u, 1u}) {
    const auto zip = make_zip({{"root", "r"}, {"a", std::string(most - 1 + extra, 'x')}}, size);
    ASSERT_EQ(zip.size(), size);
    const auto files = files_in_zip(zip, "a.zip", "root");
    EXPECT_EQ(files->read("root", 1).size(), 1u);
    EXPECT_EQ(
        error_of([&] { files->read("a", most + 9); }),
        extra == 0
            ? ""
            : "a.zip: its files have more bytes unpacked than make sense in such a small archive");
  }
  const auto zip = make_zip({{"root", "12345"}});
  const auto files = files_in_zip(zip, "a.zip", "root");
  EXPECT_EQ(error_of([&] { files->read("root", 4); }),
            "a.zip: root has 5 bytes unpacked, more than the 4 that make sense");
  EXPECT_EQ(error_of([&] { files->read("none", 4); }), "a.zip: the archive has no file none");
}

TEST(ReaderLimits, the_root_of_an_archive_may_be_one_folder_down) {
  const auto message = [](const std::vector<ZipFile>& files) {
    const auto zip = make_zip(files);
    return error_of([&] { files_in_zip(zip, "a.zip", "meta.json"); });
  };
  const auto zip = make_zip({{"x/y/meta.json", "m"}, {"x/y/b", "bb"}, {"z_meta.json", "z"}});
  const auto files = files_in_zip(zip, "a.zip", "meta.json");
  EXPECT_EQ(files->read("b", 9).size(), 2u);
  EXPECT_EQ(message({{"a/meta.json", "1"}, {"b/meta.json", "2"}}),
            "a.zip: a zip archive with 2 files meta.json");
  EXPECT_EQ(message({{"b", "2"}, {"xmeta.json", "1"}}), "a.zip: a zip archive without meta.json");
  EXPECT_EQ(message({{"meta.json", "1"}, {"b/meta.json", "2"}}), "");
}

// ---- pictures -----------------------------------------------------------------------------------
TEST(ReaderLimits, headers_of_ppm_and_pfm_are_checked) {
  const TemporaryFolder folder;
  const auto message = [&](const char* name, const std::string& content) {
    std::ofstream(folder / name, std::ios::binary) << content;
    return error_of([&] { read_image(folder / name); }, folder.path());
  };
  EXPECT_EQ(message("a.ppm", "P5 2 1 1\n\1\1"), "");
  EXPECT_EQ(message("a.ppm", std::string("P5 2 1 65535\n\0\0\1\1", 17)), "");
  EXPECT_EQ(message("a.ppm", "P5 2 1 0\n\1\1"), "a.ppm: a maximum value of 0 is not allowed");
  EXPECT_EQ(message("a.ppm", "P5 2 1 65536\n\1\1\1\1"),
            "a.ppm: a maximum value of 65536 is not allowed");
  EXPECT_EQ(message("a.ppm", "P4 2 1 255\n\1\1"),
            "a.ppm: not a binary PPM: it does not begin with P6");
  EXPECT_EQ(message("a.ppm", "P5 2 1 25x\n\1\1"),
            "a.ppm: '25x' in the picture's header is not a number");
  EXPECT_EQ(message("a.ppm", "P5 2 3 255\n12345"),
            "a.ppm: truncated: 2 x 3 pixels need 6 bytes, 5 are there");
  EXPECT_EQ(message("a.ppm", "P6 2 1 256\n12345678901"),
            "a.ppm: truncated: 2 x 1 pixels need 12 bytes, 11 are there");
  EXPECT_EQ(message("a.ppm", "P5 2 1 255"), "a.ppm: the picture's header is incomplete");
  EXPECT_EQ(message("a.ppm", "P5 #x\n#y\n2 # z 9\n1 255\n12"), "");
  EXPECT_EQ(message("a.pfm", "Pf 1 2 0\n12345678"), "a.pfm: a scale of 0 is not allowed");
  EXPECT_EQ(message("a.pfm", "Pf 1 2 -1\n12345678"), "");
  EXPECT_EQ(message("a.pfm", "PF 1 2 -1\n12345678"),
            "a.pfm: truncated: 1 x 2 pixels need 24 bytes, 8 are there");
  EXPECT_EQ(message("a.pfm", "P6 1 2 -1\n12345678"), "a.pfm: not a PFM: it does not begin with PF");
  // A maximum of 255 has one byte a value, 256 has two.
  std::ofstream(folder / "b.ppm", std::ios::binary) << "P5 2 1 255\n" << '\x33' << '\xff';
  EXPECT_EQ(read_image(folder / "b.ppm").values[0], 0.2f);
  std::ofstream(folder / "b.ppm", std::ios::binary) << "P5 1 1 256\n" << '\x00' << '\x80';
  EXPECT_EQ(read_image(folder / "b.ppm").values[0], 0.5f);
}

TEST(ReaderLimits, formats_without_transparency_say_so) {
  const TemporaryFolder folder;
  for (const char* name : {"a.ppm", "a.pfm"}) {
    for (const int channels : {2, 4}) {
      EXPECT_EQ(error_of([&] { write_image(Image(2, 2, channels), folder / name); }, folder.path()),
                std::string(name) + ": this format holds gray or RGB, not " +
                    std::to_string(channels) + " channels");
    }
  }
}

// ---- cameras ------------------------------------------------------------------------------------
json frame_of(double angle) {
  return {{"w", 64},
          {"h", 48},
          {"camera_angle_x", angle},
          {"frames",
           {{{"file_path", "a.png"},
             {"transform_matrix", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}}}}}};
}

TEST(ReaderLimits, transforms_have_angles_below_pi_and_known_lenses) {
  const TemporaryFolder folder;
  const auto message = [&](const json& file) {
    std::ofstream(folder / "transforms.json") << file;
    return error_of([&] { read_cameras(folder / "transforms.json"); }, folder.path());
  };
  const auto with = [](const char* pointer, const json& value) {
    json file = frame_of(1);
    file[json::json_pointer(pointer)] = value;
    return file;
  };
  EXPECT_EQ(message(frame_of(3.1)), "");
  EXPECT_EQ(message(frame_of(3.11)),
            "transforms.json: frame 0: camera_angle_x is 3.11, but is less than pi");
  EXPECT_EQ(message(with("/camera_angle_y", 3.2)),
            "transforms.json: frame 0: camera_angle_y is 3.2, but is less than pi");
  EXPECT_EQ(message(with("/k1", 1e-6)), "");
  for (const char* key : {"k1", "k2", "p1", "p2"}) {
    EXPECT_EQ(message(with((std::string("/") + key).c_str(), -1.1e-6)), "");
    EXPECT_TRUE(read_camera_set(folder / "transforms.json").cameras[0].lens) << key;
  }
  EXPECT_EQ(message(with("/k3", -1.1e-6)), "");
  EXPECT_EQ(message(with("/k4", -1e-6)), "");
  EXPECT_EQ(message(with("/k4", -1.1e-6)),
            "transforms.json: frame 0: k4 is -1.1e-06, which a lens OPENCV does not have; "
            "undistort the photographs first");
  EXPECT_EQ(message(with("/camera_model", "SIMPLE_PINHOLE")), "");
  EXPECT_EQ(message(with("/camera_model", "OPENCV")), "");
  EXPECT_EQ(message(with("/camera_model", "FISHEYE" + std::string(50, 'x'))),
            "transforms.json: frame 0: camera_model FISHEYE" + std::string(33, 'x') +
                " is no lens that is known; undistort the photographs first");
  const auto with_rows = [&](const json& rows) { return with("/frames/0/transform_matrix", rows); };
  EXPECT_EQ(message(with_rows({{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}})), "");
  EXPECT_EQ(message(with_rows({{1, 0, 0, 0}, {0, 1, 0, 0}})),
            "transforms.json: frame 0: transform_matrix is not a list of 3 or 4 rows");
  EXPECT_EQ(message(with_rows({{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 2, 0}})),
            "transforms.json: frame 0: transform_matrix holds no rotation (off by 3)");
  EXPECT_EQ(message(with("/frames/0", 3)), "transforms.json: frame 0: not a JSON object");
  EXPECT_EQ(message(with("/frames", 3)),
            "transforms.json: not a list of cameras, nor an object with a list of frames");
  std::filesystem::resize_file(folder / "transforms.json", (256u << 20) + 1);
  EXPECT_EQ(error_of([&] { read_cameras(folder / "transforms.json"); }, folder.path()),
            "transforms.json: 268435457 bytes are more than the 268435456 that are read");
  std::ofstream(folder / "cameras.json") << "[";
  std::filesystem::resize_file(folder / "cameras.json", (256u << 20) + 1);
  EXPECT_EQ(error_of([&] { read_cameras(folder / "cameras.json"); }, folder.path()),
            "cameras.json: 268435457 bytes are more than the 268435456 that are read");
}

TEST(ReaderLimits, colmap_s_models_have_their_parameters) {
  struct Row {
    int id;
    const char* name;
    int parameters, focal_lengths;
    bool pinhole;
  };
  const Row rows[] = {{0, "SIMPLE_PINHOLE", 3, 1, true},
                      {1, "PINHOLE", 4, 2, true},
                      {2, "SIMPLE_RADIAL", 4, 1, true},
                      {3, "RADIAL", 5, 1, true},
                      {4, "OPENCV", 8, 2, true},
                      {5, "OPENCV_FISHEYE", 8, 2, false},
                      {6, "FULL_OPENCV", 12, 2, true},
                      {7, "FOV", 5, 2, false},
                      {8, "SIMPLE_RADIAL_FISHEYE", 4, 1, false},
                      {9, "RADIAL_FISHEYE", 5, 1, false},
                      {10, "THIN_PRISM_FISHEYE", 12, 2, false},
                      {11, "RAD_TAN_THIN_PRISM_FISHEYE", 16, 2, false},
                      {12, "SIMPLE_DIVISION", 4, 1, true},
                      {13, "DIVISION", 5, 2, true},
                      {14, "SIMPLE_FISHEYE", 3, 1, false},
                      {15, "FISHEYE", 4, 2, false},
                      {16, "EUCM", 6, 2, false}};
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    const LensModel* const model = find_lens_model(row.id);
    ASSERT_NE(model, nullptr);
    EXPECT_EQ(model, find_lens_model(row.name));
    EXPECT_EQ(model->parameters(), row.parameters);
    EXPECT_EQ(model->focal_lengths, row.focal_lengths);
    std::vector<double> parameters(static_cast<std::size_t>(row.parameters), 0.0);
    for (int i = 0; i < row.focal_lengths + 2; ++i)
      parameters[static_cast<std::size_t>(i)] = 10 + i;
    const bool has_coefficients = row.parameters > row.focal_lengths + 2;
    // FOV and EUCM have no coefficients 0.
    if (row.id == 7) parameters.back() = 0.9;
    if (row.id == 16) parameters[4] = 0.6, parameters[5] = 1.1;
    const auto add = [&](std::uint64_t width, std::uint64_t height) {
      LensCamera camera;
      const std::string message = error_of([&] {
        camera = lens_camera(colmap_lens({*model, width, height, parameters}, "here"), "here");
      });
      if (message.empty()) {
        EXPECT_EQ(camera.lens.has_value(),
                  !row.pinhole || (has_coefficients && parameters.back() > 1e-6));
        const auto [focal, center] =
            camera.lens ? std::pair(camera.lens->focal_px, camera.lens->center_px)
                        : std::pair(camera.camera.focal_px, camera.camera.center_px);
        EXPECT_EQ(focal.x, 10);
        EXPECT_EQ(focal.y, 9 + row.focal_lengths);
        EXPECT_EQ(center.x, 9.5 + row.focal_lengths);
        EXPECT_EQ(center.y, 10.5 + row.focal_lengths);
      }
      return message;
    };
    if (row.pinhole) {
      EXPECT_EQ(add(65535, 1), "");
      EXPECT_EQ(add(1, 65535), "");
    }
    for (const auto& [w, h] : {std::pair{0u, 5u}, {5u, 0u}, {65536u, 5u}, {5u, 65536u}}) {
      EXPECT_EQ(add(w, h), "here: a picture of " + std::to_string(w) + " x " + std::to_string(h) +
                               " pixels is not between 1 x 1 and 65535 x 65535");
    }
    EXPECT_EQ(add(24, 24), "");
    if (has_coefficients) {
      const double last = parameters.back();
      for (const double value : {1e-6, 1.1e-6}) {
        parameters.back() = value;
        if (row.pinhole) {
          EXPECT_EQ(add(24, 24), "");
        }
      }
      parameters.back() = NAN;
      EXPECT_EQ(add(4, 4), "here: a parameter is not finite");
      parameters.back() = last;
    }
    parameters[0] = 0;
    EXPECT_EQ(add(4, 4), "here: the focal length is not above 0");
  }
  EXPECT_EQ(find_lens_model(18), nullptr);
  EXPECT_EQ(find_lens_model(-1), nullptr);
  EXPECT_EQ(find_lens_model("NONE"), nullptr);
}

// ---- scenes -------------------------------------------------------------------------------------
template <class Read>
std::string scene_error(const std::vector<std::byte>& bytes, Read read, Scene* result = nullptr) {
  return error_of([&] {
    Scene scene;
    scene.path = "a";
    ThreadPool pool(1);
    read(bytes, scene.path, pool, ReadOptions(), scene);
    if (result != nullptr) *result = std::move(scene);
  });
}

// One row of a .splat with a unit quaternion.
std::string splat_row(float position, float scale, int w) {
  std::string row(32, '\0');
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::memcpy(row.data() + 4 * axis, &position, 4);
    std::memcpy(row.data() + 12 + 4 * axis, &scale, 4);
  }
  row[27] = '\x80';
  row[28] = static_cast<char>(w);
  row[29] = row[30] = row[31] = '\x80';
  return row;
}

TEST(ReaderLimits, splat_is_recognised_by_plausible_rows) {
  const auto recognised = [](const std::string& text) {
    return recognises_splat(to_bytes(text), "");
  };
  EXPECT_TRUE(recognised(splat_row(1, 1, 255)));
  EXPECT_TRUE(recognised(splat_row(0.999e9f, 0, 255)));
  EXPECT_TRUE(recognised(splat_row(-0.999e9f, 0.999e6f, 0)));
  EXPECT_FALSE(recognised(splat_row(1e9f, 1, 255)));
  EXPECT_FALSE(recognised(splat_row(-1e9f, 1, 255)));
  EXPECT_FALSE(recognised(splat_row(1, 1e6f, 255)));
  EXPECT_FALSE(recognised(splat_row(1, -0.001f, 255)));
  EXPECT_FALSE(recognised(splat_row(NAN, 1, 255)));
  EXPECT_TRUE(recognised(splat_row(1, 1, 128 + 122)));  // 122/128 = 0.953
  EXPECT_FALSE(recognised(splat_row(1, 1, 128 + 121)));
  std::string long_rotation = splat_row(1, 1, 255);
  long_rotation[29] = static_cast<char>(128 + 43);  // a length of 1.0476
  EXPECT_TRUE(recognised(long_rotation));
  long_rotation[29] = static_cast<char>(128 + 45);  // 1.0524
  EXPECT_FALSE(recognised(long_rotation));
  EXPECT_FALSE(recognised(""));
  EXPECT_FALSE(recognised(splat_row(1, 1, 255) + "x"));
  // The first 64 rows are looked at.
  std::string rows;
  for (int i = 0; i < 64; ++i) rows += splat_row(1, 1, 255);
  EXPECT_TRUE(recognised(rows + splat_row(NAN, 1, 255)));
  EXPECT_FALSE(recognised(rows.substr(32) + splat_row(NAN, 1, 255)));
}

TEST(ReaderLimits, splat_needs_a_whole_row) {
  EXPECT_EQ(scene_error(to_bytes(std::string(31, '\0')), read_splat),
            "a: cut off: 31 bytes, one Gaussian needs 32");
  Scene scene;
  EXPECT_EQ(scene_error(to_bytes(splat_row(1, 1, 255) + "12345"), read_splat, &scene), "");
  EXPECT_THAT(scene.warnings,
              ElementsAre("The last 5 bytes are no whole row of 32 and were ignored."));
  EXPECT_EQ(scene_error(to_bytes(splat_row(1, 1, 255) + splat_row(1, 1, 128)), read_splat, &scene),
            "");
  EXPECT_THAT(scene.warnings,
              ElementsAre("1 of 2 Gaussians have no valid rotation and were left unrotated."));
  EXPECT_EQ(scene.cloud.rotations[1], glm::quat(1, 0, 0, 0));
}

// Scenes with one odd Gaussian among good Gaussians.
TEST(ReaderLimits, gaussians_are_kept_up_to_the_largest_sensible_values) {
  const auto read = [](const std::function<void(GaussianCloud&)>& change) -> std::string {
    GaussianCloud cloud = random_cloud(20, 1, 3);
    for (glm::quat& q : cloud.rotations) q = glm::quat(1, 0, 0, 0);
    const GaussianCloud good = cloud;
    change(cloud);
    const TemporaryFolder folder;
    write_scene(cloud, folder / "a.ply");
    const Scene scene = read_scene(folder / "a.ply");
    if (scene.warnings.empty()) {
      EXPECT_EQ(scene.cloud.size(), 20u);
      return "";
    }
    EXPECT_EQ(scene.cloud.size(), 19u);
    for (std::size_t i = 0; i < 19; ++i) {
      const std::size_t from = i < 4 ? i : i + 1;
      EXPECT_EQ(scene.cloud.positions[i], good.positions[from]);
      EXPECT_EQ(scene.cloud.log_scales[i], good.log_scales[from]);
      EXPECT_EQ(scene.cloud.opacity_logits[i], good.opacity_logits[from]);
      for (std::size_t k = 0; k < 4; ++k)
        EXPECT_EQ(scene.cloud.sh[4 * i + k], good.sh[4 * from + k]);
    }
    EXPECT_THAT(scene.warnings, testing::SizeIs(1));
    return scene.warnings[0];
  };
  const auto dropped = [](const char* reason) {
    return std::string("1 of 20 Gaussians were dropped for ") + reason + ".";
  };
  const std::string position = dropped("a position that is NaN, infinite or beyond 1e19");
  const std::string scale = dropped("a scale that is NaN, infinite or beyond e^40");
  const std::string rotation = dropped("a rotation that is zero, NaN or infinite");
  const std::string color = dropped("a colour that is NaN, infinite or beyond 1e6");
  const float above = std::nextafter(1e19f, INFINITY);
  EXPECT_EQ(read([](auto& c) { c.positions[4] = {1e19f, -1e19f, 1e19f}; }), "");
  for (const float value : {above, -above, NAN, INFINITY}) {
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(read([&](auto& c) { c.positions[4][axis] = value; }), position);
  }
  EXPECT_EQ(read([](auto& c) { c.log_scales[4] = {40, -INFINITY, -99}; }), "");
  for (const float value : {std::nextafter(40.0f, 99.0f), NAN, INFINITY}) {
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(read([&](auto& c) { c.log_scales[4][axis] = value; }), scale);
  }
  EXPECT_EQ(read([](auto& c) { c.rotations[4] = {0, 0, 0, 0}; }), rotation);
  EXPECT_EQ(read([](auto& c) { c.rotations[4].y = NAN; }), rotation);
  EXPECT_EQ(read([](auto& c) { c.opacity_logits[4] = NAN; }), dropped("an opacity that is NaN"));
  EXPECT_EQ(read([](auto& c) { c.opacity_logits[4] = INFINITY; }), "");
  EXPECT_EQ(read([](auto& c) { c.sh[19] = {1e6f, -1e6f, 0}; }), "");
  for (const std::size_t k : {16u, 19u}) {
    for (const float value : {std::nextafter(1e6f, 2e6f), -1.1e6f, NAN, INFINITY})
      EXPECT_EQ(read([&](auto& c) { c.sh[k].z = value; }), color);
  }
}

TEST(ReaderLimits, scenes_that_show_nothing_or_too_much_are_told) {
  const auto read = [](std::size_t count, float log_scale, float last_scale, float logit,
                       float last_logit) {
    GaussianCloud cloud = random_cloud(count, 0, 3);
    for (glm::vec3& s : cloud.log_scales) s = glm::vec3(log_scale);
    for (float& o : cloud.opacity_logits) o = logit;
    cloud.log_scales.back().z = last_scale;
    cloud.opacity_logits.back() = last_logit;
    const TemporaryFolder folder;
    write_scene(cloud, folder / "a.ply");
    return read_scene(folder / "a.ply").warnings;
  };
  const std::string activated =
      "The scales look already activated: all logarithms are positive, so that every Gaussian is "
      "larger than one unit; drawing may be slow.";
  EXPECT_THAT(read(64, 0.1f, 0.1f, 0, 0), ElementsAre(activated));
  EXPECT_THAT(read(63, 0.1f, 0.1f, 0, 0), IsEmpty());
  EXPECT_THAT(read(64, 0.1f, 0, 0, 0), IsEmpty());
  EXPECT_THAT(read(5, -1, -1, -5.54f, -5.54f),
              ElementsAre("Nothing will be visible: every Gaussian is fainter than 1/255."));
  EXPECT_THAT(read(5, -1, -1, -5.54f, -5.53f), IsEmpty());
  const TemporaryFolder folder;
  GaussianCloud cloud = random_cloud(3, 0, 1);
  cloud.positions = {{NAN, 0, 0}, {0, NAN, 0}, {0, 0, NAN}};
  write_scene(cloud, folder / "a.ply");
  EXPECT_EQ(
      error_of([&] { read_scene(folder / "a.ply"); }, folder.path()),
      "a.ply: every one of its 3 Gaussians has a position that is NaN, infinite or beyond 1e19");
  cloud.positions[0] = {0, 0, 0};
  cloud.opacity_logits[0] = NAN;
  write_scene(cloud, folder / "a.ply");
  EXPECT_EQ(error_of([&] { read_scene(folder / "a.ply"); }, folder.path()),
            "a.ply: none of its 3 Gaussians can be drawn: all have NaN, infinite or absurd values");
}

TEST(ReaderLimits, logarithms_of_glb_are_told_by_most_scales_being_negative) {
  // More than six of the twelve scales of four Gaussians must be negative.
  const TemporaryFolder folder;
  write_scene(random_cloud(4, 0, 3), folder / "a.glb");
  Glb glb = open_glb(file_bytes(folder / "a.glb"));
  const std::size_t at = 4 * (12 + 16);  // after positions and rotations
  const auto read = [&](int negative) {
    for (int i = 0; i < 12; ++i) {
      const float value = i >= 12 - negative ? -0.5f : 0.5f;  // from the last value on
      std::memcpy(glb.binary.data() + at + 4 * static_cast<std::size_t>(i), &value, 4);
    }
    Scene scene;
    EXPECT_EQ(scene_error(make_glb(glb), read_gltf, &scene), "");
    return scene;
  };
  const Scene linear = read(6), logarithms = read(7);
  EXPECT_THAT(linear.warnings,
              ElementsAre("2 Gaussians have a negative scale, which was taken for 0."));
  EXPECT_THAT(logarithms.warnings, ElementsAre(testing::StartsWith("Scales are logarithms")));
  EXPECT_EQ(logarithms.cloud.log_scales[0], glm::vec3(0.5f));
  EXPECT_NEAR(linear.cloud.log_scales[0].x, std::log(0.5), 1e-6);
}

TEST(ReaderLimits, spz_has_24_bits_and_four_degrees) {
  const auto header = [](std::uint32_t version, std::uint32_t count, int degree, int bits,
                         int flags) {
    std::string text = "NGSP";
    text.append(reinterpret_cast<const char*>(&version), 4);
    text.append(reinterpret_cast<const char*>(&count), 4);
    for (const int value : {degree, bits, flags, 0}) text += static_cast<char>(value);
    return text;
  };
  const auto message = [&](const std::string& head, std::size_t body) {
    return scene_error(to_bytes(gzip(head + std::string(body, '\x7f'), 9)), read_spz);
  };
  const std::size_t row = 9 + 1 + 3 + 3 + 4;
  EXPECT_EQ(message(header(3, 1, 0, 24, 0), row), "");
  EXPECT_EQ(message(header(3, 1, 0, 25, 0), row), "a: 25 fractional bits in 24-bit positions");
  EXPECT_EQ(message(header(2, 1, 0, 12, 0), row - 1), "");
  EXPECT_EQ(
      message(header(1, 1, 0, 99, 0), row - 4),  // version 1 has none; its halves are NaN here
      "a: every one of its 1 Gaussians has a position that is NaN, infinite or beyond 1e19");
  EXPECT_EQ(message(header(0, 1, 0, 12, 0), row), "a: .spz version 0 in gzip, 1 to 3 exist");
  EXPECT_EQ(message(header(4, 1, 0, 12, 0), row), "a: .spz version 4 in gzip, 1 to 3 exist");
  EXPECT_EQ(message(header(3, 1, 4, 12, 0), row + 72), "");
  EXPECT_EQ(message(header(3, 1, 5, 12, 0), row + 105), "a: SH degree 5 does not exist");
  EXPECT_EQ(message(header(3, 0, 0, 12, 0), row), "a: holds no Gaussians");
  EXPECT_EQ(message(header(3, 1, 0, 12, 0x80), row),
            "a: cut off: too few bytes for its 1 Gaussians");
  EXPECT_EQ(message(header(3, 1, 0, 12, 0x80), row + 6),
            "a: node 0 has 32639 children from node 2139062143 on, but its tree has 1 nodes");
  EXPECT_EQ(message(header(3, 2, 0, 12, 0), row), "a: cut off: too few bytes for its 2 Gaussians");
  EXPECT_EQ(message(header(3, 1, 0, 12, 0), row + 1),
            "a: holds more data than its 1 Gaussians need");
  // Extensions follow the blocks: at most 65,536 bytes.
  EXPECT_EQ(message(header(3, 1, 0, 12, 2), row + 65536), "");
  EXPECT_EQ(message(header(3, 1, 0, 12, 2), row + 65537),
            "a: holds more data than its 1 Gaussians need");
  const auto file = gzip(header(3, 1, 0, 12, 0) + std::string(row, '\x7f'), 9);
  Scene scene;
  EXPECT_EQ(scene_error(to_bytes(file + "abc"), read_spz, &scene), "");
  EXPECT_THAT(scene.warnings, ElementsAre("3 bytes after the gzip data were ignored."));
}

TEST(ReaderLimits, ply_headers_have_at_most_8_mib) {
  const auto header = [](std::size_t comment) {
    return "ply\nformat ascii 1.0\ncomment " + std::string(comment, 'c') +
           "\nelement vertex 1\nproperty float x\nend_header\n1\n";
  };
  const std::size_t rest = header(0).size() - 2;
  EXPECT_EQ(scene_error(to_bytes(header((8u << 20) - rest)), read_ply),
            "a: a point cloud, not a splat file: its vertices have no f_dc, opacity, scale and rot "
            "properties");
  EXPECT_EQ(scene_error(to_bytes(header((8u << 20) - rest + 1)), read_ply),
            "a: the .ply header is longer than 8 MiB");
}

}  // namespace
}  // namespace qs::test
