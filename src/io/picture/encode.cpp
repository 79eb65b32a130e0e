// SPDX-License-Identifier: MIT
//
// libjpeg reports errors by a handler that must not return. It jumps, so the function that calls
// setjmp has no objects with destructors: its caller owns the resources.
#include "io/picture/encode.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <jpeglib.h>  // after cstdio
#include <webp/encode.h>

#include "base/fail.h"
#include "base/progress.h"

namespace qs {
namespace {

// ---- JPEG ---------------------------------------------------------------------------------------
struct JpegWriter {
  jpeg_error_mgr errors{};  // first, so that the handler finds the writer
  std::jmp_buf jump{};
  jpeg_compress_struct jpeg{};
  unsigned char* bytes = nullptr;
  unsigned long size = 0;

  JpegWriter() = default;
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;
  ~JpegWriter() {
    jpeg_destroy_compress(&jpeg);
    std::free(bytes);
  }
};

extern "C" [[noreturn]] void leave_jpeg(j_common_ptr jpeg) {
  std::longjmp(reinterpret_cast<JpegWriter*>(jpeg->err)->jump, 1);
}
extern "C" void drop_jpeg_message(j_common_ptr) {}

bool write_jpeg(JpegWriter& writer, const RgbaPixels& pixels, int quality, std::uint8_t* row) {
  writer.jpeg.err = jpeg_std_error(&writer.errors);
  writer.errors.error_exit = leave_jpeg;
  writer.errors.output_message = drop_jpeg_message;
  if (setjmp(writer.jump)) return false;
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
    for (std::size_t x = 0; x < width; ++x) {
      for (std::size_t c = 0; c < 3; ++c) row[3 * x + c] = from[4 * x + c];
    }
    JSAMPROW rows[] = {row};
    jpeg_write_scanlines(&jpeg, rows, 1);
  }
  jpeg_finish_compress(&jpeg);
  return true;
}

// ---- WebP ---------------------------------------------------------------------------------------
struct WebpWriter {
  WebPPicture picture;
  WebPMemoryWriter memory;

  WebpWriter() {
    WebPPictureInit(&picture);
    WebPMemoryWriterInit(&memory);
  }
  WebpWriter(const WebpWriter&) = delete;
  WebpWriter& operator=(const WebpWriter&) = delete;
  ~WebpWriter() {
    WebPPictureFree(&picture);
    WebPMemoryWriterClear(&memory);
  }
};

int goes_on(int, const WebPPicture* picture) {
  return static_cast<const std::stop_token*>(picture->user_data)->stop_requested() ? 0 : 1;
}

}  // namespace

std::string encode_jpeg(const RgbaPixels& pixels, int quality) {
  std::vector<std::uint8_t> row(3 * static_cast<std::size_t>(pixels.width));
  JpegWriter writer;
  if (!write_jpeg(writer, pixels, quality, row.data()))
    fail(ErrorKind::device, "not enough memory to encode a picture");
  return {reinterpret_cast<const char*>(writer.bytes), writer.size};
}

std::string encode_webp(const RgbaPixels& pixels, const std::stop_token& stop) {
  WebPConfig config;
  WebPConfigInit(&config);
  WebPConfigLosslessPreset(&config, 0);  // the fastest
  WebpWriter writer;
  writer.picture.use_argb = 1;
  writer.picture.width = pixels.width;
  writer.picture.height = pixels.height;
  writer.picture.writer = WebPMemoryWrite;
  writer.picture.custom_ptr = &writer.memory;
  std::stop_token asked = stop;
  writer.picture.user_data = &asked;
  writer.picture.progress_hook = goes_on;
  const bool encoded =
      WebPPictureImportRGBX(&writer.picture, pixels.values.data(), 4 * pixels.width) != 0 &&
      WebPEncode(&config, &writer.picture) != 0;
  if (!encoded && stop.stop_requested()) throw Cancelled();
  if (!encoded) fail(ErrorKind::device, "not enough memory to encode a picture");
  return {reinterpret_cast<const char*>(writer.memory.mem), writer.memory.size};
}

}  // namespace qs
