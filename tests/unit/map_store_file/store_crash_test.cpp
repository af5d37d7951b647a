// Processes that are killed and power that fails while a map is written. LCMSLAM_CRASHES=50 tries more of
// each.

#include <gmock/gmock.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <lcmslam/map_store/file/check_map_file.hpp>
#include <lcmslam/map_store/file/map_file.hpp>
#include <lcmslam/map_store/file/store_writer.hpp>
#include "tests/support/lossy_disk.hpp"
#include "tests/unit/map_store_file/sample_store.hpp"

namespace lcmslam {
namespace {

using ::testing::IsEmpty;
using Clock = std::chrono::steady_clock;

int crashes(int usual) {
  const char* wanted = std::getenv("LCMSLAM_CRASHES");
  return wanted != nullptr ? std::atoi(wanted) : usual;
}

/// Commit `number` (from 1) adds a keyframe of that id, drops the oldest now and then, and moves the others
/// to x = number.
SessionChanges commit_of(int number) {
  SessionChanges changes;
  DenseKeyframe keyframe = some_keyframe(number, 60);
  changes.put_keyframe(keyframe, std::nullopt);
  changes.put_landmark(some_landmark(1, number % 5));
  if (number > 1) changes.set_edges({number - 1, number}, {edge_between(number - 1, number)});
  for (int id = number / 4 + 1; id <= number; ++id)
    changes.move_keyframe(id, id, Eigen::Isometry3d(Eigen::Translation3d(number, 0, 0)));
  if (number % 4 == 0) changes.drop_keyframe(number / 4);
  return changes;
}

/// Commits of one session with the file opened anew every few of them, so that what waits beside the file
/// goes into it.
void write_commits(const std::filesystem::path& file, const char* vfs, int commits) {
  std::unique_ptr<MapStore> store;
  std::int64_t session = 0;
  for (int number = 1; number <= commits; ++number) {
    if (number % 6 == 1) {
      store.reset();
      store = std::make_unique<MapStore>(file, vfs);
    }
    Transaction transaction = store->begin();
    if (session == 0) session = store->add_session(store->add_run({"", ""}), session_of("icp"));
    store->write(session, commit_of(number));
    transaction.commit();
  }
}

/// The number of the commit that the file stands at; all of it must be of that one.
int commit_in(const std::filesystem::path& file) {
  MapFile read(file);
  if (read.sessions().empty()) return 0;
  const std::int64_t session = read.sessions()[0].id;
  const auto keyframes = read.keyframes(session);
  const int number = keyframes.empty() ? 0 : keyframes.back().id;
  EXPECT_EQ(keyframes.size(), static_cast<std::size_t>(number - number / 4));
  for (const auto& keyframe : keyframes) EXPECT_EQ(keyframe.T_map_camera.translation().x(), number);
  return number;
}

TEST(StoreCrash, WhenThePowerFailsTheMapIsWholeAndOfOneMoment) {
  constexpr int commits = 20;
  std::int64_t operations = 0;
  {
    TemporaryFolder folder;
    testing::LossyDisk disk("counting");
    write_commits(folder / "map.lcmslam", disk.vfs(), commits);
    operations = disk.operations();
    EXPECT_EQ(commit_in(folder / "map.lcmslam"), commits);
  }
  std::set<int> found;
  for (int seed = 1; seed <= crashes(20); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(static_cast<std::uint64_t>(seed));
    TemporaryFolder before, after;
    testing::LossyDisk disk("lossy");
    disk.remember_at(static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(operations))));
    write_commits(before / "map.lcmslam", disk.vfs(), commits);
    disk.lose_power(after.path(), random);
    const auto file = after / "map.lcmslam";
    if (!std::filesystem::exists(file)) continue;
    EXPECT_THAT(check_map_file(file).faults, IsEmpty());
    const int number = commit_in(file);
    found.insert(number);
    MapStore goes_on(file);
    Transaction transaction = goes_on.begin();
    goes_on.write(number > 0 ? 1 : goes_on.add_session(goes_on.add_run({"", ""}), session_of("icp")),
                  commit_of(number + 1));
    transaction.commit();
    EXPECT_EQ(commit_in(file), number + 1);
    EXPECT_THAT(check_map_file(file).faults, IsEmpty());
  }
  EXPECT_GT(found.size(), 3U) << "the moments differ";
}

/// When the child handed in each keyframe: shared with the parent.
struct HandedIn {
  static constexpr int most = 4096;
  std::atomic<int> count{0};
  std::array<Clock::time_point, most> times{};
};

[[noreturn]] void map_until_killed(const std::filesystem::path& file, HandedIn& handed_in) {
  StoreWriter writer(file, {"", ""});
  const std::size_t session = writer.begin_session(session_of("icp"));
  for (int id = 0; id < HandedIn::most; ++id) {
    const DenseKeyframe keyframe = some_keyframe(id, 500);
    writer.change(session, [&](SessionChanges& changes) {
      changes.put_keyframe(keyframe, std::nullopt);
      changes.put_landmark(some_landmark(1, id % 50));
      for (int other = 0; other < id; other += 3)
        changes.move_keyframe(other, other, keyframe.T_world_camera);
    });
    handed_in.times[static_cast<std::size_t>(id)] = Clock::now();
    handed_in.count = id + 1;
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  }
  std::_Exit(0);
}

/// s between the first keyframe that the file lacks and the death.
double lost(const std::filesystem::path& file, std::size_t sessions_before, const HandedIn& handed_in,
            Clock::time_point death) {
  std::size_t kept = 0;
  {
    MapFile read(file);
    const auto sessions = read.sessions();
    if (sessions.size() > sessions_before)
      kept = static_cast<std::size_t>(read.counts(sessions.back().id).clouds);
  }
  if (kept >= static_cast<std::size_t>(handed_in.count)) return 0;
  return std::chrono::duration<double>(death - handed_in.times[kept]).count();
}

TEST(StoreCrash, WhoIsKilledLosesLessThanASecondAndTheNextGoesOn) {
  TemporaryFolder folder;
  const auto file = folder / "map.lcmslam";
  void* shared = mmap(nullptr, sizeof(HandedIn), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  Random random(1);
  double worst = 0;
  std::size_t sessions = 0;
  for (int kill_number = 0; kill_number < crashes(4); ++kill_number) {
    auto* handed_in = new (shared) HandedIn;
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) map_until_killed(file, *handed_in);
    const auto life = std::chrono::milliseconds(5 + random.below(kill_number % 2 == 0 ? 1500 : 400));
    std::this_thread::sleep_for(life);
    const Clock::time_point death = Clock::now();
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    if (!std::filesystem::exists(file)) continue;
    worst = std::max(worst, lost(file, sessions, *handed_in, death));
    EXPECT_THAT(check_map_file(file).faults, IsEmpty());
    const std::size_t now = MapFile(file).sessions().size();
    EXPECT_GE(now, sessions) << "nothing old is lost";
    sessions = now;
  }
  munmap(shared, sizeof(HandedIn));
  RecordProperty("worst_loss_ms", static_cast<int>(1000 * worst));
  std::cout << "worst loss " << worst << " s, " << sessions << " sessions\n";
  EXPECT_GT(sessions, 0U);
  EXPECT_LT(worst, 1.0);
}

}  // namespace
}  // namespace lcmslam
