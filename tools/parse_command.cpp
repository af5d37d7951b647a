#include "tools/parse_command.hpp"

#include <iostream>

#include <lcmslam/configuration/nearest_word.hpp>
#include <lcmslam/runtime/version.hpp>
#include "tools/command_description.hpp"

namespace lcmslam {
namespace {

/// Where describe_command() wants the next command's description.
CommandDescription* description = nullptr;

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

CommandDescription description_of(const CLI::App& app) {
  CommandDescription d;
  d.text = app.get_description();
  d.footer = app.get_footer();
  d.options = options_of(app);
  for (const CLI::Option* option : app.get_options())
    if (option->get_positional())
      d.positionals.push_back({option->get_name(true), option->get_required(),
                               option->get_items_expected_max() > 1, option->nonpositional()});
  return d;
}

/// What was typed that the command does not take, and what may have been meant.
void tell_extras(const CLI::App& app) {
  std::vector<std::string> names;
  for (const OptionDescription& option : options_of(app))
    names.insert(names.end(), option.names.begin(), option.names.end());
  for (const std::string& extra : app.remaining()) {
    std::cerr << app.get_name() << ": ";
    if (extra.rfind('-', 0) != 0) {
      std::cerr << "'" << extra << "' is more than it takes; --help says what it takes\n";
      return;
    }
    const std::string name = extra.substr(0, extra.find('='));
    std::cerr << "unknown option " << name << did_you_mean(name, names) << "; --help lists them\n";
  }
}

}  // namespace

std::optional<int> parse_command(CLI::App& app, int argc, char** argv) {
  app.set_version_flag("--version", std::string("lcmslam ") + lcmslam_version);
  if (description != nullptr) {
    *description = description_of(app);
    return 0;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    tell_extras(app);
    return 2;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return std::nullopt;
}

CommandDescription describe_whole_command(int (*command)(int, char**)) {
  CommandDescription found;
  description = &found;
  char name[] = "lcmslam";
  char* argv[] = {name, nullptr};
  command(1, argv);
  description = nullptr;
  return found;
}

std::vector<OptionDescription> describe_command(int (*command)(int, char**)) {
  return describe_whole_command(command).options;
}

}  // namespace lcmslam
