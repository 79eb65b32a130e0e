// SPDX-License-Identifier: MIT
#include "app/viewer/window/letters.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include <fcntl.h>
#include <fmt/format.h>
#include <imgui_internal.h>
#include <unistd.h>

#include "app/viewer/state/camera_actions.h"
#include "base/child_process.h"
#include "base/error.h"

namespace qs {
namespace {

// Latin-1, dashes to the ellipsis, the minus sign.
constexpr ImWchar kUsual[] = {0x20, 0xff, 0x2013, 0x2026, 0x2212, 0x2212, 0};

bool is_usual(unsigned letter) {
  for (int i = 0; kUsual[i] != 0; i += 2)
    if (letter >= kUsual[i] && letter <= kUsual[i + 1]) return true;
  return letter < 0x20;
}

// Returns the output of a program; empty if it does not start.
std::string output_of(const std::vector<std::string>& words) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return "";
  const Descriptor from(ends[0]);
  Descriptor to(ends[1]);
  std::string text;
  try {
    ChildProcess child({.words = words, .inherits = {{to.get(), 1}}});
    to.reset();
    std::array<char, 4096> bytes{};
    for (ssize_t got; (got = read(from.get(), bytes.data(), bytes.size())) > 0;)
      text.append(bytes.data(), static_cast<std::size_t>(got));
    child.wait();
  } catch (const Error&) {
    return "";
  }
  return text;
}

}  // namespace

bool add_letters(Letters& letters, const std::string& text) {
  if (std::ranges::all_of(text, [](char c) { return (c & 0x80) == 0; })) return false;
  const std::size_t before = letters.size();
  const char* const end = text.data() + text.size();
  for (const char* at = text.data(); at < end;) {
    unsigned letter = 0;
    at += std::max(1, ImTextCharFromUtf8(&letter, at, end));
    const bool is_known = letter != IM_UNICODE_CODEPOINT_INVALID;
    if (is_known && !is_usual(letter) && letter <= IM_UNICODE_CODEPOINT_MAX)
      letters.insert(static_cast<ImWchar>(letter));
  }
  return letters.size() > before;
}

bool add_shown_letters(Letters& letters, const Viewer& viewer, const FileChooser& chooser) {
  bool found = false;
  const auto add = [&](const std::string& text) { found |= add_letters(letters, text); };
  if (viewer.scene) {
    add(viewer.scene->path.string());
    for (const Camera& camera : viewer.scene->cameras) add(camera.name);
  }
  for (const auto& [name, camera] : bookmarks_of(viewer)) add(name);
  if (viewer.beside) add(viewer.beside->path.string());
  if (viewer.loading) add(viewer.loading->path.string());
  for (const std::filesystem::path& path : viewer.recent) add(path.string());
  for (const LogEntry& entry : viewer.log) add(entry.text);
  add(viewer.photograph.path.string());
  add(chooser.folder().string() + chooser.typed());
  for (const FileEntry& row : chooser.rows()) add(row.name);
  return found;
}

ImVector<ImWchar> glyph_ranges(const Letters& letters) {
  ImFontGlyphRangesBuilder builder;
  builder.AddRanges(kUsual);
  for (const ImWchar letter : letters) builder.AddChar(letter);
  ImVector<ImWchar> ranges;
  builder.BuildRanges(&ranges);
  return ranges;
}

std::optional<SystemFont> system_font(const Letters& letters) {
  std::string wanted = ":charset=";
  for (const ImWchar letter : letters) wanted += fmt::format("{:x} ", letter);
  const std::string found = output_of({"fc-match", "-f", "%{index} %{file}", wanted});
  const std::size_t space = found.find(' ');
  if (space == found.npos) return std::nullopt;
  // The upper bits of an index name a variant of the font.
  return SystemFont{found.substr(space + 1), std::atoi(found.c_str()) & 0xffff};
}

}  // namespace qs
