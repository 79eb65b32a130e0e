// SPDX-License-Identifier: MIT
//
// The rules for requests, the token and the flow of pictures, without sockets.
#include "app/serve/requests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/assets.h"

namespace qs {
namespace {

const HostNames& names() {
  static const HostNames kNames("10.1.2.3", "GPU7.example.org");
  return kNames;
}

unsigned status(RequestHead head) { return status_of(head, "http", names(), 1024); }

TEST(ServeRequests, the_page_consists_of_files_that_are_there) {
  for (const PageFile& file : page_files()) {
    EXPECT_TRUE(find_asset(file.asset)) << file.asset;
    EXPECT_EQ(status({"GET", file.target, {"localhost:7007"}, {}, false}), 200u);
  }
  EXPECT_EQ(page_file("/page.js?x"), nullptr);
}

TEST(ServeRequests, no_other_path_is_served) {
  for (const char* target : {"/../../etc/passwd", "//page.js", "/assets/plush.ply", "/live", "*",
                             "/page.js%00", "http://localhost/page.js", ""}) {
    EXPECT_EQ(status({"GET", target, {"localhost"}, {}, false}), 404u) << target;
  }
}

TEST(ServeRequests, methods_targets_and_hosts_are_checked) {
  EXPECT_EQ(status({"POST", "/", {"localhost"}, {}, false}), 405u);
  EXPECT_EQ(status({"HEAD", "/", {"localhost"}, {}, false}), 405u);
  EXPECT_EQ(status({"GET", "/" + std::string(1024, 'x'), {"localhost"}, {}, false}), 414u);
  EXPECT_EQ(status({"GET", "/" + std::string(1023, 'x'), {"localhost"}, {}, false}), 404u);
  EXPECT_EQ(status({"GET", "/", {}, {}, false}), 400u);
  EXPECT_EQ(status({"GET", "/", {"localhost", "localhost"}, {}, false}), 400u);
  for (const char* damaged :
       {"", ":7007", "local host", "localhost:", "localhost:x", "localhost:123456", "a@localhost",
        "[::1", "[]", "[x]", "localhost/..", "[::1]x"}) {
    EXPECT_EQ(status({"GET", "/", {damaged}, {}, false}), 400u) << damaged;
  }
  for (const char* own : {"localhost", "LOCALHOST:8080", "127.0.0.1:1", "[::1]:7007",
                          "10.1.2.3:7007", "gpu7.example.org"}) {
    EXPECT_EQ(status({"GET", "/", {own}, {}, false}), 200u) << own;
  }
  for (const char* foreign : {"evil.example", "127.0.0.1.evil.example", "localhost.evil.example",
                              "xlocalhost", "0.0.0.0", "[::2]"}) {
    EXPECT_EQ(status({"GET", "/", {foreign}, {}, false}), 403u) << foreign;
  }
}

TEST(ServeRequests, a_socket_opens_for_the_own_page_only) {
  const auto upgrade = [](std::vector<std::string> origins) {
    return status({"GET", "/live", {"localhost:7007"}, std::move(origins), true});
  };
  EXPECT_EQ(upgrade({"http://localhost:7007"}), 101u);
  EXPECT_EQ(upgrade({}), 403u);
  for (const char* foreign :
       {"null", "", "http://evil.example", "http://localhost:70070", "http://localhost:700",
        "https://localhost:7007", "http://localhost", "http://127.0.0.1:7007"}) {
    EXPECT_EQ(upgrade({foreign}), 403u) << foreign;
  }
  EXPECT_EQ(upgrade({"http://localhost:7007", "http://localhost:7007"}), 403u);
  EXPECT_EQ(status({"GET", "/", {"localhost"}, {"http://localhost"}, true}), 404u);
  const auto encrypted = [](const char* origin) {
    return status_of({"GET", "/live", {"localhost:7007"}, {origin}, true}, "https", names(), 1024);
  };
  EXPECT_EQ(encrypted("https://localhost:7007"), 101u);
  EXPECT_EQ(encrypted("http://localhost:7007"), 403u);
}

TEST(ServeRequests, hosts_of_any_ipv6_address_have_brackets) {
  const HostNames everywhere("::", "");
  EXPECT_TRUE(everywhere.has("[::]:7007"));
  EXPECT_FALSE(everywhere.has("::"));
}

TEST(ServeToken, tokens_are_long_and_differ) {
  const std::string token = make_token();
  EXPECT_THAT(token, testing::MatchesRegex("[0-9a-f]{32}"));
  EXPECT_NE(token, make_token());
  EXPECT_TRUE(same_token(token, std::string(token)));
  EXPECT_FALSE(same_token(token, ""));
  EXPECT_FALSE(same_token(token, token + "0"));
  EXPECT_FALSE(same_token(token, token.substr(1)));
  std::string other = token;
  other.back() = other.back() == '0' ? '1' : '0';
  EXPECT_FALSE(same_token(token, other));
}

}  // namespace
}  // namespace qs
