#include <iostream>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include "tools/commands.hpp"
#include "tools/output_file.hpp"
#include "tools/page/kept_page.hpp"
#include "tools/page/offline_page.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int export_command(int argc, char** argv) {
  std::string map, html;
  std::vector<std::string> sessions;
  bool force = false;
  CLI::App app{
      "Writes the live page of a kept map as one file that opens in any browser, offline. Files for other "
      "programs: `lcmslam map export`; of a running graph: `lcmslam send export`.",
      "lcmslam export"};
  app.add_option("map", map, "an .lcmslam file")->required();
  app.add_option("--html", html, "the file that is written")->required();
  app.add_option("--sessions", sessions,
                 "NAMES as `map info` has them, with commas between (all that were joined)")
      ->delimiter(',');
  app.add_flag("--force", force, "overwrite a file that exists");
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  check_output_file(html, force);
  Board board;
  const KeptPage page(map, sessions, nlohmann::json::array(), board);
  const std::string text = offline_page(share_path("page"), board);
  write_atomically(FilePlace(html), text);
  std::cout << html << "  " << (text.size() + 500'000) / 1'000'000 << " MB\n";
  return 0;
}

}  // namespace lcmslam
