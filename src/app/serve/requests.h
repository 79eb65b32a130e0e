// SPDX-License-Identifier: MIT
//
// The rules for HTTP requests, without sockets: which files there are, and who may ask for them;
// and the token of visitors.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace qs {

/// A file of the page.
struct PageFile {
  const char* target;  ///< in requests
  const char* asset;   ///< for find_asset()
  const char* type;    ///< Content-Type
};

/// All files that can be asked for. No other path of a request reaches the file system.
std::span<const PageFile> page_files();

/// The target at which a client opens its WebSocket.
inline constexpr std::string_view kLiveTarget = "/live";

/// The head of a request.
struct RequestHead {
  std::string method, target;
  std::vector<std::string> hosts, origins;  ///< the values of all such fields
  bool upgrades = false;                    ///< asks for a WebSocket
};

/// The names by which clients may address the server. Others are refused, because a foreign name
/// that resolves to this machine lets a foreign page talk to the server (DNS rebinding).
class HostNames {
 public:
  /// localhost, 127.0.0.1 and [::1]; `address`: of the server; `name`: may be empty.
  HostNames(const std::string& address, const std::string& name);

  /// `host`: the value of a Host field, with any port, because tunnels have other ports.
  bool has(std::string_view host) const;

 private:
  std::vector<std::string> names_;
};

/// "localhost:8080" -> "localhost" in lower case; empty if the value is damaged.
std::string name_in_host(std::string_view host);

/// The status of the answer: 101 opens a WebSocket, 200 sends the file page_file(target), others
/// refuse the request. `scheme`: of the server's addresses, "http" or "https".
unsigned status_of(const RequestHead& head, std::string_view scheme, const HostNames& names,
                   std::size_t most_target_bytes);

/// Null if there is none.
const PageFile* page_file(std::string_view target);

/// The fields of every answer that restrict what the page may do.
struct HeaderField {
  const char *name, *value;
};
std::span<const HeaderField> security_fields();

// ---- the token ----------------------------------------------------------------------------------
// The secret that a visitor of the server must know. It is in the fragment of the printed address,
// which browsers send to nobody; the page sends it in its first message.

/// 128 random bits of the system as 32 hexadecimal digits. Throws Error(device) without them.
std::string make_token();

/// True if both are equal. Takes the same time wherever they differ.
bool same_token(std::string_view token, std::string_view given);

}  // namespace qs
