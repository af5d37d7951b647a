#include <iostream>

#include "tools/commands.hpp"
#include "tools/config/check_file.hpp"
#include "tools/config/explain.hpp"
#include "tools/config/setting_sections.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int config_command(int argc, char** argv) {
  std::string section, key, file;
  std::vector<std::string> overrides;
  bool markdown = false;
  CLI::App app{"Says what can be configured, and whether a file says it right.", "lcmslam config"};
  const auto list = app.add_option("--list", section, "all keys of a section: default, unit, meaning, range");
  list->expected(0, 1)->type_name("SECTION");
  app.add_option("--explain", key, "everything about a key: icp.voxel_size, or voxel_size")->type_name("KEY");
  const auto check = app.add_option(
      "--check", file,
      "reads a graph, preset, scene, calibration or data set's description as the processes do");
  check->check(CLI::ExistingFile);
  app.add_option("--set", overrides, "with --check: override of the configuration, section.key=value")
      ->needs(check);
  app.add_flag("--markdown", markdown, "prints docs/CONFIGURATION.md");
  app.require_option(1, 2);
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  try {
    if (markdown) std::cout << configuration_page();
    if (list->count() > 0) std::cout << list_keys(section);
    if (!key.empty()) std::cout << explain_key(key);
    if (!file.empty()) {
      const std::string kind = check_file(file, overrides);
      const auto missing = kind == "a graph" ? missing_files(file, overrides) : std::vector<std::string>{};
      for (const std::string& line : missing) std::cerr << line << "\n";
      if (!missing.empty()) return 2;
      std::cout << file << ": ok, " << kind << "\n";
    }
    return 0;
  } catch (const ConfigError& error) {
    std::cerr << error.what() << "\n";
  } catch (const std::invalid_argument& error) {
    std::cerr << "lcmslam config: " << error.what() << "\n";
  }
  return 2;
}

}  // namespace lcmslam
