#include <fmt/format.h>
#include <iostream>

#include "tools/map/map_commands.hpp"
#include "tools/map/map_diff.hpp"
#include "tools/parse_command.hpp"

namespace lcmslam {
namespace {

auto compared(const DiffCount& n) {
  return n.only_first + n.only_second + n.both;
}

void print(const char* what, const DiffCount& n) {
  if (compared(n) == 0) return;
  std::cout << fmt::format("  {}: {} in both, {} only in the first, {} only in the second", what, n.both,
                           n.only_first, n.only_second);
  if (n.farthest >= 0)
    std::cout << fmt::format("; moved by up to {:.4f} m ({})", n.greatest_distance, n.farthest);
  if (n.greatest_angle > 0) std::cout << fmt::format(", {:.3f} deg", n.greatest_angle * 180 / M_PI);
  std::cout << "\n";
}

/// Where the session stands under another name in the second file, as after a merge.
std::string other_name(const SessionDiff& diff) {
  const bool renamed = diff.in_both() && diff.first_name != diff.second_name;
  return renamed ? fmt::format(" ({} of the second)", diff.second_name) : "";
}

}  // namespace

int map_diff_command(int argc, char** argv) {
  std::string first, second;
  CLI::App app{
      "Compares two files of one map, such as an older copy and a newer one, session by session, by the "
      "poses of their keyframes and the means of their landmarks; points, features, images, edges, "
      "covariances and paths are not looked at. A session is the same where the same run of a mapper made "
      "it: maps of other runs are related by `lcmslam map merge`. Exit code 0 only when those agree.",
      "lcmslam map diff"};
  app.add_option("first", first, "an .lcmslam file")->required();
  app.add_option("second", second, "an .lcmslam file")->required();
  if (const auto exit_code = parse_command(app, argc, argv)) return *exit_code;
  MapFile a(first), b(second);
  bool same = true, any = false, related = false;
  for (const SessionDiff& diff : diff_maps(a, b)) {
    same = same && diff.same();
    related = related || diff.in_both();
    any = any || compared(diff.keyframes) + compared(diff.landmarks) > 0;
    std::cout << diff.name << other_name(diff) << (diff.same() ? ": the same places" : "")
              << (!diff.in_first() ? ": only in the second"
                                   : (!diff.in_second() ? ": only in the first" : ""))
              << "\n";
    print("nodes", diff.keyframes);
    print("landmarks", diff.landmarks);
  }
  if (same && !any) {
    std::cout << "neither file has a keyframe or a landmark: nothing was compared\n";
    return 1;
  }
  std::cout
      << (same ? "the maps agree in their keyframes' poses and their landmarks' means; points, features, "
                 "images, edges, covariances and paths were not compared\n"
               : "the maps differ\n");
  if (!same && !related)
    std::cout
        << "no session is in both files, and each run of a mapper numbers its places anew: lcmslam map merge "
           "finds where one map lies in the other\n";
  return same ? 0 : 1;
}

}  // namespace lcmslam
