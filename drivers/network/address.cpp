#include "drivers/network/address.h"

#include <arpa/inet.h>

#include <algorithm>
#include <charconv>

#include "palpate/core/text.h"

namespace palpate::drivers::network {
namespace {

constexpr std::size_t kLongestHost = 253;  // of a domain name

bool host_is_good(std::string_view host) {
  return !host.empty() && host.size() <= kLongestHost && std::all_of(host.begin(), host.end(), [](char c) {
    return c > ' ' && c < 127 && c != '/' && c != '@';
  });
}

bool read_port(std::string_view text, std::uint16_t& port) {
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), port);
  return code == std::errc() && end == text.data() + text.size();
}

// "host:port", "[::1]:port", "host", "::1"; empty host or false where it is none of these.
bool split(std::string_view text, std::string_view& host, std::string_view& port) {
  if (text.starts_with('[')) {
    const auto end = text.find(']');
    if (end == std::string_view::npos) return false;
    host = text.substr(1, end - 1);
    text.remove_prefix(end + 1);
    if (!text.empty() && !text.starts_with(':')) return false;
    port = text.empty() ? text : text.substr(1);
    return text.size() != 1;
  }
  const auto colon = text.find(':');
  const bool one_colon =
      colon != std::string_view::npos && text.find(':', colon + 1) == std::string_view::npos;
  host = one_colon ? text.substr(0, colon) : text;
  port = one_colon ? text.substr(colon + 1) : std::string_view();
  return !one_colon || !port.empty();
}

}  // namespace

std::string Address::text() const {
  return host.find(':') == std::string::npos ? fmt::format("{}:{}", host, port)
                                             : fmt::format("[{}]:{}", host, port);
}

Expected<Address> parse_server(std::string_view text, const Protocol& protocol) {
  std::string_view host, port_text;
  Address address{"", protocol.default_port};
  if (!split(text, host, port_text) || !host_is_good(host) || host == "*" ||
      (!port_text.empty() && (!read_port(port_text, address.port) || address.port == 0)))
    return wrong_use("'{}': the address HOST:PORT of {}, with a port from 1 to 65535, is expected",
                     excerpt(text, 100), protocol.server);
  address.host = std::string(host);
  return address;
}

Expected<Address> parse_listen(std::string_view text, const Protocol& protocol, bool insecure,
                               std::string_view flag) {
  std::string_view host, port_text;
  Address address{"127.0.0.1", protocol.default_port};
  const bool only_port =
      !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  bool good = only_port ? read_port(text, address.port)
                        : split(text, host, port_text) && host_is_good(host) &&
                              (port_text.empty() || read_port(port_text, address.port));
  if (good && !only_port)
    address.host = host == "localhost" ? "127.0.0.1" : host == "*" ? "0.0.0.0" : std::string(host);
  in_addr v4{};
  in6_addr v6{};
  const bool is_v4 = good && inet_pton(AF_INET, address.host.c_str(), &v4) == 1;
  const bool is_v6 = good && !is_v4 && inet_pton(AF_INET6, address.host.c_str(), &v6) == 1;
  if (!is_v4 && !is_v6)
    return wrong_use(
        "'{}': PORT or HOST:PORT to listen at is expected, HOST localhost, * or the number of an interface",
        excerpt(text, 100));
  const bool loopback = is_v4 ? (ntohl(v4.s_addr) >> 24) == 127 : IN6_IS_ADDR_LOOPBACK(&v6);
  if (!loopback && !insecure)
    return wrong_use(
        "{}: {} protects nothing, anyone who reaches this address sees the poses; use 127.0.0.1 "
        "(and a tunnel), or take the risk with {}",
        address.text(), protocol.name, flag);
  return address;
}

}  // namespace palpate::drivers::network
