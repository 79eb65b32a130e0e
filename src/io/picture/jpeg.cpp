// SPDX-License-Identifier: MIT
//
// Reads JPEG with libjpeg-turbo: gray or RGB, 8 bits, in the orientation in which it is stored.
// libjpeg reports errors by a handler that must not return. It jumps, so functions that call setjmp
// have no objects with destructors: resources are owned by structs of their callers.
#include <algorithm>
#include <csetjmp>
#include <cstdio>
#include <memory>
#include <vector>

#include <jerror.h>
#include <jpeglib.h>  // after cstdio

#include "base/fail.h"
#include "io/picture/picture_formats.h"

namespace qs {
namespace {

struct JpegReader {
  jpeg_error_mgr errors{};  // first, so that handlers find the reader
  std::jmp_buf jump{};
  char message[JMSG_LENGTH_MAX] = "";
  jpeg_decompress_struct jpeg{};

  JpegReader() = default;
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
  ~JpegReader() { jpeg_destroy_decompress(&jpeg); }
};

void keep_message(j_common_ptr jpeg) {
  jpeg->err->format_message(jpeg, reinterpret_cast<JpegReader*>(jpeg->err)->message);
}

extern "C" [[noreturn]] void stop(j_common_ptr jpeg) {
  keep_message(jpeg);
  std::longjmp(reinterpret_cast<JpegReader*>(jpeg->err)->jump, 1);
}

// libjpeg goes on after damage, with gray or wrong pixels, and only warns. Other warnings do not
// change the picture.
extern "C" void note_warning(j_common_ptr jpeg, int level) {
  if (level >= 0 || reinterpret_cast<JpegReader*>(jpeg->err)->message[0] != '\0') return;
  const int harmless[] = {JWRN_EXTRANEOUS_DATA, JWRN_ADOBE_XFORM, JWRN_JFIF_MAJOR,
                          JWRN_TOO_MUCH_DATA, JWRN_BOGUS_ICC};
  if (std::find(std::begin(harmless), std::end(harmless), jpeg->err->msg_code) ==
      std::end(harmless))
    keep_message(jpeg);
}

extern "C" void print_nothing(j_common_ptr) {}

bool read_jpeg_header(JpegReader& reader, std::FILE* file) {
  reader.jpeg.err = jpeg_std_error(&reader.errors);
  reader.errors.error_exit = stop;
  reader.errors.emit_message = note_warning;
  reader.errors.output_message = print_nothing;
  if (setjmp(reader.jump)) return false;
  jpeg_create_decompress(&reader.jpeg);
  jpeg_stdio_src(&reader.jpeg, file);
  jpeg_read_header(&reader.jpeg, TRUE);
  return reader.message[0] == '\0';
}

bool read_jpeg_pixels(JpegReader& reader, JSAMPROW* rows) {
  if (setjmp(reader.jump)) return false;
  jpeg_decompress_struct& jpeg = reader.jpeg;
  jpeg.out_color_space = jpeg.jpeg_color_space == JCS_GRAYSCALE ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height)
    jpeg_read_scanlines(&jpeg, rows + jpeg.output_scanline,
                        jpeg.output_height - jpeg.output_scanline);
  jpeg_finish_decompress(&jpeg);
  return reader.message[0] == '\0';
}

// Every 8 x 8 pixels of the finest component take at least one bit in each direction, so a byte
// holds at most 1,024 pixels (arithmetic coding could hold more, but only of pictures of one
// colour).
constexpr std::uintmax_t kMostPixelsPerByte = 1024;

void check_header(const jpeg_decompress_struct& jpeg, const std::filesystem::path& path) {
  const J_COLOR_SPACE colors = jpeg.jpeg_color_space;
  if (colors == JCS_CMYK || colors == JCS_YCCK) {
    fail("{}: a JPEG with CMYK colours, which are for printing: convert it to RGB", path.string());
  }
  if (colors != JCS_GRAYSCALE && colors != JCS_RGB && colors != JCS_YCbCr) {
    fail("{}: a JPEG with {} components of unknown colours", path.string(), jpeg.num_components);
  }
  check_picture_size(path, jpeg.image_width, jpeg.image_height, jpeg.num_components);
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  if (std::uintmax_t{jpeg.image_width} * jpeg.image_height / kMostPixelsPerByte > bytes) {
    fail("{}: claims {} x {} pixels, which its {} bytes cannot hold", path.string(),
         jpeg.image_width, jpeg.image_height, bytes);
  }
}

}  // namespace

Image read_jpeg(const std::filesystem::path& path) {
  const File file(std::fopen(path.c_str(), "rb"));
  if (!file) fail("{}: cannot be opened", path.string());
  JpegReader reader;
  if (!read_jpeg_header(reader, file.get()))
    fail("{}: not a readable JPEG: {}", path.string(), reader.message);
  check_header(reader.jpeg, path);

  Image image(static_cast<int>(reader.jpeg.image_width), static_cast<int>(reader.jpeg.image_height),
              reader.jpeg.jpeg_color_space == JCS_GRAYSCALE ? 1 : 3);
  std::vector<JSAMPLE> bytes(image.values.size());
  std::vector<JSAMPROW> rows(reader.jpeg.image_height);
  const std::size_t row_bytes = bytes.size() / rows.size();
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = bytes.data() + y * row_bytes;
  if (!read_jpeg_pixels(reader, rows.data()))
    fail("{}: damaged JPEG: {}", path.string(), reader.message);
  std::transform(bytes.begin(), bytes.end(), image.values.begin(),
                 [](JSAMPLE value) { return static_cast<float>(value) / 255; });
  return image;
}

}  // namespace qs
