// SPDX-License-Identifier: MIT
#include "app/cli/serve_options.h"

#include <cstdio>

#include <fmt/format.h>

#include "app/serve/requests.h"
#include "base/fail.h"

namespace qs {
namespace {

// An IPv6 address is in brackets in front of a port.
std::string host_text(const std::string& address) {
  return address.find(':') == address.npos ? address : "[" + address + "]";
}

}  // namespace

void declare_serve_options(Options& options, ServeOptions& serve,
                           const Options::Samples& addresses) {
  options.integer("--port", "N", 0, 65535, serve.port,
                  "port to listen at; 0 = any free one (default: 7007)");
  options.text("--address", "ADDRESS", serve.address,
               "address to listen at (default: 127.0.0.1, which only this machine reaches)",
               addresses);
  options.text("--name", "HOST", serve.name,
               "name by which browsers may address this machine, beside localhost and --address",
               {"gpu7", "gpu7.example.org"});
  options.text("--certificate", "FILE", serve.tls.certificate,
               "PEM file with the certificates for https://; needs --key", {"missing.pem"});
  options.text("--key", "FILE", serve.tls.key, "PEM file with the key of --certificate",
               {"missing.pem"});
}

void complete(ServeOptions& serve) {
  if (serve.tls.certificate.empty() != serve.tls.key.empty())
    fail(ErrorKind::usage, "{}: --certificate and --key need each other", serve.command);
  serve.token = make_token();
}

void print_address(const ServeOptions& serve, int port, const std::string& what) {
  const std::string host = serve.name.empty() ? host_text(serve.address) : serve.name;
  const bool everywhere = serve.address == "0.0.0.0" || serve.address == "::";
  const std::string shown = everywhere && serve.name.empty() ? "localhost" : host;
  const char* const scheme = serve.tls.key.empty() ? "http" : "https";
  fmt::print("{}://{}:{}/#token={}\n", scheme, shown, port, serve.token);
  std::fflush(stdout);
  fmt::print(stderr,
             "serving {}; Ctrl+C ends it. The address has the token: whoever knows it can "
             "look.\nFrom another machine: ssh -L {}:{}:{} USER@THIS_MACHINE, then open "
             "{}://localhost:{}/#token={}\n",
             what, port, everywhere ? "localhost" : host_text(serve.address), port, scheme, port,
             serve.token);
}

}  // namespace qs
