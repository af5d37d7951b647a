#include <lcmslam/web/access.hpp>

#include <arpa/inet.h>
#include <sodium.h>
#include <cctype>
#include <stdexcept>

namespace lcmslam {
namespace {

constexpr std::size_t shortest_token = 8;

bool is_address(const std::string& text) {
  in6_addr ignored{};
  return inet_pton(AF_INET, text.c_str(), &ignored) == 1 || inet_pton(AF_INET6, text.c_str(), &ignored) == 1;
}

bool is_loop_back(const std::string& address) {
  return is_address(address) && (address.rfind("127.", 0) == 0 || address == "::1");
}

std::string random_token() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium has no source of random numbers");
  unsigned char bytes[16];
  randombytes_buf(bytes, sizeof(bytes));
  char text[2 * sizeof(bytes) + 1];
  sodium_bin2hex(text, sizeof(text), bytes, sizeof(bytes));
  return text;
}

/// "robot:8642" -> "robot", "[::1]:8642" -> "::1".
std::string name_of(const std::string& host) {
  if (!host.empty() && host.front() == '[') return host.substr(1, host.find(']') - 1);
  return host.substr(0, host.find(':'));
}

std::string cookie_name(const std::string& host) {
  const std::size_t colon = host.rfind(':');
  const std::string port = colon == std::string::npos ? "" : host.substr(colon + 1);
  const bool is_port = !port.empty() && port.find_first_not_of("0123456789") == std::string::npos;
  return "lcmslam_token_" + (is_port ? port : "80");
}

std::string cookie_member(const std::string& cookies, const std::string& name) {
  for (std::size_t at = 0; at < cookies.size();) {
    const std::size_t end = std::min(cookies.find(';', at), cookies.size());
    while (at < end && cookies[at] == ' ') ++at;
    if (cookies.compare(at, name.size() + 1, name + "=") == 0)
      return cookies.substr(at + name.size() + 1, end - at - name.size() - 1);
    at = end + 1;
  }
  return "";
}

constexpr char digits[] = "0123456789ABCDEF";

/// Browsers write what means something in addresses as %2F.
std::string decoded(const std::string& text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned char byte = 0;
    std::size_t size = 0;
    const bool is_code = text[i] == '%' && i + 2 < text.size() &&
                         sodium_hex2bin(&byte, 1, &text[i + 1], 2, nullptr, &size, nullptr) == 0 && size == 1;
    plain += is_code ? static_cast<char>(byte) : text[i];
    if (is_code) i += 2;
  }
  return plain;
}

}  // namespace

std::string query_value(const std::string& text) {
  std::string coded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || std::string("-._~").find(c) != std::string::npos)
      coded += c;
    else
      coded.append({'%', digits[byte >> 4], digits[byte & 15]});
  }
  return coded;
}

std::string query_member(const std::string& target, const std::string& name) {
  std::size_t at = target.find('?');
  while (at != std::string::npos) {
    const std::size_t end = std::min(target.find('&', at + 1), target.size());
    if (target.compare(at + 1, name.size() + 1, name + "=") == 0)
      return decoded(target.substr(at + name.size() + 2, end - at - name.size() - 2));
    at = end == target.size() ? std::string::npos : end;
  }
  return "";
}

Access::Access(const WebSettings& settings)
    : loop_back_(is_loop_back(settings.address)), token_(settings.token) {
  if (!is_address(settings.address))
    throw std::runtime_error("address: '" + settings.address +
                             "' is no address of this machine, such as 127.0.0.1 or 0.0.0.0");
  if (token_.find_first_of(" ;&,\"\\") != std::string::npos)
    throw std::runtime_error("token: must be without spaces and without ; & , \" and \\");
  if (!token_.empty() && token_.size() < shortest_token)
    throw std::runtime_error("token: must have at least " + std::to_string(shortest_token) +
                             " characters, so that nobody finds it by trying; empty: one is made");
  if (token_.empty() && !loop_back_) token_ = random_token();
}

/// Names of this machine: a foreign site's name may lead here, too (DNS rebinding). From elsewhere this
/// machine has names that it does not know itself; there the token decides.
bool Access::is_own(const std::string& host) const {
  const std::string name = name_of(host);
  return !loop_back_ || name == "localhost" || is_loop_back(name);
}

bool Access::knows(const std::string& token) const {
  return token.size() == token_.size() && sodium_memcmp(token.data(), token_.data(), token_.size()) == 0;
}

bool Access::names_token(const Request& request) const {
  return !token_.empty() && knows(query_member(request.target, "token"));
}

std::string Access::cookie(const Request& request) const {
  return cookie_name(request.host) + "=" + token_;
}

Access::Verdict Access::judge(const Request& request) const {
  if (!is_own(request.host)) return Verdict::wrong_host;
  if (!request.origin.empty() && request.origin != "http://" + request.host &&
      request.origin != "https://" + request.host)
    return Verdict::wrong_origin;
  const bool is_known = token_.empty() || names_token(request) ||
                        knows(cookie_member(request.cookie, cookie_name(request.host)));
  return is_known ? Verdict::granted : Verdict::wrong_token;
}

}  // namespace lcmslam
