// SPDX-License-Identifier: MIT
// The boxes that make an MP4 file a panorama: read back by this test, and by ffprobe.
#include "app/film/panorama_boxes.h"

#include <cstdint>
#include <fstream>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/film/film.h"
#include "app/support/run_program.h"
#include "support/error_of.h"
#include "support/temporary_folder.h"

namespace qs {
namespace {

using testing::HasSubstr;
using testing::Not;

std::uint64_t number(const std::string& bytes, std::size_t at, int length = 4) {
  std::uint64_t value = 0;
  for (int i = 0; i < length; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes.at(at + static_cast<std::size_t>(i)));
  return value;
}

std::string number_of(std::uint64_t value, int length = 4) {
  std::string text;
  for (int i = length - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i));
  return text;
}

std::string box(const std::string& type, const std::string& content) {
  return number_of(content.size() + 8) + type + content;
}

/// The content of the box at a path of types; unset without it. `skip`: bytes before the boxes in a
/// box of these types.
std::optional<std::string> content_at(std::string bytes, const std::vector<std::string>& path) {
  for (const std::string& type : path) {
    std::optional<std::string> found;
    for (std::size_t at = 0; at + 8 <= bytes.size(); at += number(bytes, at)) {
      EXPECT_GE(number(bytes, at), 8u);
      EXPECT_LE(at + number(bytes, at), bytes.size()) << type;
      if (bytes.substr(at + 4, 4) == type && !found)
        found = bytes.substr(at + 8, number(bytes, at) - 8);
    }
    if (!found) return std::nullopt;
    const std::size_t skipped = type == "stsd" ? 8 : type == "avc1" ? 78 : type == "prhd" ? 0 : 0;
    bytes = found->substr(skipped);
  }
  return bytes;
}

const std::vector<std::string> kEntry = {"moov", "trak", "mdia", "minf", "stbl", "stsd", "avc1"};

std::vector<std::string> in_entry(std::initializer_list<std::string> more) {
  std::vector<std::string> path = kEntry;
  path.insert(path.end(), more);
  return path;
}

/// A film of two chunks behind or before its moov; `wide`: its places have 64 bits.
std::string film_of(bool moov_first, bool wide, bool with_ratio) {
  const std::string data = box("mdat", "first chunk, second chunk");
  const std::string start = box("ftyp", "isom0000");
  const auto moov = [&](std::uint64_t place) {
    const int size = wide ? 8 : 4;
    const std::string chunks =
        box(wide ? "co64" : "stco",
            number_of(0) + number_of(2) + number_of(place, size) + number_of(place + 13, size));
    const std::string entry = box("avc1", std::string(78, 'v') + box("avcC", "setup") +
                                              (with_ratio ? box("pasp", "12345678") : ""));
    const std::string list = box("stsd", number_of(0) + number_of(1) + entry);
    const std::string table = box("stbl", list + chunks);
    return box("moov", box("mvhd", "head") +
                           box("trak", box("tkhd", "track") + box("mdia", box("minf", table))));
  };
  if (!moov_first) return start + data + moov(start.size() + 8);
  return start + moov(start.size() + moov(0).size() + 8) + data;
}

TEST(PanoramaBoxes, are_in_the_sample_entry_and_the_chunks_are_found_where_they_are) {
  for (const bool moov_first : {false, true}) {
    for (const bool wide : {false, true}) {
      for (const bool ratio : {false, true}) {
        for (const PanoramaFilm& kind : {PanoramaFilm{false, false}, {true, true}, {true, false}}) {
          const TemporaryFolder folder;
          const auto file = folder / "film.mp4";
          std::ofstream(file, std::ios::binary) << film_of(moov_first, wide, ratio);
          add_panorama_boxes(file, file, kind);
          const std::string bytes = test::content_of(file);
          const auto st3d = content_at(bytes, in_entry({"st3d"}));
          ASSERT_TRUE(st3d);
          EXPECT_EQ(*st3d, number_of(0) + std::string(1, kind.is_stereo ? '\1' : '\0'));
          EXPECT_EQ(content_at(bytes, in_entry({"sv3d", "svhd"})),
                    number_of(0) + std::string("quadsplat\0", 10));
          EXPECT_EQ(content_at(bytes, in_entry({"sv3d", "proj", "prhd"})), std::string(16, '\0'));
          const std::string cut = number_of(kind.is_half ? 0x40000000 : 0);
          EXPECT_EQ(content_at(bytes, in_entry({"sv3d", "proj", "equi"})),
                    number_of(0) + number_of(0) + number_of(0) + cut + cut);
          EXPECT_EQ(content_at(bytes, in_entry({"pasp"})).has_value(), ratio);
          if (ratio) {
            EXPECT_LT(bytes.find("sv3d"), bytes.find("pasp"));
          }
          const auto uuid = content_at(bytes, {"moov", "trak", "uuid"});
          EXPECT_EQ(uuid.has_value(), !kind.is_half);
          if (uuid) {
            EXPECT_EQ(number(*uuid, 0), 0xffcc8263u);
            EXPECT_THAT(*uuid, HasSubstr("<GSpherical:Spherical>true</GSpherical:Spherical>"));
            EXPECT_THAT(*uuid, HasSubstr(">equirectangular<"));
          }
          std::vector<std::string> places = {"moov", "trak", "mdia", "minf", "stbl"};
          places.push_back(wide ? "co64" : "stco");
          const auto chunks = content_at(bytes, places);
          ASSERT_TRUE(chunks);
          const int size = wide ? 8 : 4;
          EXPECT_EQ(bytes.substr(number(*chunks, 8, size), 11), "first chunk");
          EXPECT_EQ(bytes.substr(number(*chunks, 8 + static_cast<std::size_t>(size), size), 12),
                    "second chunk");
          EXPECT_EQ(content_at(bytes, {"mdat"}), "first chunk, second chunk");
        }
      }
    }
  }
}

TEST(PanoramaBoxes, are_refused_by_files_that_are_no_films) {
  const std::string good = film_of(true, false, false);
  std::string long_entry = good;
  long_entry.replace(good.find("avc1") - 4, 4, number_of(100000));
  std::string short_entry = good;
  short_entry.replace(good.find("avc1") - 4, 4, number_of(20));
  for (const std::string& bytes :
       {std::string(), std::string("moov"), box("moov", ""), box("moov", box("trak", "")),
        box("ftyp", "isom"), good.substr(0, good.size() / 2), long_entry, short_entry,
        number_of(1) + "moov", number_of(0) + "moov", number_of(0xffffffff) + "moov" + "abc",
        box("moov", box("trak", box("mdia", box("minf", box("stbl", box("stsd", "")))))),
        box("moov",
            box("trak",
                box("mdia", box("minf", box("stbl", box("stsd", "") +
                                                        box("free", std::string(999, 'x')))))))}) {
    const TemporaryFolder folder;
    const auto file = folder / "film.mp4";
    std::ofstream(file, std::ios::binary) << bytes;
    EXPECT_THAT(
        test::error_of([&] { add_panorama_boxes(file, "shown.mp4", {}); }, ErrorKind::input),
        HasSubstr("shown.mp4: cannot be tagged"));
  }
}

TEST(PanoramaFilm, is_shown_as_a_panorama_by_ffprobe) {
  if (!ffmpeg_is_installed()) GTEST_SKIP() << "ffmpeg is not installed";
  for (const PanoramaFilm& kind : {PanoramaFilm{false, false}, {true, true}, {true, false}}) {
    const TemporaryFolder folder;
    const auto file = folder / "film.mp4";
    const glm::ivec2 size(kind.is_half ? 32 : 64, kind.is_stereo ? 64 : 32);
    write_film_file(
        file, size, 10,
        [&](const AddPicture& add) {
          for (int i = 0; i < 3; ++i) add(Image(size.x, size.y, 3));
        },
        "", kind);
    const test::ProgramRun run = test::run_program(
        "ffprobe", {"-v", "error", "-show_streams", "-show_frames", file.string()});
    if (run.exit_code == 127) GTEST_SKIP() << "ffprobe is not installed";
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("side_data_type=Spherical Mapping"));
    EXPECT_THAT(run.out, HasSubstr(kind.is_half ? "projection=tiled equirectangular"
                                                : "projection=equirectangular"));
    EXPECT_THAT(run.out, HasSubstr(kind.is_stereo ? "type=top and bottom" : "type=2D"));
    const auto frames = [](const std::string& text) {
      std::size_t count = 0;
      for (std::size_t at = text.find("[FRAME]"); at != std::string::npos;
           at = text.find("[FRAME]", at + 1))
        ++count;
      return count;
    };
    EXPECT_EQ(frames(run.out), 3u) << "the chunks are found";
    EXPECT_THAT(run.err, Not(HasSubstr("error")));
  }
}

}  // namespace
}  // namespace qs
