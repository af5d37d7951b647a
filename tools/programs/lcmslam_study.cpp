// `lcmslam-study`: experiments, and the completion of all commands, which it alone links; `lcmslam` hands
// over to it.

#include "tools/commands.hpp"
#include "tools/run_commands.hpp"

int main(int argc, char** argv) {
  using namespace lcmslam;
  return run_commands({{"completion", completion_command}, {"study", study_command}}, argc, argv);
}
