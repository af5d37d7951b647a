#include "tools/page/page_host.hpp"

#include <iostream>
#include <thread>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include <lcmslam/web/web_server.hpp>

namespace lcmslam {

void add_page_options(CLI::App& app, WebSettings& settings) {
  app.add_option("--port", settings.port, "of the page; 0: any that is free (8642)")
      ->check(CLI::Range(0, 65535));
  app.add_option(
      "--address", settings.address,
      "of this machine on which it is served (127.0.0.1: for this machine alone); others ask for a "
      "token, which is printed");
}

void host_page(const WebSettings& settings, Board& board, PageDesk& desk, const std::function<void()>& turn) {
  install_stop_signals(0);
  WebServer::Handlers handlers;
  handlers.command = [&](std::uint64_t who, const std::string& request, const WebServer::Reply& reply) {
    desk.take(who, request, reply);
  };
  handlers.closed = [&](std::uint64_t who) { desk.gone(who); };
  const WebServer server(settings, share_path("page"), board, handlers);
  std::cout << server.address() << "  (Ctrl-C ends it)" << std::endl;
  while (!stop_requested()) {
    desk.serve();
    turn();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace lcmslam
