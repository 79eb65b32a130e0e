// SPDX-License-Identifier: MIT
//
// JPEG with libjpeg-turbo. It reads gray or RGB, 8 bits, in the orientation in which it is stored.
// libjpeg reports errors by a handler that must not return. It jumps, so functions that call setjmp
// have no objects with destructors: resources are owned by structs of their callers.
#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include <jerror.h>
#include <jpeglib.h>  // after cstdio

#include "base/fail.h"
#include "base/not_copied.h"
#include "io/picture/image_file.h"
#include "io/picture/picture_formats.h"

namespace qs {
namespace {

struct JpegErrors {
  jpeg_error_mgr manager{};  // first, so that handlers find the rest
  std::jmp_buf jump{};
  char message[JMSG_LENGTH_MAX] = "";
};

struct JpegReader : NotCopied {
  JpegErrors errors;
  jpeg_decompress_struct jpeg{};
  ~JpegReader() { jpeg_destroy_decompress(&jpeg); }
};

struct JpegWriter : NotCopied {
  JpegErrors errors;
  jpeg_compress_struct jpeg{};
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  ~JpegWriter() {
    jpeg_destroy_compress(&jpeg);
    std::free(bytes);
  }
};

JpegErrors& errors_of(j_common_ptr jpeg) { return *reinterpret_cast<JpegErrors*>(jpeg->err); }

void keep_message(j_common_ptr jpeg) { jpeg->err->format_message(jpeg, errors_of(jpeg).message); }

extern "C" [[noreturn]] void stop(j_common_ptr jpeg) {
  keep_message(jpeg);
  std::longjmp(errors_of(jpeg).jump, 1);
}

// libjpeg goes on after damage, with gray or wrong pixels, and only warns. Other warnings do not
// change the picture.
extern "C" void note_warning(j_common_ptr jpeg, int level) {
  if (level >= 0 || errors_of(jpeg).message[0] != '\0') return;
  const int harmless[] = {JWRN_EXTRANEOUS_DATA, JWRN_ADOBE_XFORM, JWRN_JFIF_MAJOR,
                          JWRN_TOO_MUCH_DATA, JWRN_BOGUS_ICC};
  if (std::find(std::begin(harmless), std::end(harmless), jpeg->err->msg_code) ==
      std::end(harmless))
    keep_message(jpeg);
}

extern "C" void print_nothing(j_common_ptr) {}

jpeg_error_mgr* handle(JpegErrors& errors) {
  jpeg_std_error(&errors.manager);
  errors.manager.error_exit = stop;
  errors.manager.emit_message = note_warning;
  errors.manager.output_message = print_nothing;
  return &errors.manager;
}

bool read_jpeg_header(JpegReader& reader, std::FILE* file) {
  reader.jpeg.err = handle(reader.errors);
  if (setjmp(reader.errors.jump)) return false;
  jpeg_create_decompress(&reader.jpeg);
  jpeg_stdio_src(&reader.jpeg, file);
  jpeg_read_header(&reader.jpeg, TRUE);
  return reader.errors.message[0] == '\0';
}

bool read_jpeg_pixels(JpegReader& reader, JSAMPROW* rows) {
  if (setjmp(reader.errors.jump)) return false;
  jpeg_decompress_struct& jpeg = reader.jpeg;
  jpeg.out_color_space = jpeg.jpeg_color_space == JCS_GRAYSCALE ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height)
    jpeg_read_scanlines(&jpeg, rows + jpeg.output_scanline,
                        jpeg.output_height - jpeg.output_scanline);
  jpeg_finish_decompress(&jpeg);
  return reader.errors.message[0] == '\0';
}

// Every 8 x 8 pixels of the finest component take at least one bit in each direction, so a byte
// holds at most 1,024 pixels (arithmetic coding could hold more, but only of pictures of one
// colour).
constexpr std::uintmax_t kMostPixelsPerByte = 1024;

void check_header(const jpeg_decompress_struct& jpeg, const std::filesystem::path& path) {
  const J_COLOR_SPACE colors = jpeg.jpeg_color_space;
  if (colors == JCS_CMYK || colors == JCS_YCCK)
    fail("{}: a JPEG with CMYK colours, which are for printing: convert it to RGB", path.string());
  if (colors != JCS_GRAYSCALE && colors != JCS_RGB && colors != JCS_YCbCr)
    fail("{}: a JPEG with {} components of unknown colours", path.string(), jpeg.num_components);
  check_picture_size(path, jpeg.image_width, jpeg.image_height, jpeg.num_components);
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  if (std::uintmax_t{jpeg.image_width} * jpeg.image_height / kMostPixelsPerByte > bytes)
    fail("{}: claims {} x {} pixels, which its {} bytes cannot hold", path.string(),
         jpeg.image_width, jpeg.image_height, bytes);
}

bool write_jpeg(JpegWriter& writer, const RgbaPixels& pixels, int quality, std::uint8_t* row) {
  writer.jpeg.err = handle(writer.errors);
  if (setjmp(writer.errors.jump)) return false;
  jpeg_compress_struct& jpeg = writer.jpeg;
  jpeg_create_compress(&jpeg);
  jpeg_mem_dest(&jpeg, &writer.bytes, &writer.size);
  jpeg.image_width = static_cast<JDIMENSION>(pixels.width);
  jpeg.image_height = static_cast<JDIMENSION>(pixels.height);
  jpeg.input_components = 3;
  jpeg.in_color_space = JCS_RGB;
  jpeg_set_defaults(&jpeg);
  jpeg_set_quality(&jpeg, quality, TRUE);
  jpeg_start_compress(&jpeg, TRUE);
  const std::size_t width = jpeg.image_width;
  while (jpeg.next_scanline < jpeg.image_height) {
    const std::uint8_t* from = pixels.values.data() + 4 * width * jpeg.next_scanline;
    for (std::size_t x = 0; x < width; ++x)
      for (std::size_t c = 0; c < 3; ++c) row[3 * x + c] = from[4 * x + c];
    JSAMPROW rows[] = {row};
    jpeg_write_scanlines(&jpeg, rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  return true;
}

}  // namespace

Image read_jpeg(const std::filesystem::path& path) {
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail("{}: cannot be opened", path.string());
  JpegReader reader;
  if (!read_jpeg_header(reader, file.get()))
    fail("{}: not a readable JPEG: {}", path.string(), reader.errors.message);
  check_header(reader.jpeg, path);

  Image image(static_cast<int>(reader.jpeg.image_width), static_cast<int>(reader.jpeg.image_height),
              reader.jpeg.jpeg_color_space == JCS_GRAYSCALE ? 1 : 3);
  std::vector<JSAMPLE> bytes(image.values.size());
  std::vector<JSAMPROW> rows(reader.jpeg.image_height);
  const std::size_t row_bytes = bytes.size() / rows.size();
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = bytes.data() + y * row_bytes;
  if (!read_jpeg_pixels(reader, rows.data()))
    fail("{}: damaged JPEG: {}", path.string(), reader.errors.message);
  std::ranges::transform(bytes, image.values.begin(),
                         [](JSAMPLE value) { return static_cast<float>(value) / 255; });
  return image;
}

std::string encode_jpeg(const RgbaPixels& pixels, int quality) {
  std::vector<std::uint8_t> row(3 * static_cast<std::size_t>(pixels.width));
  JpegWriter writer;
  if (!write_jpeg(writer, pixels, quality, row.data()))
    fail(ErrorKind::device, "not enough memory to encode a picture");
  return {reinterpret_cast<const char*>(writer.bytes), writer.size};
}

}  // namespace qs
