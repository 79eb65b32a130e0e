// SPDX-License-Identifier: MIT
#include "app/support/transcript.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <sstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/cli/command.h"
#include "app/support/run_program.h"
#include "base/environment.h"
#include "base/error.h"
#include "io/bytes/base64.h"
#include "io/camera/cameras.h"
#include "io/picture/image_file.h"
#include "support/scene_files.h"
#include "support/scenes.h"

namespace qs::test {
namespace {

/// Sends a stream of this process to a file while it lives.
class Redirected {
 public:
  Redirected(std::FILE* stream, const char* file) : stream_(stream), kept_(dup(fileno(stream))) {
    std::fflush(stream_);
    const int target = open(file, O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(target, fileno(stream_));
    close(target);
  }
  ~Redirected() {
    std::fflush(stream_);
    dup2(kept_, fileno(stream_));
    close(kept_);
  }
  Redirected(const Redirected&) = delete;
  Redirected& operator=(const Redirected&) = delete;

 private:
  std::FILE* stream_;
  int kept_;
};

/// True if a column or a JSON value of this name differs between runs or machines.
bool varies(const std::string& name) {
  static const std::set<std::string> kNames = {
      "ms",           "FPS",         "ratio",   "drift",     "round_spread",
      "fps_median",   "utc",         "cpu",     "commit",    "threads",
      "build_type",   "sanitizers",  "version", "load/copy", "hardware_threads",
      "cuda_toolkit", "load/inflate"};
  static const std::set<std::string> kStages = {"preprocess", "bin", "sort", "blend"};
  return kNames.count(name) + kStages.count(name) != 0 || name.starts_with("ms_") ||
         name.starts_with("vs ") || name.starts_with("ratio_") || name.starts_with("`") ||
         name.ends_with("_ms") || name.ends_with(" ms");
}

std::vector<std::string> split(const std::string& line, char separator) {
  std::istringstream in(line);
  std::vector<std::string> cells;
  for (std::string cell; std::getline(in, cell, separator);) cells.push_back(cell);
  return cells;
}

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \""), end = text.find_last_not_of(" \"");
  return begin == text.npos ? "" : text.substr(begin, end - begin + 1);
}

/// Masks the cells of a line whose column varies; other cells stay as they are.
std::string masked_cells(const std::string& line, const std::vector<std::string>& head,
                         char separator) {
  std::vector<std::string> cells = split(line, separator);
  for (std::size_t i = 0; i < std::min(cells.size(), head.size()); ++i) {
    if (varies(trimmed(head[i])) && trimmed(cells[i]) != "-" && !trimmed(cells[i]).empty())
      cells[i] = separator == '|' ? " # " : "#";
  }
  std::string text;
  for (const std::string& cell : cells) text += cell + separator;
  if (line.back() != separator) text.pop_back();
  return text;
}

/// Masks the columns ms, FPS and vs 3dgs of the table that render prints.
std::string masked_mode_row(std::string line) {
  for (std::size_t at = 0; (at = line.find("\u00b1", at)) != line.npos;) line.replace(at, 2, "+");
  for (const auto& [begin, end] : {std::pair{15u, 33u}, {35u, 42u}, {73u, 91u}}) {
    if (line.substr(begin, end - begin).find('-') != line.npos) continue;
    line.replace(begin, end - begin, std::string(end - begin - 1, ' ') + "#");
  }
  return line;
}

/// Masks the last two cells of a row of the page that report writes: ms per frame, 3dgs = 1.
std::string masked_html_row(std::string line) {
  std::size_t end = line.size();
  for (int i = 0; i < 2; ++i) {
    const std::size_t begin = line.rfind("<td>", end - 1);
    if (begin == line.npos) return line;
    line.replace(begin + 4, line.find("</td>", begin) - begin - 4, "#");
    end = begin;
  }
  return line;
}

std::string masked_lines(const std::string& text) {
  std::istringstream in(text);
  std::string result;
  std::vector<std::string> head;  // of the table that the line belongs to
  char separator = 0;             // of its cells; 0: the line is in no such table
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("quadsplat: warning: ") && line.find(" noisy") != line.npos) continue;
    const std::size_t key = line.find("\": ");
    if (line.starts_with("mode ") && line.find("vs 3dgs") != line.npos) {
      separator = ' ';
    } else if (line.find("<th>ms per frame</th>") != line.npos) {
      separator = '<';
    } else if (separator == '<' && line.starts_with("<tr>")) {
      line = masked_html_row(line);
    } else if (line.starts_with("scene,camera,")) {
      head = split(line, separator = ',');
    } else if (line.starts_with("|") && separator != '|') {
      head = split(line, separator = '|');
    } else if (line.starts_with("|---")) {
    } else if (separator == ' ' && line.size() > 92) {
      line = masked_mode_row(line);
    } else if (separator == '|' && line.starts_with("|")) {
      line = masked_cells(line, head, '|');
    } else if (separator == ',' && line.find(',') != line.npos) {
      line = masked_cells(line, head, ',');
    } else if (key != line.npos && !line.ends_with("{") && !line.ends_with("null,") &&
               !line.ends_with("null") && varies(trimmed(line.substr(0, key)))) {
      const std::string name = line.substr(0, key + 3);
      if (line.ends_with("[")) {
        while (std::getline(in, line) && line.find(']') == line.npos) {
        }
      }
      line = name + "#" + (line.ends_with(",") ? "," : "");
      separator = 0;
    } else {
      separator = 0;
    }
    result += line + "\n";
  }
  return result;
}

void replace_all(std::string& text, const std::string& what, const std::string& with) {
  if (what.empty()) return;
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += with.size())
    text.replace(at, what.size(), with);
}

/// Masks every text between `before` and `after`.
void mask_between(std::string& text, const std::string& before, const std::string& after) {
  for (std::size_t at = 0; (at = text.find(before, at)) != text.npos;) {
    at += before.size();
    const std::size_t end = text.find(after, at);
    if (end == text.npos) return;
    text.replace(at, end - at, "#");
  }
}

/// The texts in a PNG file, without the program's version.
std::string metadata_of(const std::string& png) {
  std::string text;
  for (std::size_t at = 8; at + 12 <= png.size();) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i)
      length = length << 8 | static_cast<unsigned char>(png[at + i]);
    std::string words = png.substr(at + 8, length);
    if (png.compare(at + 4, 4, "tEXt") == 0 && !words.starts_with("Software")) {
      replace_all(words, std::string(1, '\0'), ": ");
      text += "  " + words + "\n";
    }
    at += 12 + length;
  }
  return text;
}

/// Size, mean colour and centre of brightness of a picture. Gray counts as three equal channels.
std::string facts_of(const Image& image) {
  double sums[3] = {}, x_sum = 0, y_sum = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const auto value = static_cast<double>(image.at(x, y, std::min(c, image.channels - 1)));
        sums[c] += value;
        x_sum += value * x;
        y_sum += value * y;
      }
    }
  }
  const double all = std::max(sums[0] + sums[1] + sums[2], 1e-9);
  const double pixels = static_cast<double>(image.width) * image.height;
  return fmt::format("{} x {}, mean {:.5f} {:.5f} {:.5f}, centre {:.3f}, {:.3f}\n", image.width,
                     image.height, sums[0] / pixels, sums[1] / pixels, sums[2] / pixels,
                     x_sum / all, y_sum / all);
}

/// The facts of the pictures in an HTML page, or the text of an embedded script of the gnuplot
/// below.
std::string pictures_in(const std::string& html) {
  constexpr std::string_view kStart = "src=\"data:";
  std::string text;
  for (std::size_t at = 0; (at = html.find(kStart, at)) != html.npos;) {
    at += kStart.size() - 5;
    const std::size_t length = html.find('"', at) - at;
    const auto bytes = decode_data_uri(std::string_view(html).substr(at, length), "page");
    const std::string content(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::ofstream("embedded.png", std::ios::binary) << content;
    text += content.starts_with("set ") ? content + "\n" : facts_of(read_image("embedded.png"));
  }
  return text;
}

void write_inputs() {
  GaussianCloud cloud = random_cloud(150, 1, 11);
  cloud.positions[0] = {0, 0, 3};  // an opaque Gaussian in the middle of the picture
  cloud.log_scales[0] = {-1.0f, -2.0f, -1.5f};
  cloud.opacity_logits[0] = 8;
  write_scene(cloud, "scene.ply");
  std::filesystem::create_directories("alone/deep/er/folder");
  std::filesystem::copy("scene.ply", "alone/deep/er/folder");
  std::filesystem::create_directories("images");
  std::vector<Camera> cameras;
  constexpr glm::ivec2 kSizes[] = {{48, 32}, {40, 56}, {64, 20}};
  for (int i = 0; i < 3; ++i) {
    Camera camera = front_camera(kSizes[i].x, kSizes[i].y);
    camera.view_from_world[3].x = 0.1 * i;
    if (i < 2) camera.name = fmt::format("view{}", i);
    cameras.push_back(camera);
    if (camera.name.empty()) continue;
    Image photograph(camera.width, camera.height, 3);
    for (std::size_t k = 0; k < photograph.values.size(); ++k)
      photograph.values[k] = static_cast<float>(k * 7 % 101) / 100;
    write_image(photograph, "images/" + camera.name + ".ppm");
  }
  write_cameras(cameras, "cameras.json");
}

}  // namespace

Transcript::Transcript()
    : before_(std::filesystem::current_path()), path_variable_(std::getenv("PATH")) {
  std::filesystem::current_path(folder_.path());
  setenv("PATH", "", 1);
  write_inputs();
}

Transcript::~Transcript() {
  setenv("PATH", path_variable_.c_str(), 1);
  std::filesystem::current_path(before_);
}

void Transcript::install_gnuplot(const std::string& commands) {
  std::ofstream("gnuplot") << "#!/bin/sh\n" << commands << "\n";
  std::filesystem::permissions("gnuplot", std::filesystem::perms::owner_all);
  setenv("PATH", folder_.path().c_str(), 1);
}

void Transcript::run(const std::string& command_line, Errors errors) {
  std::vector<std::string> words = split(command_line, ' ');
  std::replace(words.begin(), words.end(), std::string("''"), std::string());
  static const std::set<std::string> kRender = {"render", "inspect", "compare", "bench",
                                                "zoom",   "eval",    "film",    "judge"};
  const bool lacks_value = words.back().starts_with("--");  // a word behind it would be its value
  if (kRender.count(words.front()) != 0)
    words.insert(lacks_value ? words.begin() + 1 : words.end(), {"--backend", "cpu"});
  int code = 0;
  std::string sentence;
  {
    const Redirected out(stdout, "stdout.txt");
    std::ofstream("stderr.txt").close();
    std::optional<Redirected> err;
    if (errors == Errors::kept) err.emplace(stderr, "stderr.txt");
    try {
      code = qs::run_program(words);
    } catch (const Error& error) {
      code = static_cast<int>(error.kind());
      sentence = fmt::format("quadsplat: {}\n", error.what());
    }
  }
  std::istringstream complaints(masked(content_of("stderr.txt") + sentence));
  text_ += "$ quadsplat " + command_line + "\n" + masked(content_of("stdout.txt"));
  for (std::string line; std::getline(complaints, line);) text_ += "! " + line + "\n";
  if (code != 0) text_ += fmt::format("exit code {}\n", code);
  text_ += "\n";
}

void Transcript::show(const std::string& file) {
  text_ += "> " + file + "\n";
  const std::string content = content_of(file);
  const bool picture = file.ends_with(".png") || file.ends_with(".ppm") || file.ends_with(".pfm");
  text_ += picture
               ? facts_of(read_image(file)) + (file.ends_with(".png") ? metadata_of(content) : "")
               : masked(content);
  if (file.ends_with(".html")) text_ += pictures_in(content);
  text_ += "\n";
}

std::string Transcript::masked(std::string text) const {
  const Environment environment = read_environment();
  replace_all(text, folder_.path().string(), "FOLDER");
  mask_between(text, environment.cpu + ", ", ", backend");  // the threads
  replace_all(text, environment.cpu + ", #, backend", "CPU, backend");
  replace_all(text, ") on " + environment.cpu, ") on CPU");
  replace_all(text, "commit " + environment.commit, "commit COMMIT");
  mask_between(text, "COMMIT, ", ". Times");
  mask_between(text, "COMMIT) on CPU, ", ". Scene");
  mask_between(text, "quadsplat ", " (commit");
  mask_between(text, "data:image/png;base64,", "\"");
  mask_between(text, "data:image/svg+xml;base64,", "\"");
  mask_between(text, ".html (", ")");
  if (const std::size_t noise = text.find("\n## Noisy rows"); noise != text.npos)
    text.resize(noise);
  return masked_lines(text);
}

}  // namespace qs::test
