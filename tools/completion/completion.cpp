#include "tools/completion/completion.hpp"

#include <algorithm>

#include "tools/config/setting_sections.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

/// Commands of the script that builds and then calls this program.
const char* const script_commands = "bench build fuzz help mutate test";

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// What stands where a value is wanted: words, or the name of a kind that the script knows.
std::string values_of(const OptionDescription& option) {
  const auto has = [&](const char* part) { return option.type.find(part) != std::string::npos; };
  const auto named = [&](const char* name) {
    return std::find(option.names.begin(), option.names.end(), name) != option.names.end();
  };
  if (named("--set")) return "@settings";
  if (has("KEY")) return "@keys";
  if (has("SECTION")) return "@sections";
  if (!option.words.empty()) return joined(option.words);
  if (has("DIR")) return "@folders";
  if (has("FILE") || has("PATH") || named("--out")) return "@files";
  return "@nothing";
}

/// A command's `case` of each table: its options, and what follows each of them; positionals under "-".
void add_command(const std::string& name, const Command& command, std::string& options, std::string& values) {
  if (!command.below.empty()) {
    std::string names;
    for (const Command& below : command.below) {
      names += (names.empty() ? "" : " ") + std::string(below.name);
      add_command(name + " " + below.name, below, options, values);
    }
    options += "    '" + name + "') echo '" + names + " --help' ;;\n";
    return;
  }
  std::vector<std::string> names;
  std::string positional = "@nothing";
  for (const OptionDescription& option : describe_command(command.run)) {
    names.insert(names.end(), option.names.begin(), option.names.end());
    if (option.names.empty() && positional == "@nothing") {
      positional = values_of(option);
      if (positional == "@nothing") positional = "@files";
    }
    if (!option.takes_value || option.names.empty()) continue;
    std::string pattern;
    for (const std::string& option_name : option.names)
      pattern += (pattern.empty() ? "'" : " | '") + name + " " + option_name + "'";
    values += "    " + pattern + ") echo '" + values_of(option) + "' ;;\n";
  }
  values += "    '" + name + " -') echo '" + positional + "' ;;\n";
  options += "    '" + name + "') echo '" + joined(names) + "' ;;\n";
}

/// Shell functions that both shells read: they print what there is to choose from.
std::string tables() {
  std::string options, values, names, keys, choices, sections, with_below;
  for (const Command& command : commands()) {
    names += std::string(command.name) + " ";
    if (!command.below.empty()) with_below += (with_below.empty() ? "" : " | ") + std::string(command.name);
    add_command(command.name, command, options, values);
  }
  for (const SettingSection& section : setting_sections()) {
    sections += (sections.empty() ? "" : " ") + section.name;
    for (const SettingEntry& entry : section.entries) {
      keys += (keys.empty() ? "" : " ") + section.key(entry);
      std::string words = joined(entry.choices);
      if (entry.kind == "true or false") words = "true false";
      if (!words.empty() && entry.kind != "list of texts")
        choices += "    '" + section.key(entry) + "') echo '" + words + "' ;;\n";
    }
  }
  return "_lcmslam_commands() { echo '" + names + script_commands + "'; }\n" +
         "_lcmslam_has_below() { case $1 in " + with_below + ") true ;; *) false ;; esac }\n" +
         "_lcmslam_sections() { echo '" + sections + "'; }\n" + "_lcmslam_keys() { echo '" + keys + "'; }\n" +
         "_lcmslam_options() {  # COMMAND\n  case $1 in\n" + options + "  esac\n}\n" +
         "_lcmslam_values() {  # COMMAND OPTION\n  case \"$1 $2\" in\n" + values + "  esac\n}\n" +
         "_lcmslam_choices() {  # KEY\n  case $1 in\n" + choices + "  esac\n}\n";
}

// Bash cuts words at '=', so that --set a.b=c arrives as four of them.
const char* const bash_function = R"sh(
_lcmslam() {
  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} values
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W "$(_lcmslam_commands)" -- "$current"))
    return
  fi
  if [ "$COMP_CWORD" -gt 2 ] && _lcmslam_has_below "$command"; then command="$command ${COMP_WORDS[2]}"; fi
  if [ "$current" = = ] || [ "$before" = = ]; then
    local key=${COMP_WORDS[COMP_CWORD-2]}
    if [ "$current" = = ]; then key=$before current=; fi
    COMPREPLY=($(compgen -W "$(_lcmslam_choices "$key")" -- "$current"))
    return
  fi
  case $before in -*) values=$(_lcmslam_values "$command" "$before") ;; esac
  if [ -z "$values" ]; then
    case $current in
      -*) values=$(_lcmslam_options "$command") ;;
      *) values=$(_lcmslam_values "$command" -) ;;
    esac
    if [ -z "$values" ]; then values=$(_lcmslam_options "$command"); fi
  fi
  case $values in
    @settings) compopt -o nospace 2> /dev/null; COMPREPLY=($(compgen -S = -W "$(_lcmslam_keys)" -- "$current")) ;;
    @keys) COMPREPLY=($(compgen -W "$(_lcmslam_keys)" -- "$current")) ;;
    @sections) COMPREPLY=($(compgen -W "$(_lcmslam_sections)" -- "$current")) ;;
    @files) compopt -o filenames 2> /dev/null; COMPREPLY=($(compgen -f -- "$current")) ;;
    @folders) compopt -o filenames 2> /dev/null; COMPREPLY=($(compgen -d -- "$current")) ;;
    @nothing) ;;
    *) COMPREPLY=($(compgen -W "$values" -- "$current")) ;;
  esac
}
complete -F _lcmslam lcmslam ./lcmslam
)sh";

const char* const zsh_function = R"sh(
_lcmslam() {
  local current=${words[CURRENT]} before=${words[CURRENT-1]} command=${words[2]} values
  if (( CURRENT == 2 )); then
    compadd -- $(_lcmslam_commands)
    return
  fi
  if (( CURRENT > 3 )) && _lcmslam_has_below "$command"; then command="$command ${words[3]}"; fi
  if [[ $before == -* ]]; then values=$(_lcmslam_values "$command" "$before"); fi
  if [[ -z $values ]]; then
    if [[ $current == -* ]]; then values=$(_lcmslam_options "$command"); else values=$(_lcmslam_values "$command" -); fi
    if [[ -z $values ]]; then values=$(_lcmslam_options "$command"); fi
  fi
  case $values in
    @settings)
      if [[ $current == *=* ]]; then
        compset -P '*='
        compadd -- $(_lcmslam_choices "${current%%=*}")
      else
        compadd -S = -- $(_lcmslam_keys)
      fi ;;
    @keys) compadd -- $(_lcmslam_keys) ;;
    @sections) compadd -- $(_lcmslam_sections) ;;
    @files) _files ;;
    @folders) _files -/ ;;
    @nothing) ;;
    *) compadd -- ${=values} ;;
  esac
}
compdef _lcmslam lcmslam ./lcmslam
)sh";

}  // namespace

std::string completion_script(const std::string& shell) {
  const std::string head = "# Made by lcmslam completion " + shell + ".\n";
  return head + tables() + (shell == "zsh" ? zsh_function : bash_function);
}

}  // namespace lcmslam
