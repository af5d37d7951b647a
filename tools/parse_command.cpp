#include "tools/parse_command.hpp"

#include <lcmslam/runtime/version.hpp>

namespace lcmslam {
namespace {

/// Where describe_command() wants the next command's description.
std::vector<OptionDescription>* description = nullptr;

/// "TEXT:{a,b}" and CLI11's "TEXT:{a->1,b->2}" name words.
std::vector<std::string> words_of(const std::string& type) {
  const std::size_t open = type.find('{'), close = type.rfind('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  std::vector<std::string> words = CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
  for (std::string& word : words) word = word.substr(0, word.find("->"));
  return words;
}

std::vector<OptionDescription> options_of(const CLI::App& app) {
  std::vector<OptionDescription> options;
  for (const CLI::Option* option : app.get_options()) {
    OptionDescription d;
    for (const std::string& name : option->get_lnames()) d.names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) d.names.push_back("-" + name);
    d.help = option->get_description();
    d.takes_value = option->get_items_expected_max() > 0;
    d.type = option->get_type_name();
    d.words = words_of(d.type);
    options.push_back(std::move(d));
  }
  return options;
}

}  // namespace

std::optional<int> parse_command(CLI::App& app, int argc, char** argv) {
  app.set_version_flag("--version", std::string("lcmslam ") + lcmslam_version);
  if (description != nullptr) {
    *description = options_of(app);
    return 0;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return std::nullopt;
}

std::vector<OptionDescription> describe_command(int (*command)(int, char**)) {
  std::vector<OptionDescription> found;
  description = &found;
  char name[] = "lcmslam";
  char* argv[] = {name, nullptr};
  command(1, argv);
  description = nullptr;
  return found;
}

}  // namespace lcmslam
