#include "drivers/network/address.h"

#include <gtest/gtest.h>

namespace palpate::drivers::network {
namespace {

constexpr Protocol kProtocol{"Some", "a server of some", "some://", 18944};

std::string server(std::string_view text) {
  const auto address = parse_server(text, kProtocol);
  return address ? address->text() : "refused";
}
std::string listen(std::string_view text, bool insecure = false) {
  const auto address = parse_listen(text, kProtocol, insecure);
  return address ? address->text() : "refused";
}

TEST(Address, OfAServer) {
  EXPECT_EQ(server("tracker.lab:1234"), "tracker.lab:1234");
  EXPECT_EQ(server("tracker.lab"), "tracker.lab:18944");
  EXPECT_EQ(server("[::1]:1234"), "[::1]:1234");
  EXPECT_EQ(server("::1"), "[::1]:18944");
  for (const char* bad :
       {"", ":1", "host:", "host:0", "host:65536", "host:12x", "*:1", "a b:1", "tcp://a:1", "[::1", "[::1]x"})
    EXPECT_EQ(server(bad), "refused") << bad;
}

TEST(Address, ToListenAtIsThisMachineUnlessAskedForAsInsecure) {
  EXPECT_EQ(listen("1234"), "127.0.0.1:1234");
  EXPECT_EQ(listen("localhost"), "127.0.0.1:18944");
  EXPECT_EQ(listen("0"), "127.0.0.1:0");
  EXPECT_EQ(listen("127.0.0.2:5"), "127.0.0.2:5");
  EXPECT_EQ(listen("[::1]:5"), "[::1]:5");
  for (const char* open : {"*:5", "0.0.0.0:5", "192.168.1.2:5", "[::]:5"}) {
    EXPECT_EQ(listen(open), "refused") << open;
    EXPECT_NE(parse_listen(open, kProtocol).error().message.find("--insecure"), std::string::npos);
    EXPECT_NE(listen(open, true), "refused") << open;
  }
  for (const char* bad : {"", "65536", "name.lab:5", "127.0.0.1:", "127.0.0.1:x"})
    EXPECT_EQ(listen(bad, true), "refused") << bad;
}

}  // namespace
}  // namespace palpate::drivers::network
