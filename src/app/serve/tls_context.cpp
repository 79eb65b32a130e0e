// SPDX-License-Identifier: MIT
// Compiled alone: it has a macro of its own.
#include "app/serve/tls_context.h"

#ifdef QUADSPLAT_TLS
#include <cstddef>
#include <ctime>

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <openssl/x509err.h>

#include "io/bytes/json_text.h"
#endif

#include "base/fail.h"

namespace qs {

#ifndef QUADSPLAT_TLS

TlsContext make_tls_context(const TlsFiles&, const std::string& command) {
  fail(ErrorKind::device,
       "{}: --certificate: this program was built without OpenSSL: install libssl-dev and build it "
       "again",
       command);
}
std::string certificate_problem(const TlsContext&) { return {}; }

#else

namespace {

namespace ssl = boost::asio::ssl;
using boost::system::error_code;

constexpr std::size_t kMostBytes = 1 << 20;  ///< of a file

// A file of PEM blocks, of which one is `block`: `what`. `who`: the command and the option.
std::string pem_of(const std::string& who, const std::filesystem::path& path, const char* block,
                   const char* what) {
  std::string pem;
  try {
    pem = read_text_file(path, kMostBytes);
  } catch (const Error& error) {
    fail("{} {}", who, error.what());
  }
  const std::size_t begin = pem.find("-----BEGIN ");
  if (begin == pem.npos || pem.find(block, begin) == pem.npos)
    fail("{} {}: has no {} in PEM format", who, path.string(), what);
  return pem;
}

void use_certificate(ssl::context& context, const TlsFiles& files, const std::string& command) {
  const std::string who = command + ": --certificate";
  const std::string pem = pem_of(who, files.certificate, "CERTIFICATE-----", "certificate");
  error_code error;
  context.use_certificate_chain(boost::asio::buffer(pem), error);
  if (error)
    fail("{} {}: OpenSSL refuses it: {}", who, files.certificate.string(), error.message());
}

void use_key(ssl::context& context, const TlsFiles& files, const std::string& command) {
  const std::string who = command + ": --key", path = files.key.string();
  const std::string pem = pem_of(who, path, "PRIVATE KEY-----", "private key");
  SSL_CTX* const handle = context.native_handle();
  bool is_encrypted = false;
  SSL_CTX_set_default_passwd_cb(handle, [](char*, int, int, void* asked) {
    *static_cast<bool*>(asked) = true;
    return 0;
  });
  SSL_CTX_set_default_passwd_cb_userdata(handle, &is_encrypted);
  error_code error;
  context.use_private_key(boost::asio::buffer(pem), ssl::context::pem, error);
  SSL_CTX_set_default_passwd_cb(handle, nullptr);  // the context outlives the flag
  SSL_CTX_set_default_passwd_cb_userdata(handle, nullptr);
  if (is_encrypted)
    fail("{0} {1}: has a password; remove it: openssl pkey -in {1} -out NEW.pem", who, path);
  const bool is_mismatch =
      ERR_GET_REASON(static_cast<unsigned long>(error.value())) == X509_R_KEY_VALUES_MISMATCH ||
      (!error && SSL_CTX_check_private_key(handle) != 1);
  if (is_mismatch) fail("{} {}: is not the key of {}", who, path, files.certificate.string());
  if (error) fail("{} {}: OpenSSL refuses it: {}", who, path, error.message());
}

std::string date_of(const ASN1_TIME* time) {
  std::tm date{};
  ASN1_TIME_to_tm(time, &date);
  return fmt::format("{:04}-{:02}-{:02}", date.tm_year + 1900, date.tm_mon + 1, date.tm_mday);
}

}  // namespace

TlsContext make_tls_context(const TlsFiles& files, const std::string& command) {
  ssl::context context(ssl::context::tls_server);
  SSL_CTX* const handle = context.native_handle();
  SSL_CTX_set_min_proto_version(handle, TLS1_2_VERSION);
  SSL_CTX_set_options(handle, SSL_OP_NO_RENEGOTIATION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  SSL_CTX_set_mode(handle, SSL_MODE_RELEASE_BUFFERS);  // of connections at rest
  SSL_CTX_set_session_cache_mode(handle, SSL_SESS_CACHE_OFF);
  use_certificate(context, files, command);
  use_key(context, files, command);
  ERR_clear_error();  // an old error would end the first connection
  return context;
}

std::string certificate_problem(const TlsContext& context) {
  // OpenSSL has no constant access to a context.
  const X509* const certificate =
      SSL_CTX_get0_certificate(const_cast<TlsContext&>(context).native_handle());
  if (certificate == nullptr) return {};
  const ASN1_TIME* const begin = X509_get0_notBefore(certificate);
  const ASN1_TIME* const end = X509_get0_notAfter(certificate);
  // X509_cmp_current_time() is 0 for a time that it cannot read.
  if (X509_cmp_current_time(end) < 0) return "has expired on " + date_of(end);
  return X509_cmp_current_time(begin) > 0 ? "is not valid before " + date_of(begin) : "";
}

#endif

}  // namespace qs
