// `lcmslam-study`: experiments; `lcmslam study` hands over to it.

#include "tools/commands.hpp"
#include "tools/run_commands.hpp"

int main(int argc, char** argv) {
  return lcmslam::run_commands({{"study", lcmslam::study_command}}, argc, argv);
}
