#include <lcmslam/files/atomic_file.hpp>

#include <gmock/gmock.h>

#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <fstream>

#include "tests/unit/tools/scratch.hpp"

namespace lcmslam {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

class Files : public ::testing::Test {
 protected:
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(scratch_.path())) all.push_back(entry.path().filename());
    return all;
  }
  fs::path place(const std::string& name) const { return scratch_.path() / name; }
  testing::ScratchFolder scratch_;
};

TEST_F(Files, AWriterThatFailsHalfWayKeepsTheOldFile) {
  write_atomically(place("map.txt"), "old");
  const std::string error = error_of([&] {
    write_atomically(place("map.txt"), [&](const fs::path& part) {
      std::ofstream(part) << "half of the n";
      EXPECT_EQ(names().size(), 2U) << "it is written beside the old one";
      throw std::runtime_error("the writer's reason");
    });
  });
  EXPECT_EQ(error, "cannot save " + place("map.txt").string() + ": the writer's reason");
  EXPECT_EQ(scratch_.read("map.txt"), "old");
  write_atomically(place("map.txt"), "new");
  EXPECT_EQ(scratch_.read("map.txt"), "new");
  EXPECT_THAT(names(), UnorderedElementsAre("map.txt"));
}

TEST_F(Files, ASymbolicLinkIsNeitherFollowedNorReplaced) {
  scratch_.write("victim", "untouched");
  fs::create_symlink(place("victim"), place("map.txt"));
  EXPECT_THAT(error_of([&] { write_atomically(place("map.txt"), "new"); }), HasSubstr("symbolic link"));
  EXPECT_EQ(scratch_.read("victim"), "untouched");
  EXPECT_THAT(names(), UnorderedElementsAre("victim", "map.txt"));
}

TEST_F(Files, WhatGoesIntoAHeldFolderGoesThereWhateverItsNameLeadsToNow) {
  fs::create_directory(place("run"));
  const HeldFolder run(place("run"));
  fs::rename(place("run"), place("moved"));
  fs::create_directory(place("elsewhere"));
  fs::create_directory_symlink(place("elsewhere"), place("run"));
  write_atomically(FilePlace(run, "map.txt"), "here");
  EXPECT_EQ(scratch_.read("moved/map.txt"), "here");
  EXPECT_THAT(fs::is_empty(place("elsewhere")), true);
}

TEST_F(Files, NamesThatStrangersMayGive) {
  for (const char* good : {"a", "Tour-2.b_c", "-", "0"}) EXPECT_NO_THROW(check_name(good)) << good;
  for (const std::string& bad : {std::string(), std::string("."), std::string(".."), std::string(".a"),
                                 std::string("a/b"), std::string("a\nb"), std::string("a\0", 2),
                                 std::string("a:b"), std::string("\xFF"), std::string(101, 'a')})
    EXPECT_THROW(check_name(bad), std::runtime_error) << bad;
}

TEST_F(Files, FoldersBelowAreMadeOnlyWhenEveryPartOfTheNameIsGood) {
  const HeldFolder own(scratch_.path());
  EXPECT_EQ(own.below("a/b").path(), place("a/b"));
  EXPECT_TRUE(fs::is_directory(place("a/b")));
  EXPECT_THROW(own.below("c/.d"), std::runtime_error);
  EXPECT_THROW(own.below("c/../../e"), std::runtime_error);
  EXPECT_FALSE(fs::exists(place("c")));
}

/// A process that makes a part file, is told by a byte that it shall end, and dies without a word.
class Writer {
 public:
  explicit Writer(const fs::path& file) {
    int made[2];
    if (pipe(made) != 0) throw std::runtime_error("no pipe");
    pid_ = fork();
    if (pid_ == 0) {
      const PartFile part(file);
      if (write(made[1], "x", 1) != 1) _exit(1);
      while (true) pause();
    }
    char byte;
    if (read(made[0], &byte, 1) != 1) throw std::runtime_error("the writer died");
    close(made[0]);
    close(made[1]);
  }
  ~Writer() { kill_it(); }
  void kill_it() {
    if (pid_ == 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }

 private:
  pid_t pid_ = 0;
};

TEST_F(Files, PartFilesOfTheDeadAreRemovedThoseOfTheLivingStay) {
  Writer living(place("run.lcmlog")), dead(place("run.lcmlog"));
  // The user's, by `split` perhaps, and another file's.
  const std::vector<std::string> others = {"run.lcmlog.part",      "run.lcmlog.part7",    "run.lcmlog.part00",
                                           "run.lcmlog.part7.txt", "run.lcmlog.part7-",   "run.lcmlog.part-7",
                                           "run.lcmlog.part7-1-2", "other.lcmlog.part7-0"};
  for (const std::string& name : others) scratch_.write(name, "precious");
  dead.kill_it();
  EXPECT_EQ(names().size(), others.size() + 2);
  { const PartFile part(place("run.lcmlog")); }
  EXPECT_EQ(names().size(), others.size() + 1) << "the dead one's is gone, the living one's not";
  living.kill_it();
  { const PartFile part(place("run.lcmlog")); }
  EXPECT_THAT(names(), ::testing::UnorderedElementsAreArray(others));
}

TEST_F(Files, ThreadsWriteFilesOfOneNameSideBySide) {
  const PartFile one(place("a")), two(place("a"));
  EXPECT_EQ(names().size(), 2U);
}

}  // namespace
}  // namespace lcmslam
