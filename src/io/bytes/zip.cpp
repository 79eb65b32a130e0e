// SPDX-License-Identifier: MIT
#include "io/bytes/zip.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <ostream>
#include <string_view>
#include <utility>

#include <zlib.h>

#include "base/fail.h"
#include "io/bytes/byte_cursor.h"
#include "io/bytes/byte_text.h"
#include "io/bytes/inflate.h"
#include "io/bytes/replace_file.h"

namespace qs {

namespace {

// Sizes of the fixed parts, and signatures.
constexpr std::uint64_t kLocal = 30, kCentral = 46, kEnd = 22, kLocator64 = 20, kEnd64 = 56;
constexpr std::uint32_t kLocalSign = 0x04034b50, kCentralSign = 0x02014b50, kEndSign = 0x06054b50,
                        kLocator64Sign = 0x07064b50, kEnd64Sign = 0x06064b50;
constexpr std::uint64_t kMaxEntries = 65536;
constexpr std::uint32_t kIn64Bits = 0xffffffff;  // the value is in the 64-bit extra field
constexpr std::uint16_t kEncrypted = 1, kSizesFollow = 8;
constexpr std::uint16_t kStored = 0, kDeflated = 8;

class Directory {
 public:
  Directory(ByteSpan archive, const std::string& path) : archive_(archive), path_(path) {}

  std::vector<ZippedFile> read() {
    find();
    std::vector<ZippedFile> files;
    files.reserve(entries_);
    std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
    std::uint64_t at = begin_;
    for (std::uint64_t i = 0; i < entries_; ++i)
      at += read_entry(at, files.emplace_back(), ranges.emplace_back());
    require(at == end_, "its directory has another size than its files need");
    std::ranges::sort(ranges);
    for (std::size_t i = 1; i < ranges.size(); ++i)
      require(ranges[i - 1].second <= ranges[i].first, "files overlap");
    return files;
  }

 private:
  void require(bool sound, const char* problem) const {
    if (!sound) fail("{}: not a sound zip archive ({})", path_, problem);
  }
  template <class T>
  T at(std::uint64_t offset) const {
    return load<T>(archive_.data() + offset);
  }
  std::string_view text(std::uint64_t offset, std::uint64_t bytes) const {
    return {reinterpret_cast<const char*>(archive_.data()) + offset, bytes};
  }

  // The end record is followed by a comment of up to 64 KiB and nothing else.
  void find() {
    constexpr std::uint64_t kLongestComment = 65535;
    const std::uint64_t size = archive_.size();
    require(size >= kEnd, "cut off");
    std::uint64_t comment = 0;
    const std::uint64_t most = std::min(kLongestComment, size - kEnd);
    while (comment <= most && !(at<std::uint32_t>(size - kEnd - comment) == kEndSign &&
                                at<std::uint16_t>(size - comment - 2) == comment))
      ++comment;
    require(comment <= most, "no end of its directory");
    const std::uint64_t end = size - kEnd - comment;
    entries_ = at<std::uint16_t>(end + 10);
    std::uint64_t bytes = at<std::uint32_t>(end + 12);
    begin_ = at<std::uint32_t>(end + 16);
    end_ = end;
    if (end >= kLocator64 && at<std::uint32_t>(end - kLocator64) == kLocator64Sign) {
      end_ = at<std::uint64_t>(end - kLocator64 + 8);
      require(end >= kLocator64 + kEnd64 && end_ <= end - kLocator64 - kEnd64 &&
                  at<std::uint32_t>(end_) == kEnd64Sign,
              "no 64-bit end of its directory");
      entries_ = at<std::uint64_t>(end_ + 32);
      bytes = at<std::uint64_t>(end_ + 40);
      begin_ = at<std::uint64_t>(end_ + 48);
    }
    require(begin_ <= end_ && bytes <= end_ - begin_, "its directory is outside of the file");
    end_ = begin_ + bytes;
    if (entries_ > kMaxEntries) fail("{}: an archive of {} files", path_, entries_);
    require(fits(entries_, kCentral, bytes), "its directory is too small for its files");
  }

  // The values of the 64-bit extra field, in their order, for values that say kIn64Bits.
  class Extra64 {
   public:
    Extra64(const Directory& directory, std::uint64_t from, std::uint64_t to)
        : directory_(directory) {
      while (to - from >= 4) {
        const std::uint64_t bytes = directory.at<std::uint16_t>(from + 2);
        if (bytes > to - from - 4) break;
        if (directory.at<std::uint16_t>(from) == 1) {
          next_ = from + 4;
          left_ = bytes;
          break;
        }
        from += 4 + bytes;
      }
    }
    std::uint64_t value(std::uint32_t in_32_bits) {
      if (in_32_bits != kIn64Bits) return in_32_bits;
      directory_.require(left_ >= 8, "a 64-bit size is missing");
      left_ -= 8;
      next_ += 8;
      return directory_.at<std::uint64_t>(next_ - 8);
    }

   private:
    const Directory& directory_;
    std::uint64_t next_ = 0, left_ = 0;
  };

  // Returns the bytes of the directory's entry. `range`: of the file in the archive, with its
  // header.
  std::uint64_t read_entry(std::uint64_t entry, ZippedFile& file,
                           std::pair<std::uint64_t, std::uint64_t>& range) const {
    require(end_ - entry >= kCentral && at<std::uint32_t>(entry) == kCentralSign,
            "its directory is damaged");
    const std::uint64_t name_bytes = at<std::uint16_t>(entry + 28);
    const std::uint64_t extra_bytes = at<std::uint16_t>(entry + 30);
    const std::uint64_t whole = kCentral + name_bytes + extra_bytes + at<std::uint16_t>(entry + 32);
    require(end_ - entry >= whole, "its directory is cut off");
    const auto flags = at<std::uint16_t>(entry + 8);
    const std::uint64_t extra = entry + kCentral + name_bytes;
    Extra64 extra64(*this, extra, extra + extra_bytes);
    file.name = text(entry + kCentral, name_bytes);
    file.encrypted = (flags & kEncrypted) != 0;
    file.method = at<std::uint16_t>(entry + 10);
    file.checksum = at<std::uint32_t>(entry + 16);
    file.bytes = extra64.value(at<std::uint32_t>(entry + 24));
    const std::uint64_t stored = extra64.value(at<std::uint32_t>(entry + 20));
    const std::uint64_t local = extra64.value(at<std::uint32_t>(entry + 42));
    const std::uint64_t data = check_local(local, file, stored, (flags & kSizesFollow) != 0);
    range = {local, data + stored};
    file.stored = archive_.subspan(data, stored);
    return whole;
  }

  // Compares the file's own header with the directory. Returns the offset of the stored bytes.
  std::uint64_t check_local(std::uint64_t local, const ZippedFile& file, std::uint64_t stored,
                            bool sizes_follow) const {
    require(local <= begin_ && begin_ - local >= kLocal && at<std::uint32_t>(local) == kLocalSign,
            "a file is outside of it");
    const std::uint64_t name_bytes = at<std::uint16_t>(local + 26);
    const std::uint64_t extra_bytes = at<std::uint16_t>(local + 28);
    const std::uint64_t extra = local + kLocal + name_bytes, data = extra + extra_bytes;
    require(data <= begin_ && stored <= begin_ - data, "a file is outside of it");
    require(text(local + kLocal, name_bytes) == file.name &&
                at<std::uint16_t>(local + 8) == file.method,
            "a file's header is not as in its directory");
    if (!sizes_follow) {
      Extra64 extra64(*this, extra, data);
      const std::uint64_t bytes = extra64.value(at<std::uint32_t>(local + 22));
      require(extra64.value(at<std::uint32_t>(local + 18)) == stored && bytes == file.bytes &&
                  at<std::uint32_t>(local + 14) == file.checksum,
              "a file's header is not as in its directory");
    }
    return data;
  }

  ByteSpan archive_;
  const std::string& path_;
  std::uint64_t entries_ = 0;
  std::uint64_t begin_ = 0, end_ = 0;  // the directory's first byte and its end
};

constexpr std::uint16_t kDate = 1 << 5 | 1;  // 1980-01-01
constexpr std::uint16_t kNameIsUtf8 = 1 << 11;
constexpr std::uint16_t kVersion = 20, kVersion64 = 45;  // the format's version that a reader needs

/// A size or offset of 32 bits, which is added to the 64-bit extra field if it does not fit.
std::uint32_t short_value(std::uint64_t value, std::string& extra) {
  if (value < kIn64Bits) return static_cast<std::uint32_t>(value);
  put_values(extra, value);
  return kIn64Bits;
}

/// The extra field with 64-bit values; empty without values.
std::string extra_field(const std::string& values) {
  std::string field;
  if (!values.empty())
    put_values(field, std::uint16_t{1}, static_cast<std::uint16_t>(values.size()));
  return field + values;
}

/// An extra field behind which a file's content begins at a multiple of 64 bytes; `end` is the end
/// of its header without the field.
std::string padding(std::uint64_t end) {
  constexpr std::uint64_t kStep = 64, kHeader = 4;
  const std::uint64_t bytes = (kStep - (end + kHeader) % kStep) % kStep;
  std::string field;
  put_values(field, std::uint16_t{0x1986}, static_cast<std::uint16_t>(bytes));
  return field + std::string(bytes, '\0');
}

/// Writes an archive, file by file.
class Archive {
 public:
  explicit Archive(std::ostream& stream) : stream_(stream) {}

  void add(const ZipEntry& entry, ZipForm form) {
    constexpr int kLevel = 9;
    const bool packs = form == ZipForm::deflated;
    const std::string packed = packs ? deflated(entry.content, kLevel) : std::string();
    const std::string& stored = packs ? packed : entry.content;
    const auto checksum = static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(entry.content.data()), entry.content.size()));
    const bool is_ascii = std::ranges::all_of(
        entry.name, [](char c) { return static_cast<unsigned char>(c) < 0x80; });
    const auto name_bytes = static_cast<std::uint16_t>(entry.name.size());
    // A file's own header has both sizes in 64 bits or none.
    const bool is_long = entry.content.size() >= kIn64Bits || stored.size() >= kIn64Bits;
    std::string common, values;  // the part that both headers have
    put_values(common, is_long || offset_ >= kIn64Bits ? kVersion64 : kVersion,
               is_ascii ? std::uint16_t{0} : kNameIsUtf8, static_cast<std::uint16_t>(packs ? 8 : 0),
               std::uint16_t{0}, kDate, checksum);
    if (is_long) {
      put_values(common, kIn64Bits, kIn64Bits);
      put_values(values, std::uint64_t{entry.content.size()}, std::uint64_t{stored.size()});
    } else {
      put_values(common, static_cast<std::uint32_t>(stored.size()),
                 static_cast<std::uint32_t>(entry.content.size()));
    }
    put_values(common, name_bytes);
    std::string local = "PK\3\4" + common;
    std::string extra = extra_field(values);
    if (form == ZipForm::aligned)
      extra += padding(offset_ + local.size() + 2 + entry.name.size() + extra.size());
    put_values(local, static_cast<std::uint16_t>(extra.size()));
    local += entry.name + extra;

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
    if (begin >= kIn64Bits || bytes >= kIn64Bits || files_ >= kMany) {
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

std::vector<ZippedFile> zip_directory(ByteSpan archive, const std::string& path) {
  return Directory(archive, path).read();
}

Array<std::byte> unzipped(const ZippedFile& file, const std::string& path) {
  if (file.encrypted) fail("{}: {} is encrypted", path, file.name);
  if (file.method != kStored && file.method != kDeflated)
    fail("{}: {} is compressed by method {} of zip, which is not supported", path, file.name,
         file.method);
  // Room for one byte more than announced detects a wrong size.
  Array<std::byte> bytes(file.bytes + 1);
  std::size_t filled = 0;
  if (file.method == kStored) {
    filled = std::min<std::size_t>(file.stored.size(), bytes.size());
    if (filled > 0) std::memcpy(bytes.data(), file.stored.data(), filled);
  } else {
    Inflater inflater(file.stored, path, DeflateForm::deflate);
    filled = inflater.try_read(bytes);
    if (!inflater.problem().empty())
      fail("{}: {} is damaged ({})", path, file.name, inflater.problem());
  }
  if (filled != file.bytes)
    fail("{}: {} does not have the {} bytes that the archive announces", path, file.name,
         file.bytes);
  bytes.pop_back();
  if (crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()) != file.checksum)
    fail("{}: {} is damaged (its checksum is wrong)", path, file.name);
  return bytes;
}

void write_zip(const std::filesystem::path& path, const std::vector<ZipEntry>& entries,
               ZipForm form) {
  write_file(path, [&](std::ostream& stream) {
    Archive archive(stream);
    for (const ZipEntry& entry : entries) archive.add(entry, form);
    archive.finish();
  });
}

}  // namespace qs
