#include "palpate/web/web_guard.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace palpate::web {
namespace {

std::string in_lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return lower;
}

bool is_port(std::string_view text) {
  unsigned port = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), port);
  return failure == std::errc() && end == text.data() + text.size() && port <= 65535;
}

bool is_number(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> address{};
  return ::inet_pton(AF_INET, host.c_str(), address.data()) == 1 ||
         ::inet_pton(AF_INET6, host.c_str(), address.data()) == 1;
}

bool holds(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::string host_name(std::string_view host) {
  if (host.empty() || host.size() > 255) return {};
  std::string_view name = host, port;
  if (host.front() == '[') {
    const auto end = host.find(']');
    if (end == std::string_view::npos) return {};
    name = host.substr(1, end - 1), port = host.substr(end + 1);
  } else if (const auto colon = host.find(':'); colon != std::string_view::npos) {
    name = host.substr(0, colon), port = host.substr(colon);
  }
  if (!port.empty() && (port.front() != ':' || !is_port(port.substr(1)))) return {};
  return in_lower_case(name);
}

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" || (host.starts_with("127.") && is_number(std::string(host)));
}

WebGuard::WebGuard(std::string_view address, std::vector<std::string> hosts, std::vector<std::string> origins)
    : hosts_(std::move(hosts)), origins_(std::move(origins)) {
  for (auto& host : hosts_) host = in_lower_case(host);
  for (auto& origin : origins_) origin = in_lower_case(origin);
  hosts_.push_back(in_lower_case(address));
  if (is_loopback(address)) hosts_.insert(hosts_.end(), {"localhost", "127.0.0.1", "::1"});
}

bool WebGuard::admits_host(std::string_view host) const {
  const auto name = host_name(host);
  return !name.empty() && (holds(hosts_, name) || (holds(hosts_, kAnyNumber) && is_number(name)));
}

bool WebGuard::admits_origin(std::string_view origin, std::string_view host) const {
  if (origin.empty()) return true;
  const auto said = in_lower_case(origin);
  return holds(origins_, said) || (admits_host(host) && said == "http://" + in_lower_case(host));
}

}  // namespace palpate::web
