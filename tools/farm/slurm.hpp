#pragma once
// A farm on Slurm: a job array whose tasks are shares of it.

#include <filesystem>
#include <string>
#include <vector>

namespace lcmslam {

struct SlurmArray {
  std::filesystem::path folder;      ///< gets what the tasks print: slurm-K.txt
  std::vector<std::string> command;  ///< program first, absolute; --share K/N is added
  int tasks = 1;
  int processors = 1;  ///< a task
};

/// Between apostrophes, as a shell takes it for one word.
std::string shell_word(const std::string& word);

/// The batch script.
std::string slurm_script(const SlurmArray& array);

/// Hands the script to sbatch and gives what that says. Throws std::runtime_error when there is no sbatch or
/// it refuses.
std::string submit(const SlurmArray& array);

}  // namespace lcmslam
