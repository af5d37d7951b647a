#pragma once
#include <string>

#include <lcmslam/settings/settings.hpp>

namespace lcmslam {

/// Where pages are served, and to whom.
struct WebSettings {
  std::string address = "127.0.0.1";
  int port = 8642;
  std::string token;
  int most_clients = 32;
  double patience = 20;

  void describe(SettingsVisitor& s) {
    s.text("address", address,
           "of this machine on which the page is served: 127.0.0.1 is for this machine alone, 0.0.0.0 for "
           "everyone who reaches it and knows the token");
    s.number("port", port, "", {0, 65535}, "0: any that is free");
    s.text("token", token,
           "that browsers must know; empty: beyond 127.0.0.1 one is made and printed at each start");
    s.number("most_clients", most_clients, "", {1, 1000}, "browsers at a time");
    s.number("patience", patience, "s", {1, 600}, "with a browser that takes nothing; then it is let go");
  }
};

}  // namespace lcmslam
