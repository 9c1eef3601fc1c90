// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/run_directory.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <set>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class RunDirectoryTest : public testing::Test {
 protected:
  std::set<fs::path> names() const {
    std::set<fs::path> found;
    for (const auto& entry : fs::directory_iterator(root_)) found.insert(entry.path());
    return found;
  }
  /// State of the directory after a run of the name "a" was killed.
  fs::path directory_of_a_killed_run() const {
    const std::set<fs::path> before = names();
    const pid_t child = ::fork();
    if (child == 0) {
      const RunDirectory run(root_ / "a");
      ::_exit(0);  // without destructors
    }
    ::waitpid(child, nullptr, 0);
    for (const fs::path& name : names()) {
      if (!before.contains(name)) return name;
    }
    return {};
  }
  std::size_t entries() const { return names().size(); }
  const TemporaryDirectory folder_;
  const fs::path root_ = folder_.path();
};

TEST_F(RunDirectoryTest, AppearsOnlyWhenCommitted) {
  RunDirectory run(root_ / "a");
  write_file(run.path() / "summary.json", "{}");
  EXPECT_FALSE(fs::exists(root_ / "a"));
  run.commit();
  EXPECT_TRUE(fs::exists(root_ / "a/summary.json"));
  EXPECT_EQ(entries(), 1U);
}

TEST_F(RunDirectoryTest, LeavesNothingWithoutCommit) {
  { RunDirectory run(root_ / "a"); }
  EXPECT_EQ(entries(), 0U);
}

TEST_F(RunDirectoryTest, ReplacesAnEarlierRun) {
  fs::create_directories(root_ / "a");
  write_file(root_ / "a/summary.json", "old");
  write_file(root_ / "a/other.txt", "old");
  RunDirectory run((root_ / "a/").string());
  write_file(run.path() / "summary.json", "new");
  run.commit();
  EXPECT_FALSE(fs::exists(root_ / "a/other.txt"));
  EXPECT_EQ(entries(), 1U);
}

TEST_F(RunDirectoryTest, RefusesToReplaceAnythingElse) {
  fs::create_directories(root_ / "thesis");
  write_file(root_ / "thesis/chapter1.tex", "years of work");
  EXPECT_THROW(RunDirectory(root_ / "thesis"), InputError);
  write_file(root_ / "file", "x");
  EXPECT_THROW(RunDirectory(root_ / "file"), InputError);
  EXPECT_THROW(RunDirectory(root_ / "file/below"), InputError);
  EXPECT_TRUE(fs::exists(root_ / "thesis/chapter1.tex"));
}

TEST_F(RunDirectoryTest, RefusesToReplaceItsInputFiles) {
  fs::create_directories(root_ / "a/maps");
  write_file(root_ / "a/summary.json", "{}");
  write_file(root_ / "a/maps/uav1.slam", "an hour of flight");
  const std::vector<NamedFile> inside = {{"map", root_ / "b/../a/maps/uav1.slam"}};
  EXPECT_THROW(RunDirectory(root_ / "a", inside), InputError);
  EXPECT_TRUE(fs::exists(root_ / "a/maps/uav1.slam"));
  const std::vector<NamedFile> beside = {{"map", root_ / "ab/maps/uav1.slam"}};
  EXPECT_NO_THROW(RunDirectory(root_ / "a", beside));
}

TEST_F(RunDirectoryTest, RefusesALinkToNothing) {
  fs::create_symlink(root_ / "unmounted", root_ / "a");
  EXPECT_THAT([&] { RunDirectory(root_ / "a"); }, ThrowsMessage<InputError>(HasSubstr("a link to")));
  fs::create_symlink("loop", root_ / "loop");
  EXPECT_THROW(RunDirectory(root_ / "loop"), InputError);
  EXPECT_THROW(RunDirectory(root_ / "a/below"), InputError);
  EXPECT_EQ(entries(), 2U);
}

TEST_F(RunDirectoryTest, RemovesRemainsOfKilledRun) {
  const fs::path left = directory_of_a_killed_run();
  RunDirectory run(root_ / "a");
  EXPECT_FALSE(fs::exists(left));
}

TEST_F(RunDirectoryTest, SparesLiveRunsAndForeignDirectories) {
  const RunDirectory live(root_ / "a");
  write_file(live.path() / "scan.pcd", "recorded");
  const std::string prefix = ".a.partial-";
  const std::vector<std::string> foreign = {prefix + "notes", prefix + "4242", prefix + "0123456789abcdef",
                                            prefix + "0123456789abcdef.old"};
  for (const std::string& name : foreign) write_file(root_ / name / "thesis.tex", "work", MissingFolders::kMade);
  const fs::path killed = directory_of_a_killed_run();
  fs::rename(killed, root_ / "renamed");
  fs::create_directory_symlink(root_ / "renamed", root_ / (prefix + "0000000000000000"));
  RunDirectory run(root_ / "a");
  write_file(run.path() / "summary.json", "{}");
  run.commit();
  EXPECT_TRUE(fs::exists(live.path() / "scan.pcd"));
  for (const std::string& name : foreign) EXPECT_TRUE(fs::exists(root_ / name / "thesis.tex")) << name;
  EXPECT_FALSE(fs::is_empty(root_ / "renamed"));
}

TEST_F(RunDirectoryTest, KeepsConcurrentFilesAndRenamesRun) {
  RunDirectory run(root_ / "a");
  write_file(run.path() / "summary.json", "new");
  fs::create_directories(root_ / "a");
  write_file(root_ / "a/notes.txt", "an afternoon of work");
  EXPECT_THROW(run.commit(), std::runtime_error);
  EXPECT_TRUE(fs::exists(root_ / "a/notes.txt"));
  for (const auto& entry : fs::directory_iterator(root_)) {
    if (entry.path() == root_ / "a") continue;
    EXPECT_EQ(read_whole_file(entry.path() / "summary.json"), "new");
  }
  EXPECT_EQ(entries(), 2U);
}

TEST_F(RunDirectoryTest, RestoresEarlierRunAfterKilledCommit) {
  const fs::path left = directory_of_a_killed_run();
  write_file(left / "summary.json", "finished");
  write_file(left.string() + ".replaced/summary.json", "earlier", MissingFolders::kMade);
  { RunDirectory run(root_ / "a"); }
  EXPECT_EQ(read_whole_file(root_ / "a/summary.json"), "earlier");
  EXPECT_EQ(entries(), 1U);
}

}  // namespace
}  // namespace swiftlet::sim
