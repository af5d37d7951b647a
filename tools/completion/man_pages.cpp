#include "tools/completion/man_pages.hpp"

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/runtime/version.hpp>
#include "tools/command_description.hpp"
#include "tools/commands.hpp"

namespace lcmslam {
namespace {

/// Text as roff shows it unchanged.
std::string roff(const std::string& text) {
  std::string escaped;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\')
      escaped += "\\e";
    else if (c == '-')
      escaped += "\\-";
    else
      escaped += c;
    line_begins = c == '\n';
  }
  return escaped;
}

std::string head(const std::string& name, const std::string& help) {
  return ".TH " + roff(name) + " 1 \"\" \"lcmslam " + lcmslam_version + "\" \"lcmslam\"\n.SH NAME\n" +
         roff(name) + " \\- " + roff(help) + "\n";
}

std::string synopsis(const std::string& words, const CommandDescription& d) {
  std::string line = ".B " + roff(words) + "\n[OPTIONS]";
  for (const PositionalDescription& p : d.positionals) {
    const std::string name = "\\fI" + roff(p.name) + "\\fR" + (p.many ? "..." : "");
    line += " " + (p.required ? name : "[" + name + "]");
  }
  return ".SH SYNOPSIS\n" + line + "\n";
}

std::string entry(const std::string& title, const std::string& help) {
  return ".TP\n" + title + "\n" + roff(help) + "\n";
}

std::string options(const CommandDescription& d) {
  std::string text = ".SH OPTIONS\n";
  std::size_t positional = 0;
  for (const OptionDescription& option : d.options) {
    std::string title;
    for (const std::string& name : option.names)
      title += (title.empty() ? "\\fB" : ", \\fB") + roff(name) + "\\fR";
    while (positional < d.positionals.size() && d.positionals[positional].named) ++positional;
    if (option.names.empty() && positional < d.positionals.size())
      title = "\\fI" + roff(d.positionals[positional++].name) + "\\fR";
    else if (option.takes_value && option.words.empty())
      title += " " + roff(option.type.substr(0, option.type.find(':')));
    for (std::size_t i = 0; i < option.words.size(); ++i)
      title += (i == 0 ? " " : "|") + roff(option.words[i]);
    text += entry(title, option.help);
  }
  return text;
}

const char* const see_also =
    ".SH SEE ALSO\n.BR lcmslam (1).\nEvery configuration key: \\fBlcmslam config \\-\\-list\\fR.\n";

std::string page_of(const std::string& words, const Command& command) {
  const CommandDescription d = describe_whole_command(command.run);
  std::string name = words;
  for (char& c : name)
    if (c == ' ') c = '-';
  std::string text =
      head(name, command.help) + synopsis(words, d) + ".SH DESCRIPTION\n" + roff(d.text) + "\n" + options(d);
  if (!d.footer.empty()) text += ".SH NOTES\n" + roff(d.footer) + "\n";
  return text + ".SH EXIT STATUS\n0 when all went well, 1 when not, 2 for what was typed wrong.\n" + see_also;
}

void add_pages(const std::string& words, const Command& command, std::map<std::string, std::string>& pages) {
  std::string name = words;
  for (char& c : name)
    if (c == ' ') c = '-';
  if (command.below.empty()) {
    pages[name + ".1"] = page_of(words, command);
    return;
  }
  std::string text = head(name, command.help) + ".SH SYNOPSIS\n.B " + roff(words) +
                     "\nSUBCOMMAND [OPTIONS]\n.SH SUBCOMMANDS\n";
  for (const Command& below : command.below) {
    add_pages(words + " " + below.name, below, pages);
    text += entry("\\fB" + roff(name + "-" + below.name) + "\\fR(1)", below.help);
  }
  pages[name + ".1"] = text + see_also;
}

}  // namespace

std::map<std::string, std::string> man_pages() {
  std::map<std::string, std::string> pages;
  std::string text =
      head("lcmslam", "maps from colour, depth and wheels with two SLAM methods") +
      ".SH SYNOPSIS\n.B lcmslam\nCOMMAND [OPTIONS]\n.SH DESCRIPTION\n" +
      "FastSLAM over SURF landmarks and 6\\-D SLAM by registration run side by side on LCM messages.\n"
      ".SH COMMANDS\n";
  for (const Command& command : commands()) {
    add_pages(std::string("lcmslam ") + command.name, command, pages);
    text += entry(std::string("\\fBlcmslam\\-") + roff(command.name) + "\\fR(1)", command.help);
  }
  text +=
      ".SH ENVIRONMENT\n" + entry("\\fBLCM_DEFAULT_URL\\fR", "the bus, where --lcm-url does not name one") +
      entry("\\fBLCMSLAM_BUS_ALLOW\\fR",
            "other machines that may send: addresses and networks, with commas between") +
      entry("\\fBLCMSLAM_BUS_KEY\\fR",
            "file with the key of the bus: 64 hexadecimal digits; only messages sealed by it are taken") +
      entry("\\fBLCMSLAM_BUS_MEMORY\\fR", "MiB that half messages of the bus may take; 32 without it") +
      entry("\\fBLCMSLAM_ROBOT\\fR",
            "whose channels a tool or process takes and sends, where several robots share a bus") +
      entry("\\fBLCMSLAM_SHARE\\fR", "folder of config, logs and so on, in the place of the installed one") +
      entry("\\fBNO_COLOR\\fR", "no colours, also in a terminal");
  pages["lcmslam.1"] = text;
  return pages;
}

void write_man_pages(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  for (const auto& [name, text] : man_pages()) write_atomically(folder / name, text);
}

}  // namespace lcmslam
