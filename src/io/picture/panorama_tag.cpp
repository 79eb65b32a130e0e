// SPDX-License-Identifier: MIT
#include "io/picture/panorama_tag.h"

#include <cmath>
#include <fstream>

#include <fmt/format.h>

#include "base/progress.h"
#include "io/picture/picture_formats.h"

namespace qs {

std::string panorama_xmp(int width, int height, double degrees) {
  const int full = static_cast<int>(std::lround(width * 360 / degrees));
  return fmt::format(
      "<?xpacket begin=\"\xef\xbb\xbf\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
      "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
      "<rdf:Description rdf:about=\"\" xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\"\n"
      " GPano:ProjectionType=\"equirectangular\" GPano:UsePanoramaViewer=\"True\"\n"
      " GPano:FullPanoWidthPixels=\"{}\" GPano:FullPanoHeightPixels=\"{}\"\n"
      " GPano:CroppedAreaImageWidthPixels=\"{}\" GPano:CroppedAreaImageHeightPixels=\"{}\"\n"
      " GPano:CroppedAreaLeftPixels=\"{}\" GPano:CroppedAreaTopPixels=\"0\"/>\n"
      "</rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"w\"?>",
      full, height, width, height, (full - width) / 2);
}

void add_xmp(const std::filesystem::path& file, const std::filesystem::path& shown,
             const std::string& xmp) {
  const std::string bytes = read_picture_bytes(file);
  const auto big_endian = [](std::size_t value) {
    return std::string{static_cast<char>(value >> 8), static_cast<char>(value)};
  };
  // Behind the start of the picture and the segment of JFIF, which comes first.
  std::size_t at = 2;
  if (bytes.compare(at, 2, "\xff\xe0") == 0)
    at += 2 + 256 * static_cast<unsigned char>(bytes[at + 2]) +
          static_cast<unsigned char>(bytes[at + 3]);
  const std::string content = std::string("http://ns.adobe.com/xap/1.0/") + '\0' + xmp;
  const Progress none;
  const PictureTarget target{file, shown, none};
  std::ofstream out = open_picture(target);
  out << bytes.substr(0, at) << "\xff\xe1" << big_endian(content.size() + 2) << content
      << bytes.substr(at);
  close_picture(out, target);
}

}  // namespace qs
