// SPDX-License-Identifier: MIT
//
// PNG with libpng. libpng reports errors by longjmp, so functions that call setjmp have no objects
// with destructors: resources are owned by structs of their callers.
#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <png.h>

#include "base/fail.h"
#include "base/not_copied.h"
#include "io/bytes/replace_file.h"
#include "io/picture/panorama_tag.h"
#include "io/picture/picture_formats.h"

namespace qs {
namespace {

constexpr std::size_t kMessageSize = 200;

extern "C" void keep_message(png_structp png, png_const_charp message) {
  std::snprintf(static_cast<char*>(png_get_error_ptr(png)), kMessageSize, "%s", message);
  png_longjmp(png, 1);
}

extern "C" void ignore_warning(png_structp, png_const_charp) {}

// ---- reading ------------------------------------------------------------------------------------

struct PngReader : NotCopied {
  char message[kMessageSize] = "";
  png_structp png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, message, keep_message, ignore_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;

  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

bool read_png_header(PngReader& reader, std::FILE* file) {
  if (setjmp(png_jmpbuf(reader.png))) return false;
  png_init_io(reader.png, file);
  png_set_user_limits(reader.png, 0x7fffffff, 0x7fffffff);  // check_picture_size() sets the limits
  // Texts and profiles are skipped, because libpng allocates the length that they claim.
  png_set_keep_unknown_chunks(reader.png, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
  png_read_info(reader.png, reader.info);
  return true;
}

// Requests gray, gray-alpha, RGB or RGBA in 8 bits, or in 16 bits in host byte order. libpng
// allocates rows here, so the size was checked before.
bool prepare_png_rows(PngReader& reader) {
  if (setjmp(png_jmpbuf(reader.png))) return false;
  png_set_expand(reader.png);
  if constexpr (std::endian::native == std::endian::little) png_set_swap(reader.png);
  png_set_interlace_handling(reader.png);
  png_read_update_info(reader.png, reader.info);
  return true;
}

bool read_png_pixels(PngReader& reader, png_bytep* rows) {
  if (setjmp(png_jmpbuf(reader.png))) return false;
  png_read_image(reader.png, rows);
  png_read_end(reader.png, nullptr);
  return true;
}

// ---- writing ------------------------------------------------------------------------------------

/// The state that libpng's callbacks get. The message is first, as keep_message() expects it.
struct WriterState {
  char message[kMessageSize] = "";
  const Progress* progress = nullptr;
  int height = 0;
};

extern "C" void report_row(png_structp png, png_uint_32 row, int) {
  const auto& state = *static_cast<const WriterState*>(png_get_error_ptr(png));
  if (state.progress->report)
    state.progress->report(static_cast<float>(row) / static_cast<float>(state.height));
}

struct Writer : NotCopied {
  WriterState state;
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, &state, keep_message, ignore_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;

  ~Writer() { png_destroy_write_struct(&png, &info); }
};

struct Pixels {
  int width, height, channels, bits;  // bits: of a value
  std::vector<png_bytep> rows;
  std::vector<png_text> texts;
};

bool write_all(Writer& writer, std::FILE* file, Pixels& pixels) {
  static constexpr int kColorTypes[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA,
                                        PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
  if (setjmp(png_jmpbuf(writer.png))) return false;
  png_init_io(writer.png, file);
  png_set_compression_level(writer.png, 4);  // within 3 % of the default's size in half of its time
  png_set_IHDR(writer.png, writer.info, static_cast<png_uint_32>(pixels.width),
               static_cast<png_uint_32>(pixels.height), pixels.bits,
               kColorTypes[pixels.channels - 1], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_set_text(writer.png, writer.info, pixels.texts.data(), static_cast<int>(pixels.texts.size()));
  png_set_write_status_fn(writer.png, report_row);
  png_write_info(writer.png, writer.info);
  png_write_image(writer.png, pixels.rows.data());
  png_write_end(writer.png, nullptr);
  return true;
}

// tEXt holds Latin-1, iTXt UTF-8. ASCII is stored as tEXt, but XMP is read from iTXt alone.
png_text make_text(std::string& key, std::string& value) {
  png_text text{};
  const bool ascii = key != kXmpText && std::ranges::all_of(value, [](char c) { return c >= 0; });
  text.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
  text.key = key.data();
  text.text = value.data();
  text.text_length = ascii ? value.size() : 0;
  text.itxt_length = ascii ? 0 : value.size();
  return text;
}

// The values in 8 bits, or in 16 bits, big endian.
std::vector<png_byte> bytes_of(const Image& image, int bits) {
  std::vector<png_byte> bytes;
  bytes.reserve(image.values.size() * static_cast<std::size_t>(bits / 8));
  for (const float value : image.values) {
    if (bits == 8) {
      bytes.push_back(to_8bit(value));
    } else {
      const double stored = std::min(std::max(0.0, 65535 * static_cast<double>(value)), 65535.0);
      const auto rounded = static_cast<unsigned>(stored + 0.5);
      bytes.push_back(static_cast<png_byte>(rounded >> 8));
      bytes.push_back(static_cast<png_byte>(rounded & 0xff));
    }
  }
  return bytes;
}

// Returns an error message, or an empty string.
std::string encode(const Image& image, int bits, std::FILE* file, const ImageMetadata& metadata,
                   const Progress& progress) {
  std::vector<png_byte> bytes = bytes_of(image, bits);
  std::vector<std::pair<std::string, std::string>> entries(metadata.begin(), metadata.end());
  Pixels pixels{image.width, image.height, image.channels, bits, {}, {}};
  const auto row_bytes = static_cast<std::size_t>(image.width * image.channels * bits / 8);
  for (int y = 0; y < image.height; ++y)
    pixels.rows.push_back(bytes.data() + static_cast<std::size_t>(y) * row_bytes);
  for (auto& [key, value] : entries) pixels.texts.push_back(make_text(key, value));
  Writer writer;
  if (!writer.info) throw std::bad_alloc();
  writer.state.progress = &progress;
  writer.state.height = image.height;
  return write_all(writer, file, pixels) ? "" : writer.state.message;
}

void write_file(const Image& image, int bits, const PictureTarget& target,
                const ImageMetadata& metadata) {
  const File file(std::fopen(target.file.c_str(), "wb"));
  if (!file) fail("{}: cannot be written", target.shown.string());
  errno = 0;
  const std::string problem = encode(image, bits, file.get(), metadata, target.progress);
  if (problem.empty() && std::fflush(file.get()) == 0) return;
  if (errno != 0) fail_to_write(target.shown, target.file);
  fail("{}: cannot be written: {}", target.shown.string(), problem);
}

}  // namespace

Image read_png(const std::filesystem::path& path) {
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail("{}: cannot be opened", path.string());
  PngReader reader;
  if (!reader.info) throw std::bad_alloc();
  if (!read_png_header(reader, file.get()))
    fail("{}: not a readable PNG: {}", path.string(), reader.message);

  const png_uint_32 width = png_get_image_width(reader.png, reader.info);
  const png_uint_32 height = png_get_image_height(reader.png, reader.info);
  check_picture_size(path, width, height, 1);
  if (!prepare_png_rows(reader)) fail("{}: not a readable PNG: {}", path.string(), reader.message);
  const int channels = png_get_channels(reader.png, reader.info);
  const bool wide = png_get_bit_depth(reader.png, reader.info) == 16;
  check_picture_size(path, width, height, channels);
  // Deflate expands at most 1,032 times, and a 1-bit pixel may become 32 bits of RGBA.
  const std::uint64_t row_bytes = png_get_rowbytes(reader.png, reader.info);
  if (row_bytes * height / (1032 * 32) > std::filesystem::file_size(path))
    fail("{}: claims {} x {} pixels, which its {} bytes cannot hold", path.string(), width, height,
         std::filesystem::file_size(path));
  std::vector<png_byte> bytes(row_bytes * height);
  std::vector<png_bytep> rows(height);
  for (std::size_t y = 0; y < height; ++y) rows[y] = bytes.data() + y * row_bytes;
  if (!read_png_pixels(reader, rows.data()))
    fail("{}: damaged PNG: {}", path.string(), reader.message);

  Image image(static_cast<int>(width), static_cast<int>(height), channels);
  for (int y = 0; y < image.height; ++y) {
    const png_bytep row = rows[static_cast<std::size_t>(y)];
    float* out = image.row(y);
    const int count = image.width * channels;
    if (wide) {
      const auto* values = reinterpret_cast<const std::uint16_t*>(row);  // rows are of even length
      std::transform(values, values + count, out,
                     [](std::uint16_t v) { return static_cast<float>(v) / 65535; });
    } else {
      std::transform(row, row + count, out, [](png_byte v) { return static_cast<float>(v) / 255; });
    }
  }
  return image;
}

std::string encode_png(const Image& image, const ImageMetadata& metadata) {
  char* bytes = nullptr;
  std::size_t size = 0;
  File memory(open_memstream(&bytes, &size));
  if (!memory) throw std::bad_alloc();
  const std::string problem = encode(image, 8, memory.get(), with_software(metadata), {});
  memory.reset();  // completes `bytes` and `size`
  const std::unique_ptr<char, void (*)(void*)> owner(bytes, std::free);
  if (!problem.empty()) fail(ErrorKind::device, "a PNG cannot be encoded: {}", problem);
  return {bytes, size};
}

void write_png(const Image& image, const PictureTarget& target, const ImageMetadata& metadata) {
  write_file(image, 8, target, metadata);
}

void write_png_16(const Image& image, const PictureTarget& target, const ImageMetadata& metadata) {
  write_file(image, 16, target, metadata);
}

}  // namespace qs
