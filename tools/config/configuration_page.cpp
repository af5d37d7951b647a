#include <algorithm>

#include "tools/config/setting_sections.hpp"

namespace lcmslam {
namespace {

const char* const introduction = R"(# Configuration

This page is made by `./lcmslam config --markdown > docs/CONFIGURATION.md` from what the settings say of
themselves; a test fails when it is stale.

A configuration is a YAML file with a section for each process and `launch`, which names the processes that run.
Every key has a default: an empty section is a good section. A key that does not exist and a value that is wrong
are errors that name the file, the line and what would be right.

- `include: other.yaml` (a file, or a list of files, relative to this one) takes over what another file says; this
  file's own keys win. A path beside a driver or a scene is relative to the file that says it. An empty
  section sets nothing and takes nothing away. `config/modern.yaml` and `config/thesis.yaml` are the presets that others include.
- `--set section.key=value` on the command line wins over the file; a path in it is relative to the current folder.
- `./lcmslam config --list SECTION` prints one of the tables below, `--explain KEY` everything about one key,
  `--check FILE` reads a file as the processes do. `source <(./lcmslam completion bash)` completes keys.

What belongs to a sensor or a robot stands with its calibration (`config/calibration`) or data set
(`config/datasets`) and not in a preset. Units are SI; angles are radians.
)";

/// In a cell of a table.
std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2))
    text.insert(at, "\\");
  return text;
}

}  // namespace

std::string configuration_page() {
  std::string page = introduction;
  for (const SettingSection& section : setting_sections()) {
    page += "\n## " + section.name + "\n\n" + section.meaning + ".\n\n";
    page += "| key | default | unit | must be | meaning |\n|---|---|---|---|---|\n";
    for (const SettingEntry& entry : section.entries)
      page += "| `" + entry.path + "` | " + cell(section.defaults(entry)) + " | " + cell(entry.unit) + " | " +
              cell(allowed(entry)) + " | " + cell(entry.meaning) + " |\n";
  }
  return page;
}

}  // namespace lcmslam
