// SPDX-License-Identifier: MIT
#include "app/serve/requests.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <cstdint>

#include <sys/random.h>

#include "base/fail.h"

namespace qs {
namespace {

constexpr PageFile script(const char* target, const char* asset) {
  return {target, asset, "text/javascript; charset=utf-8"};
}

constexpr std::array kPageFiles = {
    PageFile{"/", "assets/serve/page.html", "text/html; charset=utf-8"},
    PageFile{"/page.css", "assets/serve/page.css", "text/css; charset=utf-8"},
    script("/page.js", "assets/serve/page.js"),
    script("/video.js", "assets/serve/video.js"),
    script("/panels.js", "assets/serve/panels.js"),
    script("/controls.js", "assets/serve/controls.js"),
    script("/table.js", "assets/serve/table.js"),
    script("/chart.js", "assets/serve/chart.js"),
    script("/overlay.js", "assets/serve/overlay.js"),
    script("/files.js", "assets/serve/files.js"),
    PageFile{"/icon.svg", "assets/serve/icon.svg", "image/svg+xml"},
};

constexpr std::array kSecurityFields = {
    HeaderField{"Content-Security-Policy",
                "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
                "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; "
                "require-trusted-types-for 'script'"},
    HeaderField{"X-Content-Type-Options", "nosniff"},
    HeaderField{"Referrer-Policy", "no-referrer"},
    HeaderField{"Cache-Control", "no-store"},
    HeaderField{"Cross-Origin-Resource-Policy", "same-origin"},
    HeaderField{"Cross-Origin-Opener-Policy", "same-origin"},
};

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

bool are_all(std::string_view text, bool (*is_one)(char c)) {
  return !text.empty() && std::ranges::all_of(text, is_one);
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_in_name(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || c == '-' || c == '.' || c == '_';
}
bool is_in_ipv6(char c) { return is_digit(c) || (c >= 'a' && c <= 'f') || c == ':' || c == '.'; }

}  // namespace

std::span<const PageFile> page_files() { return kPageFiles; }
std::span<const HeaderField> security_fields() { return kSecurityFields; }

const PageFile* page_file(std::string_view target) {
  const auto found = std::ranges::find(kPageFiles, target, &PageFile::target);
  return found == kPageFiles.end() ? nullptr : &*found;
}

std::string name_in_host(std::string_view host) {
  const std::string lower = in_lower_case(host);
  const std::string_view text = lower;
  const bool in_brackets = text.starts_with('[');
  std::size_t end = in_brackets ? text.find(']') : text.find(':');
  if (in_brackets && end == text.npos) return {};
  if (in_brackets) ++end;
  const std::string_view name = text.substr(0, end);
  const std::string_view port = end < text.size() ? text.substr(end) : std::string_view();
  const bool sound_name = in_brackets ? are_all(name.substr(1, name.size() - 2), is_in_ipv6)
                                      : are_all(name, is_in_name);
  const bool sound_port = port.empty() || (port.size() <= 6 && port.front() == ':' &&
                                           are_all(port.substr(1), is_digit));
  return sound_name && sound_port ? std::string(name) : std::string();
}

HostNames::HostNames(const std::string& address, const std::string& name)
    : names_{"localhost", "127.0.0.1", "[::1]"} {
  const bool is_ipv6 = address.find(':') != address.npos;
  names_.push_back(in_lower_case(is_ipv6 ? "[" + address + "]" : address));
  if (!name.empty()) names_.push_back(in_lower_case(name));
}

bool HostNames::has(std::string_view host) const {
  const std::string name = name_in_host(host);
  return !name.empty() && std::ranges::find(names_, name) != names_.end();
}

unsigned status_of(const RequestHead& head, std::string_view scheme, const HostNames& names,
                   std::size_t most_target_bytes) {
  if (head.method != "GET") return 405;
  if (head.target.size() > most_target_bytes) return 414;
  if (head.hosts.size() != 1 || name_in_host(head.hosts.front()).empty()) return 400;
  if (!names.has(head.hosts.front())) return 403;
  if (!head.upgrades) return page_file(head.target) != nullptr ? 200 : 404;
  if (head.target != kLiveTarget) return 404;
  const std::string own = std::string(scheme) + "://" + head.hosts.front();
  return head.origins.size() == 1 && head.origins.front() == own ? 101 : 403;
}

std::string make_token() {
  std::array<std::uint8_t, 16> bits{};
  if (getrandom(bits.data(), bits.size(), 0) != static_cast<ssize_t>(bits.size()))
    fail(ErrorKind::device, "serve: the system has no random numbers");
  std::string token;
  for (const std::uint8_t byte : bits) token += fmt::format("{:02x}", byte);
  return token;
}

bool same_token(std::string_view token, std::string_view given) {
  if (token.size() != given.size()) return false;
  volatile unsigned char difference = 0;
  for (std::size_t i = 0; i < token.size(); ++i)
    difference = static_cast<unsigned char>(difference | (token[i] ^ given[i]));
  return difference == 0;
}

}  // namespace qs
