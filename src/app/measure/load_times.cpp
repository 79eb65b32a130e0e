// SPDX-License-Identifier: MIT
#include "app/measure/load_times.h"

#include <chrono>
#include <cstdio>
#include <iterator>
#include <memory>

#include <fmt/format.h>

#include "app/measure/statistics.h"
#include "base/fail.h"
#include "base/seconds.h"
#include "base/text.h"
#include "io/bytes/inflate.h"
#include "io/bytes/mapped_file.h"
#include "io/scene/reader.h"

namespace qs {
namespace {

template <class Work>
double milliseconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return milliseconds_since(start);
}

// Reads the file block by block into one small buffer, as cat does.
void copy_file(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             std::fclose);
  if (!file) fail("{}: cannot be opened", path.string());
  std::vector<char> buffer(1 << 17);
  std::setvbuf(file.get(), nullptr, _IONBF, 0);
  while (std::fread(buffer.data(), 1, buffer.size(), file.get()) > 0) {
  }
}

void inflate_file(const std::filesystem::path& path) {
  const MappedFile file(path);
  Inflater inflater(file.content(), path.string());
  std::vector<std::byte> buffer(1 << 20);
  while (inflater.read(buffer) == buffer.size()) {
  }
}

bool is_gzip_file(const std::filesystem::path& path) { return is_gzip(MappedFile(path).content()); }

}  // namespace

LoadTimes measure_loading(const std::filesystem::path& path, ThreadPool& pool, int rounds,
                          const Progress& progress) {
  constexpr double LoadTimes::*kColumns[] = {&LoadTimes::total_ms, &LoadTimes::unpack_ms,
                                             &LoadTimes::fill_ms, &LoadTimes::copy_ms,
                                             &LoadTimes::inflate_ms};
  LoadTimes times;
  std::vector<double> measured[std::size(kColumns)];
  for (int round = 0; round <= rounds; ++round) {
    Scene scene;
    times.total_ms = milliseconds([&] { scene = read_scene(path, pool); });
    times.unpack_ms = scene.unpack_ms;
    times.fill_ms = scene.fill_ms;
    times.file = path.filename().string();
    times.format = scene.format;
    times.gaussians = scene.cloud.size();
    times.file_bytes = scene.file_bytes;
    times.copy_ms = milliseconds([&] { copy_file(scene.path); });
    times.inflate_ms =
        is_gzip_file(scene.path) ? milliseconds([&] { inflate_file(scene.path); }) : 0;
    progress.update(static_cast<float>(round + 1) / static_cast<float>(rounds + 1));
    if (round == 0 && rounds > 0) continue;
    for (std::size_t i = 0; i < std::size(kColumns); ++i) measured[i].push_back(times.*kColumns[i]);
  }
  for (std::size_t i = 0; i < std::size(kColumns); ++i) times.*kColumns[i] = median(measured[i]);
  return times;
}

std::string format_load_times(const std::vector<LoadTimes>& rows) {
  std::string text =
      "| file | format | size | Gaussians | load ms | unpack ms | fill ms | copy ms | load/copy | "
      "inflate ms | load/inflate |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const LoadTimes& row : rows) {
    const bool packed = row.inflate_ms > 0;
    text += fmt::format(
        "| {} | {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.2f} | {} | {} |\n",
        markdown_text(row.file), markdown_text(row.format), bytes_text(row.file_bytes),
        grouped(row.gaussians), row.total_ms, row.unpack_ms, row.fill_ms, row.copy_ms,
        row.total_ms / row.copy_ms, packed ? fmt::format("{:.1f}", row.inflate_ms) : "-",
        packed ? fmt::format("{:.2f}", row.total_ms / row.inflate_ms) : "-");
  }
  return text;
}

}  // namespace qs
