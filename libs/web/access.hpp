#pragma once
// Who may see the page. On loop-back whoever is on this machine; from elsewhere who knows the token. Pages of
// other sites, which a browser on this machine may show, are neither: their Host or Origin tells.

#include <string>

#include <lcmslam/web/web_settings.hpp>

namespace lcmslam {

class Access {
 public:
  /// Throws std::runtime_error for an address that is none.
  explicit Access(const WebSettings& settings);

  /// What a request says of itself; empty: nothing.
  struct Request {
    std::string target;  ///< path and query
    std::string host, origin, cookie;
  };
  enum class Verdict { granted, wrong_host, wrong_origin, wrong_token };
  Verdict judge(const Request& request) const;
  /// Whether the address itself carries the token: then it is answered with a cookie.
  bool names_token(const Request& request) const;

  const std::string& token() const { return token_; }  ///< empty: none is asked for
  /// Named after the port that the browser asked: cookies are a host's, and another server may be on it.
  std::string cookie(const Request& request) const;

 private:
  bool is_own(const std::string& host) const;
  bool knows(const std::string& token) const;

  bool loop_back_;
  std::string token_;
};

/// As it stands in an address: "a/b" is "a%2Fb".
std::string query_value(const std::string& text);
/// Of "/path?a=1&token=a%2Fb", here "a/b"; empty: there is none.
std::string query_member(const std::string& target, const std::string& name);

}  // namespace lcmslam
