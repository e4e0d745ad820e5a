#include "palpate/web/web_guard.h"

#include <gtest/gtest.h>

namespace palpate::web {
namespace {

TEST(WebGuard, ReadsTheNameOfAHost) {
  EXPECT_EQ(host_name("Localhost:8765"), "localhost");
  EXPECT_EQ(host_name("127.0.0.1"), "127.0.0.1");
  EXPECT_EQ(host_name("[::1]:80"), "::1");
  EXPECT_EQ(host_name("[::1]"), "::1");
  for (const char* none : {"", "[::1", "a:b", "a:99999", "a:", "[::1]x"})
    EXPECT_EQ(host_name(none), "") << none;
  EXPECT_EQ(host_name(std::string(300, 'a')), "");
}

TEST(WebGuard, AnswersToItsOwnNamesAlone) {
  const WebGuard guard("127.0.0.1", {"Haptics.lab"}, {});
  for (const char* own :
       {"127.0.0.1:8765", "localhost:8765", "localhost", "[::1]:8765", "haptics.lab:1", "HAPTICS.LAB"})
    EXPECT_TRUE(guard.admits_host(own)) << own;
  for (const char* foreign : {"", "evil.example", "evil.example:8765", "127.0.0.1.evil.example",
                              "localhost.evil.example", "192.168.1.5:8765"})
    EXPECT_FALSE(guard.admits_host(foreign)) << foreign;
}

TEST(WebGuard, BeyondTheMachineANumberIsEnough) {
  const WebGuard guard("0.0.0.0", {WebGuard::kAnyNumber}, {});
  EXPECT_TRUE(guard.admits_host("192.168.1.5:8765"));
  EXPECT_TRUE(guard.admits_host("[fe80::1]:8765"));
  EXPECT_FALSE(guard.admits_host("evil.example"));
  EXPECT_FALSE(guard.admits_host("1.2.3.4.evil.example"));
}

TEST(WebGuard, AdmitsItsOwnPageAndThoseAllowed) {
  const WebGuard guard("127.0.0.1", {}, {"https://app.Foxglove.dev"});
  EXPECT_TRUE(guard.admits_origin("", "localhost:8765"));  // no browser
  EXPECT_TRUE(guard.admits_origin("http://localhost:8765", "localhost:8765"));
  EXPECT_TRUE(guard.admits_origin("http://localhost:9000", "localhost:9000"));  // a tunnel's other end
  EXPECT_TRUE(guard.admits_origin("https://app.foxglove.dev", "localhost:8765"));
  for (const char* foreign :
       {"null", "http://evil.example", "https://localhost:8765", "http://localhost:3000",
        "http://127.0.0.1:8765", "http://localhost:8765.evil.example", "file://"})
    EXPECT_FALSE(guard.admits_origin(foreign, "localhost:8765")) << foreign;
  // A name that is pointed here has an origin that fits its host.
  EXPECT_FALSE(guard.admits_origin("http://evil.example", "evil.example"));
}

TEST(WebGuard, KnowsALoopbackAddress) {
  for (const char* own : {"127.0.0.1", "127.1.2.3", "::1", "localhost"}) EXPECT_TRUE(is_loopback(own)) << own;
  for (const char* wide : {"0.0.0.0", "192.168.1.5", "::", "127.0.0.1.evil.example", "127.x"})
    EXPECT_FALSE(is_loopback(wide)) << wide;
}

}  // namespace
}  // namespace palpate::web
