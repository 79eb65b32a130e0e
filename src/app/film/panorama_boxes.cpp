// SPDX-License-Identifier: MIT
#include "app/film/panorama_boxes.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/mapped_file.h"
#include "io/bytes/replace_file.h"

namespace qs {
namespace {

std::string big_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>(value >> (8 * i));
  return text;
}

std::uint64_t number_at(std::string_view bytes, std::size_t at, int length) {
  if (at + static_cast<std::size_t>(length) > bytes.size()) return 0;
  std::uint64_t value = 0;
  for (int i = 0; i < length; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
  return value;
}

std::string box(std::string_view type, const std::string& content) {
  return big_endian(content.size() + 8, 4) + std::string(type) + content;
}

// A box with version and flags.
std::string full_box(std::string_view type, const std::string& content) {
  return box(type, big_endian(0, 4) + content);
}

// Part of a film's bytes.
struct Range {
  std::size_t begin = 0, end = 0;
  bool is_empty() const { return begin == end; }
};

constexpr std::size_t kHeader = 8;  // of a box

// The box of a type among the boxes in a range; empty if there is none.
Range find_box(std::string_view bytes, Range in, std::string_view type) {
  for (std::size_t at = in.begin; at + kHeader <= in.end;) {
    std::uint64_t size = number_at(bytes, at, 4);
    if (size == 1) size = number_at(bytes, at + kHeader, 8);
    if (size < kHeader || size > in.end - at) return {};
    if (bytes.substr(at + 4, 4) == type) return {at, at + size};
    at += size;
  }
  return {};
}

// A path of boxes, outermost first; empty if one is missing.
std::vector<Range> find_path(std::string_view bytes,
                             std::initializer_list<std::string_view> types) {
  std::vector<Range> path;
  Range in{0, bytes.size()};
  for (const std::string_view type : types) {
    path.push_back(find_box(bytes, in, type));
    if (path.back().is_empty()) return {};
    in = {path.back().begin + kHeader, path.back().end};
  }
  return path;
}

// Inserts bytes and enlarges the boxes around them.
void insert(std::string& bytes, const std::vector<Range>& around, std::size_t at,
            const std::string& more) {
  for (const Range& each : around)
    bytes.replace(each.begin, 4, big_endian(number_at(bytes, each.begin, 4) + more.size(), 4));
  bytes.insert(at, more);
}

std::string stereo_and_projection(const PanoramaFilm& film) {
  // Shares of the width that are cut off at the left and at the right, in units of 2^-32.
  const std::string side = big_endian(film.is_half ? 0x40000000u : 0u, 4);
  const std::string none = big_endian(0, 4);
  return full_box("st3d", big_endian(film.is_stereo ? 1 : 0, 1)) +
         box("sv3d", full_box("svhd", std::string("quadsplat") + '\0') +
                         box("proj", full_box("prhd", none + none + none) +
                                         full_box("equi", none + none + side + side)));
}

std::string first_version() {
  const std::string id = "\xff\xcc\x82\x63\xf8\x55\x4a\x93\x88\x14\x58\x7a\x02\x52\x1f\xdd";
  return box("uuid", id + "<?xml version=\"1.0\"?><rdf:SphericalVideo "
                          "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\" "
                          "xmlns:GSpherical=\"http://ns.google.com/videos/1.0/spherical/\">"
                          "<GSpherical:Spherical>true</GSpherical:Spherical>"
                          "<GSpherical:Stitched>true</GSpherical:Stitched>"
                          "<GSpherical:StitchingSoftware>quadsplat</GSpherical:StitchingSoftware>"
                          "<GSpherical:ProjectionType>equirectangular</GSpherical:ProjectionType>"
                          "</rdf:SphericalVideo>");
}

// Adds `shift` to the places of the chunks in the file.
void shift_chunks(std::string& moov, const std::vector<Range>& tables, std::uint64_t shift) {
  const Range in{tables.back().begin + kHeader, tables.back().end};
  for (const auto& [type, bytes] : {std::pair{"stco", 4}, std::pair{"co64", 8}}) {
    const Range table = find_box(moov, in, type);
    if (table.is_empty()) continue;
    for (std::size_t at = table.begin + 16; at + static_cast<std::size_t>(bytes) <= table.end;
         at += static_cast<std::size_t>(bytes))
      moov.replace(at, static_cast<std::size_t>(bytes),
                   big_endian(number_at(moov, at, bytes) + shift, bytes));
  }
}

}  // namespace

void add_panorama_boxes(const std::filesystem::path& file, const std::filesystem::path& shown,
                        const PanoramaFilm& film) {
  const MappedFile mapped(file);
  const std::string_view bytes = text_of(mapped.content());
  const Range place = find_box(bytes, {0, bytes.size()}, "moov");
  std::string moov(bytes.substr(place.begin, place.end - place.begin));
  const auto tables = [&] { return find_path(moov, {"moov", "trak", "mdia", "minf", "stbl"}); };
  std::vector<Range> around = find_path(moov, {"moov", "trak", "mdia", "minf", "stbl", "stsd"});
  constexpr std::size_t kOfList = 16,
                        kOfVideo = 86;  // bytes before the boxes in stsd, in its entry
  const Range entry =
      around.empty() ? Range{} : Range{around.back().begin + kOfList, around.back().end};
  const std::uint64_t size = number_at(moov, entry.begin, 4);
  if (entry.begin >= entry.end || size < kOfVideo || size > entry.end - entry.begin)
    fail("{}: cannot be tagged as a panorama: its boxes are not those of a film", shown.string());
  around.push_back({entry.begin, entry.begin + size});
  const Range ratio = find_box(moov, {entry.begin + kOfVideo, around.back().end}, "pasp");
  insert(moov, around, ratio.is_empty() ? around.back().end : ratio.begin,
         stereo_and_projection(film));
  if (!film.is_half) {  // the first version has no VR180
    const std::vector<Range> track = find_path(moov, {"moov", "trak"});
    insert(moov, track, track.back().end, first_version());
  }
  if (find_box(bytes, {0, bytes.size()}, "mdat").begin > place.begin)
    shift_chunks(moov, tables(), moov.size() - (place.end - place.begin));
  // Beside the file, because a file that was mapped is an input and is not written onto.
  const std::filesystem::path tagged = file.string() + ".tagged";
  write_file(tagged, [&](std::ostream& out) {
    out << bytes.substr(0, place.begin) << moov << bytes.substr(place.end);
  });
  std::filesystem::rename(tagged, file);
}

}  // namespace qs
