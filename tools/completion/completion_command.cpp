#include <iostream>

#include "tools/commands.hpp"
#include "tools/completion/completion.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {

int completion_command(int argc, char** argv) {
  std::string shell;
  CLI::App app{"Prints the completion of this command: source <(./lcmslam completion bash)",
               "lcmslam completion"};
  app.add_option("shell", shell, "bash or zsh")->required()->check(CLI::IsMember({"bash", "zsh"}));
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  std::cout << completion_script(shell);
  return 0;
}

}  // namespace lcmslam
