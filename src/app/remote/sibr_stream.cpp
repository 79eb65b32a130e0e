// SPDX-License-Identifier: MIT
#include "app/remote/sibr_stream.h"

#include <algorithm>
#include <array>

#include "app/remote/tcp.h"

namespace qs {
namespace {

constexpr std::size_t kLengthBytes = 4;

// A length of at most `most`, and that many bytes.
SibrEnd read_text(const ReadBytes& read, std::size_t most, std::string& text) {
  std::array<std::byte, kLengthBytes> length{};
  if (!read(length)) return SibrEnd::ended;
  const std::size_t size = length_of(length);
  if (size > most) return SibrEnd::foreign;
  text.resize(size);
  const bool is_whole = size == 0 || read(std::as_writable_bytes(std::span(text)));
  return is_whole ? SibrEnd::done : SibrEnd::ended;
}

// A trainer whose iterations are long may speak first after the request: then its list is in front
// of the first picture.
bool read_first_picture(const ReadBytes& read, SibrDialect& dialect, std::span<std::byte> rgb) {
  if (!read(rgb.first(kLengthBytes))) return false;
  const std::size_t size = length_of(rgb.first<kLengthBytes>());
  std::size_t known = kLengthBytes;
  if (size > 1 && size <= std::min(kMostSibrText, rgb.size() - kLengthBytes)) {
    if (!read(rgb.subspan(kLengthBytes, size))) return false;
    const std::string text(reinterpret_cast<const char*>(rgb.data()) + kLengthBytes, size);
    known += size;
    if (parse_render_modes(text)) {
      dialect = SibrDialect::trainer_first;
      known = 0;
    }
  }
  return known == rgb.size() || read(rgb.subspan(known));
}

}  // namespace

std::optional<SibrRequest> read_sibr_request(const ReadBytes& read) {
  std::string json;
  if (read_text(read, kMostSibrRequest, json) != SibrEnd::done) return {};
  return parse_sibr_request(json);
}

SibrEnd read_sibr_modes(const ReadBytes& read, SibrDialect& dialect) {
  std::string text;
  if (const SibrEnd end = read_text(read, kMostSibrText, text); end != SibrEnd::done) return end;
  if (!parse_render_modes(text)) return SibrEnd::foreign;
  dialect = SibrDialect::trainer_first;
  return SibrEnd::done;
}

SibrEnd read_sibr_answer(const ReadBytes& read, std::size_t rgb_bytes, bool is_first,
                         SibrDialect& dialect, SibrAnswer& answer) {
  answer.rgb.resize(rgb_bytes);
  const bool may_be_list =
      is_first && dialect != SibrDialect::trainer_first && rgb_bytes >= kLengthBytes;
  const bool is_whole =
      rgb_bytes == 0 ||
      (may_be_list ? read_first_picture(read, dialect, answer.rgb) : read(answer.rgb));
  if (!is_whole) return SibrEnd::ended;
  SibrEnd end = read_text(read, kMostSibrText, answer.source);
  if (end == SibrEnd::done && dialect == SibrDialect::trainer_first)
    end = read_text(read, kMostSibrText, answer.metrics);
  if (end == SibrEnd::done && dialect == SibrDialect::unknown) dialect = SibrDialect::viewer_first;
  return end;
}

}  // namespace qs
