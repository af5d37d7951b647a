#include "tools/farm/slurm.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <array>
#include <cstdio>
#include <stdexcept>

#include <lcmslam/files/atomic_file.hpp>

namespace lcmslam {

std::string shell_word(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string slurm_script(const SlurmArray& array) {
  std::string script = fmt::format(
      "#!/bin/bash\n"
      "#SBATCH --job-name=lcmslam\n"
      "#SBATCH --array=0-{}\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --output={}\n"
      "exec",
      array.tasks - 1, array.processors, (array.folder / "slurm-%a.txt").string());
  for (const std::string& word : array.command) script += " " + shell_word(word);
  return script + fmt::format(" --share \"$SLURM_ARRAY_TASK_ID/{}\"\n", array.tasks);
}

std::string submit(const SlurmArray& array) {
  const std::filesystem::path script = array.folder / "slurm.sh";
  write_atomically(FilePlace(script), slurm_script(array));
  FILE* const pipe = popen(("sbatch " + shell_word(script.string()) + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("sbatch cannot be started");
  std::string said;
  std::array<char, 256> piece{};
  while (std::fgets(piece.data(), piece.size(), pipe) != nullptr) said += piece.data();
  const int status = pclose(pipe);
  while (!said.empty() && said.back() == '\n') said.pop_back();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return said;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
    throw std::runtime_error("there is no sbatch here: --slurm needs Slurm; the script is " +
                             script.string());
  throw std::runtime_error("sbatch refused " + script.string() + ": " + said);
}

}  // namespace lcmslam
