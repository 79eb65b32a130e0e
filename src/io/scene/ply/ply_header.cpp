// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <unordered_set>
#include <utility>

#include "base/fail.h"
#include "io/bytes/byte_text.h"
#include "io/scene/ply/ply_file.h"

namespace qs {
namespace {

// Far above any known header (40 KB of comments); bounds the search for end_header.
constexpr std::size_t kMaxHeaderBytes = 8u << 20;

// Index: PlyFormat.
constexpr std::string_view kFormatNames[] = {"ascii", "binary_little_endian", "binary_big_endian"};

// The two names of each type; index: PlyType.
constexpr std::string_view kTypeNames[][2] = {
    {"char", "int8"},     {"uchar", "uint8"},   {"short", "int16"},
    {"ushort", "uint16"}, {"int", "int32"},     {"uint", "uint32"},
    {"half", "float16"},  {"float", "float32"}, {"double", "float64"}};

std::vector<std::string_view> split(std::string_view line) {
  constexpr std::string_view kBlanks = " \t";
  std::vector<std::string_view> words;
  std::size_t begin = line.find_first_not_of(kBlanks);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

class HeaderParser {
 public:
  HeaderParser(std::string_view text, bool whole_file, const std::filesystem::path& path)
      : text_(text), whole_file_(whole_file), path_(path.string()) {}

  PlyHeader parse() {
    next_line();  // "ply"
    for (;;) {
      line_ = next_line();
      words_ = split(line_);
      if (words_.empty()) continue;
      const std::string_view keyword = words_[0];
      if (keyword == "end_header" && words_.size() == 1) break;
      if (keyword == "comment") {
        header_.comments.emplace_back(line_.substr(line_.find("comment") + 7));
      } else if (keyword == "format") {
        parse_format();
      } else if (keyword == "element") {
        parse_element();
      } else if (keyword == "property") {
        parse_property();
      } else if (keyword != "obj_info") {
        wrong("unknown keyword");
      }
    }
    if (!has_format_) fail("{}: the .ply header has no format line", path_);
    header_.body_offset = offset_;
    return std::move(header_);
  }

 private:
  std::string_view next_line() {
    const std::size_t end = text_.find('\n', offset_);
    if (end == std::string_view::npos) {
      if (!whole_file_) fail("{}: the .ply header is longer than 8 MiB", path_);
      fail("{}: the .ply header ends early: there is no end_header line", path_);
    }
    std::string_view line = text_.substr(offset_, end - offset_);
    offset_ = end + 1;
    ++line_number_;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }

  [[noreturn]] void wrong(std::string_view what) {
    fail("{}: .ply header line {}: {}: {}", path_, line_number_, what, quoted_for_message(line_));
  }

  PlyType type(std::string_view word) {
    for (std::size_t i = 0; i < std::size(kTypeNames); ++i)
      if (word == kTypeNames[i][0] || word == kTypeNames[i][1]) return static_cast<PlyType>(i);
    wrong("unknown type");
  }

  void parse_format() {
    if (has_format_) wrong("a second format line");
    has_format_ = true;
    const auto* const name = std::find(std::begin(kFormatNames), std::end(kFormatNames),
                                       words_.size() > 1 ? words_[1] : std::string_view());
    if (words_.size() != 3 || words_[2] != "1.0" || name == std::end(kFormatNames))
      wrong("unknown format");
    header_.format = static_cast<PlyFormat>(name - std::begin(kFormatNames));
  }

  void parse_element() {
    if (words_.size() != 3) wrong("an element needs a name and a count");
    PlyElement element;
    element.name = words_[1];
    const char* const end = words_[2].data() + words_[2].size();
    const auto [stop, error] = std::from_chars(words_[2].data(), end, element.count);
    if (error != std::errc() || stop != end) wrong("the count is not a whole number below 2^64");
    if (!element_names_.insert(words_[1]).second) wrong("a second element of this name");
    property_names_.clear();
    header_.elements.push_back(std::move(element));
  }

  void parse_property() {
    if (header_.elements.empty()) wrong("a property before any element");
    PlyElement& element = header_.elements.back();
    PlyProperty property;
    property.is_list = words_.size() > 1 && words_[1] == "list";
    if (words_.size() != (property.is_list ? 5u : 3u)) wrong("a property needs a type and a name");
    if (property.is_list) {
      property.length_type = type(words_[2]);
      if (property.length_type >= PlyType::f16) wrong("a list's length must be an integer");
      element.has_list = true;
    }
    property.type = type(words_[words_.size() - 2]);
    property.name = words_.back();
    property.offset = element.row_bytes;
    if (!property.is_list) element.row_bytes += size_of(property.type);
    if (!property_names_.insert(words_.back()).second) wrong("a second property of this name");
    element.properties.push_back(std::move(property));
  }

  std::string_view text_;
  bool whole_file_;  // text_ was not truncated
  std::string path_;
  std::size_t offset_ = 0;
  std::size_t line_number_ = 0;
  std::string_view line_;
  std::vector<std::string_view> words_;
  std::unordered_set<std::string_view> element_names_, property_names_;
  bool has_format_ = false;
  PlyHeader header_;
};

std::string_view beginning(ByteSpan content) { return text_of(content).substr(0, kMaxHeaderBytes); }

}  // namespace

std::string quoted_for_message(std::string_view text) { return "'" + printable(text) + "'"; }

std::string describe(PlyFormat format) {
  std::string name(kFormatNames[static_cast<std::size_t>(format)]);
  std::ranges::replace(name, '_', ' ');
  return name;
}

std::uint64_t size_of(PlyType type) {
  constexpr std::array<std::uint64_t, 9> kSizes = {1, 1, 2, 2, 4, 4, 2, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

bool is_ply(ByteSpan content) {
  const std::string_view text = beginning(content);
  return text.starts_with("ply\n") || text.starts_with("ply\r\n");
}

PlyHeader parse_ply_header(ByteSpan content, const std::filesystem::path& path) {
  if (!is_ply(content)) fail("{}: not a .ply file: its first line is not 'ply'", path.string());
  const std::string_view text = beginning(content);
  return HeaderParser(text, text.size() == content.size(), path).parse();
}

std::string_view ply_header_text(ByteSpan content) {
  const std::string_view text = beginning(content);
  return text.substr(0, text.find("end_header"));
}

}  // namespace qs
