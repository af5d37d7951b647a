#include <lcmslam/configuration/share.hpp>
#include "tools/log/log_commands.hpp"
#include "tools/page/log_page.hpp"
#include "tools/page/page_host.hpp"

namespace lcmslam {

int log_view_command(int argc, char** argv) {
  std::string file, config;
  WebSettings web;
  CLI::App app{
      "Shows a log in a browser, with a time slider. What the log lacks of the mappers is made meanwhile.",
      "lcmslam log view"};
  app.add_option("log", file, "an .lcmlog file")->required();
  app.add_option("--config", config, "of the mappers, for a log with raw data alone (config/replay.yaml)");
  add_page_options(app, web);
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (config.empty()) config = share_path("config/replay.yaml").string();
  const ConfigNode processes = ConfigNode::load(config);
  Board board;
  LogPage page(file, processes, board);
  PageDesk desk;
  page.offer(desk);
  host_page(web, board, desk, [&] {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    page.play(std::chrono::duration<double>(now).count());
  });
  return 0;
}

}  // namespace lcmslam
