// SPDX-License-Identifier: MIT
#include "io/picture/oiio/module.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include <OpenImageIO/imageio.h>

#include "raster/scene/image.h"

namespace qs {
namespace {

// Copies the first line of `text`.
void say(OiioMessage* message, std::string text) {
  text = text.substr(0, text.find('\n'));
  std::snprintf(message->text, sizeof message->text, "%s",
                text.empty() ? "unknown reason" : text.c_str());
}

// OpenImageIO would multiply colours by alpha on reading and divide them on writing.
void keep_alpha_as_stored(OIIO::ImageSpec& spec) { spec.attribute("oiio:UnassociatedAlpha", 1); }

void* open(const char* path, OiioPicture* picture, OiioMessage* message) try {
  OIIO::ImageSpec config;
  keep_alpha_as_stored(config);
  if (!OIIO::ImageInput::create(path)) {
    OIIO::geterror();  // discards a question
    say(message, "no picture format has this ending");
    return nullptr;
  }
  auto input = OIIO::ImageInput::open(path, &config);
  if (!input) {
    say(message, OIIO::geterror());
    return nullptr;
  }
  const OIIO::ImageSpec& spec = input->spec();
  *picture = {spec.width, spec.height, std::min(spec.nchannels, 4), nullptr, nullptr};
  return input.release();
} catch (const std::exception& error) {
  say(message, error.what());
  return nullptr;
}

int read(void* handle, OiioPicture* picture, OiioMessage* message) try {
  auto* input = static_cast<OIIO::ImageInput*>(handle);
  if (input->read_image(0, 0, 0, picture->channels, OIIO::TypeDesc::FLOAT, picture->values))
    return 1;
  say(message, input->geterror());
  return 0;
} catch (const std::exception& error) {
  say(message, error.what());
  return 0;
}

void close(void* handle) { delete static_cast<OIIO::ImageInput*>(handle); }

bool holds_floats(const OIIO::ImageOutput& output) {
  const std::string format = output.format_name();
  return format == "openexr" || format == "tiff" || format == "hdr" || format == "fits";
}

int write(const char* path, const OiioPicture* picture, const OiioText* texts, int text_count,
          OiioMessage* message) try {
  const auto output = OIIO::ImageOutput::create(path);
  if (!output) {
    OIIO::geterror();  // discards a message that would name the temporary file
    say(message, "no picture format has this ending: use .png, for example");
    return 0;
  }
  const bool floats = holds_floats(*output);
  OIIO::ImageSpec spec(picture->width, picture->height, picture->channels,
                       floats ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  keep_alpha_as_stored(spec);
  spec.attribute("CompressionQuality", 95);
  spec.attribute("jpeg:subsampling", "4:4:4");
  if (picture->channel != nullptr) spec.channelnames.assign(1, picture->channel);
  for (int i = 0; i < text_count; ++i) spec.attribute(texts[i].key, texts[i].value);

  bool good = output->open(path, spec);
  if (good && floats) {
    good = output->write_image(OIIO::TypeDesc::FLOAT, picture->values);
  } else if (good) {
    const std::size_t count = static_cast<std::size_t>(picture->width) *
                              static_cast<std::size_t>(picture->height) *
                              static_cast<std::size_t>(picture->channels);
    std::vector<std::uint8_t> bytes(count);
    std::transform(picture->values, picture->values + count, bytes.begin(), to_8bit);
    good = output->write_image(OIIO::TypeDesc::UINT8, bytes.data());
  }
  if (good && output->close()) return 1;
  say(message, output->geterror());
  return 0;
} catch (const std::exception& error) {
  say(message, error.what());
  return 0;
}

}  // namespace
}  // namespace qs

extern "C" const qs::OiioModule* quadsplat_oiio_module() {
  static constexpr qs::OiioModule kModule{qs::kOiioModuleVersion, qs::open, qs::read, qs::close,
                                          qs::write};
  return &kModule;
}
