#pragma once
// Completion of `lcmslam` in a shell, made from the commands' own descriptions and the settings'.
//
//   source <(./lcmslam completion bash)      # in ~/.bashrc
//   source <(./lcmslam completion zsh)       # in ~/.zshrc, after compinit

#include <string>

namespace lcmslam {

/// For "bash" or "zsh".
std::string completion_script(const std::string& shell);

}  // namespace lcmslam
