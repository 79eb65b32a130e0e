// SPDX-License-Identifier: MIT
#include "library/check/call.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "quadsplat/quadsplat.h"

namespace qs::library {
namespace {

static_assert(static_cast<int>(ErrorKind::usage) == QS_USAGE);
static_assert(static_cast<int>(ErrorKind::input) == QS_INPUT);
static_assert(static_cast<int>(ErrorKind::device) == QS_DEVICE);

std::int32_t result(std::int32_t code, const char* sentence, char* message) noexcept {
  if (message != nullptr) copy_text(sentence, message, QS_MESSAGE_BYTES);
  return code;
}

std::int32_t classify(char* message) {
  try {
    throw;
  } catch (const Error& error) {
    return result(static_cast<std::int32_t>(error.kind()), error.what(), message);
  } catch (const Cancelled&) {
    return result(QS_CANCELLED, "cancelled", message);
  } catch (const std::filesystem::filesystem_error& error) {
    return result(QS_INPUT, error.what(), message);
  } catch (const std::exception& error) {
    return result(QS_DEVICE, sentence_of(error), message);
  } catch (...) {
    return result(QS_DEVICE, "an unknown error", message);
  }
}

}  // namespace

std::string Where::text() const {
  std::string text = fmt::format("{}: {}", call, argument);
  if (index >= 0) text += fmt::format("[{}]", index);
  if (member != nullptr) text += fmt::format(".{}", member);
  return text;
}

void copy_text(std::string_view text, char* target, std::size_t bytes) noexcept {
  std::size_t count = std::min(text.size(), bytes - 1);
  if (count < text.size()) {  // 10xxxxxx continues a character
    while (count > 0 && (static_cast<unsigned char>(text[count]) & 0xc0) == 0x80) --count;
  }
  std::memcpy(target, text.data(), count);
  target[count] = 0;
}

std::int32_t result_of_exception(char* message) noexcept {
  try {
    return classify(message);
  } catch (...) {  // no memory for a sentence
    if (message != nullptr) *message = 0;
    return QS_DEVICE;
  }
}

}  // namespace qs::library
