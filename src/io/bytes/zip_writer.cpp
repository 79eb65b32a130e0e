// SPDX-License-Identifier: MIT
//
// Source of the layout: PKWARE's APPNOTE.TXT 6.3.10, sections 4.3 to 4.5.
#include <algorithm>
#include <cstdint>
#include <ostream>
#include <string_view>

#include "io/bytes/byte_writer.h"
#include "io/bytes/inflate.h"
#include "io/bytes/replace_file.h"
#include "io/bytes/zip.h"

namespace qs {
namespace {

constexpr std::uint16_t kDate = 1 << 5 | 1;  // 1980-01-01
constexpr std::uint16_t kNameIsUtf8 = 1 << 11;
constexpr std::uint16_t kVersion = 20, kVersion64 = 45;  // the format's version that a reader needs
constexpr std::uint32_t kInExtraField = 0xffffffff;

std::string deflated_bytes(std::string_view content) {
  constexpr int kMemory = 8;
  std::string packed;
  Deflater deflater(DeflateForm::deflate, Z_BEST_COMPRESSION, kMemory,
                    [&](std::string_view bytes) { packed += bytes; });
  deflater.write(content);
  deflater.finish();
  return packed;
}

/// A size or offset of 32 bits, which is added to the 64-bit extra field if it does not fit.
std::uint32_t short_value(std::uint64_t value, std::string& extra) {
  if (value < kInExtraField) return static_cast<std::uint32_t>(value);
  put_values(extra, value);
  return kInExtraField;
}

/// The extra field with 64-bit values; empty without values.
std::string extra_field(const std::string& values) {
  std::string field;
  if (!values.empty())
    put_values(field, std::uint16_t{1}, static_cast<std::uint16_t>(values.size()));
  return field + values;
}

/// Writes an archive, file by file.
class Archive {
 public:
  explicit Archive(std::ostream& stream) : stream_(stream) {}

  void add(const ZipEntry& entry, bool deflated) {
    const std::string packed = deflated ? deflated_bytes(entry.content) : std::string();
    const std::string& stored = deflated ? packed : entry.content;
    const auto checksum = static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(entry.content.data()), entry.content.size()));
    const bool is_ascii = std::all_of(entry.name.begin(), entry.name.end(),
                                      [](char c) { return static_cast<unsigned char>(c) < 0x80; });
    const auto name_bytes = static_cast<std::uint16_t>(entry.name.size());
    // A file's own header has both sizes in 64 bits or none.
    const bool is_long = entry.content.size() >= kInExtraField || stored.size() >= kInExtraField;
    std::string common, values;  // the part that both headers have
    put_values(common, is_long || offset_ >= kInExtraField ? kVersion64 : kVersion,
               is_ascii ? std::uint16_t{0} : kNameIsUtf8,
               static_cast<std::uint16_t>(deflated ? 8 : 0), std::uint16_t{0}, kDate, checksum);
    if (is_long) {
      put_values(common, kInExtraField, kInExtraField);
      put_values(values, std::uint64_t{entry.content.size()}, std::uint64_t{stored.size()});
    } else {
      put_values(common, static_cast<std::uint32_t>(stored.size()),
                 static_cast<std::uint32_t>(entry.content.size()));
    }
    put_values(common, name_bytes);
    std::string local = "PK\3\4" + common;
    put_values(local, static_cast<std::uint16_t>(extra_field(values).size()));
    local += entry.name + extra_field(values);

    const std::uint32_t place = short_value(offset_, values);
    directory_ += "PK\1\2";
    put_values(directory_, kVersion64);
    directory_ += common;
    put_values(directory_, static_cast<std::uint16_t>(extra_field(values).size()), std::uint16_t{0},
               std::uint16_t{0}, std::uint16_t{0}, std::uint32_t{0}, place);
    directory_ += entry.name + extra_field(values);
    ++files_;
    write(local);
    write(stored);
  }

  void finish() {
    const std::uint64_t begin = offset_, bytes = directory_.size();
    write(directory_);
    std::string end, unused;
    constexpr std::uint16_t kMany = 0xffff;
    if (begin >= kInExtraField || bytes >= kInExtraField || files_ >= kMany) {
      const std::uint64_t end64 = offset_;
      end += "PK\6\6";
      put_values(end, std::uint64_t{44}, kVersion64, kVersion64, std::uint32_t{0}, std::uint32_t{0},
                 files_, files_, bytes, begin);
      end += "PK\6\7";
      put_values(end, std::uint32_t{0}, end64, std::uint32_t{1});
    }
    const auto count = static_cast<std::uint16_t>(std::min<std::uint64_t>(files_, kMany));
    end += "PK\5\6";
    put_values(end, std::uint16_t{0}, std::uint16_t{0}, count, count, short_value(bytes, unused),
               short_value(begin, unused), std::uint16_t{0});
    write(end);
  }

 private:
  void write(std::string_view bytes) {
    stream_ << bytes;
    offset_ += bytes.size();
  }

  std::ostream& stream_;
  std::uint64_t offset_ = 0, files_ = 0;
  std::string directory_;
};

}  // namespace

void write_zip(const std::filesystem::path& path, const std::vector<ZipEntry>& entries,
               bool deflated) {
  write_file(path, [&](std::ostream& stream) {
    Archive archive(stream);
    for (const ZipEntry& entry : entries) archive.add(entry, deflated);
    archive.finish();
  });
}

}  // namespace qs
