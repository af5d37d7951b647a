#pragma once
// How the graph is, in words, and what mends it: for an operator who does not know its inside.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <lcmslam/live_page/page_item.hpp>

namespace lcmslam {

/// What a process last said of itself.
struct ProcessSaid {
  std::string name;
  std::string state;                        ///< "starting", "running", "finished", "stopping", "failed"
  std::string detail;                       ///< in its words
  double age = 0;                           ///< s since it said so
  double cpu = 0;                           ///< cores
  std::int64_t memory = 0;                  ///< bytes resident
  double latency_p50 = 0, latency_p95 = 0;  ///< s
  double rate = 0;                          ///< Hz of its most frequent output
  /// Counts since it started, of all its inputs.
  std::int64_t lost = 0, unreadable = 0, dropped = 0, kernel_drops = 0;
};

/// What a mapper's newest pose says.
struct MapperSaid {
  std::string name;    ///< "icp", "fastslam"
  std::string status;  ///< "TRACKING", "DEGRADED", "LOST", ...; "SILENT": it comes from a while ago
  std::string detail;
};

enum class Level { good, warn, bad };
const char* to_string(Level level);

struct Complaint {
  Level level = Level::good;
  std::string words, mend;
};

/// Remembers counts, so that what went wrong long ago is forgiven.
class Health {
 public:
  /// `now` s, of any clock that goes on.
  PageItem item(const std::vector<ProcessSaid>& processes, const std::vector<MapperSaid>& mappers,
                double now);

 private:
  struct Counts {
    std::int64_t lost = 0, unreadable = 0, dropped = 0, kernel_drops = 0;
    double risen = -1e9;  // when one of them rose last
    Complaint complaint;
  };
  Complaint complaint_of(const ProcessSaid& process, double now);

  std::map<std::string, Counts> counts_;
};

}  // namespace lcmslam
