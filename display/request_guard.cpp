#include "display/request_guard.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cctype>

namespace roseau::display {

namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

/// "localhost:8420" -> "localhost", "[::1]:8420" -> "::1".
std::string host_name(std::string_view host) {
  if (host.starts_with('[')) {
    const std::size_t end = host.find(']');
    return end == std::string_view::npos ? std::string() : lower(host.substr(1, end - 1));
  }
  return lower(host.substr(0, host.find(':')));
}

bool is_address(const std::string& name) {
  std::array<unsigned char, sizeof(in6_addr)> parsed{};
  return inet_pton(AF_INET, name.c_str(), parsed.data()) == 1 || inet_pton(AF_INET6, name.c_str(), parsed.data()) == 1;
}

bool is_loopback(const std::string& name) {
  in_addr address{};
  if (inet_pton(AF_INET, name.c_str(), &address) == 1) return (ntohl(address.s_addr) >> 24) == 127;
  return name == "localhost" || name == "::1";
}

}  // namespace

bool host_allowed(std::string_view host, std::string_view own_name) {
  const std::string name = host_name(host);
  if (name == "localhost" || is_address(name)) return true;
  const std::string own = lower(own_name);
  return !own.empty() && (name == own || name == own + ".local");
}

bool origin_may_act(std::string_view origin, std::string_view host) {
  if (origin.empty()) return true;
  static constexpr std::string_view kScheme = "http://";
  if (!origin.starts_with(kScheme)) return false;
  const std::string_view origin_host = origin.substr(kScheme.size());
  return lower(origin_host) == lower(host) || is_loopback(host_name(origin_host));
}

bool origin_may_watch(std::string_view origin, std::string_view host, std::span<const std::string> viewers) {
  if (origin_may_act(origin, host) || origin.starts_with("file://")) return true;
  return std::ranges::find(viewers, origin) != viewers.end();
}

}  // namespace roseau::display
