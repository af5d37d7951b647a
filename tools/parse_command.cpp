#include "tools/parse_command.hpp"

#include <lcmslam/runtime/version.hpp>

namespace lcmslam {

std::optional<int> parse_command(CLI::App& app, int argc, char** argv) {
  app.set_version_flag("--version", std::string("lcmslam ") + lcmslam_version);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return std::nullopt;
}

}  // namespace lcmslam
