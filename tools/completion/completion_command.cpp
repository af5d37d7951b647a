#include <iostream>

#include "tools/commands.hpp"
#include "tools/completion/completion.hpp"
#include "tools/completion/man_pages.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int completion_command(int argc, char** argv) {
  std::string shell, man;
  CLI::App app{"Prints the completion of this command: source <(./lcmslam completion bash)",
               "lcmslam completion"};
  app.add_option("shell", shell, "bash or zsh")->check(CLI::IsMember({"bash", "zsh"}));
  app.add_option("--man", man, "DIR: writes the manual pages of all commands there instead")
      ->type_name("DIR");
  app.require_option(1);
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  if (!man.empty())
    write_man_pages(man);
  else
    std::cout << completion_script(shell);
  return 0;
}

}  // namespace lcmslam
