// SPDX-License-Identifier: MIT
#include "io/scene/rad/rad_pages.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <numeric>
#include <string_view>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "base/fail.h"
#include "io/bytes/file_guard.h"
#include "io/bytes/file_source.h"
#include "io/cloud/cloud_memory.h"
#include "io/cloud/fill_cloud.h"
#include "io/scene/rad/rad_original.h"

namespace qs {

bool is_rad_file(const std::filesystem::path& path) {
  std::array<char, kRadFileMagic.size()> start{};
  std::ifstream(path, std::ios::binary).read(start.data(), start.size());
  return std::string_view(start.data(), start.size()) == kRadFileMagic;
}

RadPages::RadPages(std::filesystem::path path)
    : path_(std::move(path)), file_(open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (!file_) fail("{}: cannot be opened: {}", path_.string(), std::strerror(errno));
  if (fstat(file_.get(), &opened_) != 0 || !S_ISREG(opened_.st_mode))
    fail("{}: is not a regular file", path_.string());
  note_input(path_);
  constexpr std::uint64_t kStart = 8;  // the magic word and the length of the description
  const std::uint32_t json = load<std::uint32_t>(&bytes(0, kStart)[4]);
  const Array<std::byte> start =
      bytes(0, std::min<std::uint64_t>(file_bytes(), kStart + (json + std::uint64_t{7}) / 8 * 8));
  ByteCursor cursor(start, path_.string());
  header_ = read_rad_header(cursor, path_.string());
  body_ = cursor.offset();
  if (header_.count == 0) fail("{}: holds no Gaussians", path_.string());
  Array<std::byte> content;
  const RadChunk first = chunk(0, content);
  sh_degree_ = first.sh_degree();
  codes_.emplace(first);
}

LodPage RadPages::read(std::size_t i) const {
  Array<std::byte> content;
  const RadChunk chunk = this->chunk(i, content);
  if (chunk.sh_degree() > sh_degree_)
    fail("{}: has SH of degree {}, but the first chunk of degree {}", chunk.source,
         chunk.sh_degree(), sh_degree_);
  LodPage page{make_cloud(chunk.count, sh_degree_)};
  page.cloud.antialiased = header_.antialiased;
  page.cloud.origin = header_.origin;
  std::vector<std::uint32_t> rows(chunk.count);
  std::iota(rows.begin(), rows.end(), 0u);
  LinearValues linear;
  fill_gaussians(chunk, *codes_, rows, rows, page.cloud, linear);
  const RadOriginals originals(chunk);
  originals.restore(rows, rows, page.cloud);
  page.numbers = originals.numbers();
  ThreadPool alone(1);
  if (const auto flawed = fill_drawable(page.cloud, alone, {}, [](std::size_t, std::size_t) {});
      !flawed.empty())
    fail("{}: {} of its nodes cannot be drawn", chunk.source, flawed.size());
  const bool has_own = header_.footprint > 0;
  page.nodes = rad_nodes(chunk, has_own);
  for (std::size_t row = 0; row < page.nodes.size(); ++row) {
    LodFacts& node = page.nodes[row];
    const glm::vec3& scales = page.cloud.log_scales[row];
    if (!has_own) node.radius = 2 * std::exp(std::max({scales.x, scales.y, scales.z}));
    const std::uint64_t last = node.first_child + std::uint64_t{node.child_count};
    if (node.child_count > 0 && (node.first_child <= chunk.base + row || last > header_.count))
      fail("{}: node {} has {} children from node {} on, but its tree has {} nodes", chunk.source,
           chunk.base + row, node.child_count, node.first_child, header_.count);
  }
  return page;
}

bool RadPages::is_unchanged() const {
  struct stat now = {};
  return stat(path_.c_str(), &now) == 0 && now.st_dev == opened_.st_dev &&
         now.st_ino == opened_.st_ino && now.st_size == opened_.st_size &&
         now.st_mtim.tv_sec == opened_.st_mtim.tv_sec &&
         now.st_mtim.tv_nsec == opened_.st_mtim.tv_nsec;
}

Array<std::byte> RadPages::bytes(std::uint64_t offset, std::uint64_t count) const {
  Array<std::byte> bytes(count);
  for (std::size_t done = 0; done < count;) {
    const ssize_t got =
        pread(file_.get(), bytes.data() + done, count - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("{}: cannot be read: {}", path_.string(), std::strerror(errno));
    if (got == 0) fail("{}: ends at byte {}", path_.string(), offset + done);
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

RadChunk RadPages::chunk(std::size_t i, Array<std::byte>& content) const {
  const RadHeader::Range& range = header_.chunks[i];
  if (range.file) {
    content = files_beside(path_)->read(*range.file, range.bytes);
  } else {
    header_.require_inside(i, file_bytes() - body_, path_.string());
    content = bytes(body_ + range.offset, range.bytes);
  }
  return header_.chunk(i, content, path_.string());
}

}  // namespace qs
