// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/run/run_directory.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "swiftlet/sim/errors.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

class RunDirectoryTest : public testing::Test {
 protected:
  std::size_t entries() const { return std::distance(fs::directory_iterator(root_), fs::directory_iterator()); }
  const TemporaryDirectory folder_;
  const fs::path root_ = folder_.path();
};

TEST_F(RunDirectoryTest, AppearsUnderItsNameOnlyWhenCommitted) {
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

TEST_F(RunDirectoryTest, ReplacesNoFileThatTheRunReads) {
  fs::create_directories(root_ / "a/maps");
  write_file(root_ / "a/summary.json", "{}");
  write_file(root_ / "a/maps/uav1.slam", "an hour of flight");
  const std::vector<NamedFile> inside = {{"map", root_ / "b/../a/maps/uav1.slam"}};
  EXPECT_THROW(RunDirectory(root_ / "a", inside), InputError);
  EXPECT_TRUE(fs::exists(root_ / "a/maps/uav1.slam"));
  const std::vector<NamedFile> beside = {{"map", root_ / "ab/maps/uav1.slam"}};
  EXPECT_NO_THROW(RunDirectory(root_ / "a", beside));
}

TEST_F(RunDirectoryTest, RemovesWhatAKilledRunLeftBehind) {
  fs::create_directories(root_ / ".a.partial-999999999");  // no process has this number
  RunDirectory run(root_ / "a");
  EXPECT_FALSE(fs::exists(root_ / ".a.partial-999999999"));
}

TEST_F(RunDirectoryTest, WhatSomebodyPutsThereDuringTheRunStaysAndTheRunGetsAnotherName) {
  RunDirectory run(root_ / "a");
  write_file(run.path() / "summary.json", "new");
  fs::create_directories(root_ / "a");
  write_file(root_ / "a/notes.txt", "an afternoon of work");
  EXPECT_THROW(run.commit(), std::runtime_error);
  EXPECT_TRUE(fs::exists(root_ / "a/notes.txt"));
  EXPECT_EQ(read_whole_file(root_ / ("a.finished-" + std::to_string(getpid())) / "summary.json"), "new");
  EXPECT_EQ(entries(), 2U);
}

TEST_F(RunDirectoryTest, AnEarlierRunThatAKilledCommitMovedAsideComesBack) {
  // No process has this number.
  fs::create_directories(root_ / ".a.partial-999999999.replaced");
  write_file(root_ / ".a.partial-999999999.replaced/summary.json", "earlier");
  fs::create_directories(root_ / ".a.partial-999999999");
  write_file(root_ / ".a.partial-999999999/summary.json", "finished");
  { RunDirectory run(root_ / "a"); }
  EXPECT_EQ(read_whole_file(root_ / "a/summary.json"), "earlier");
  EXPECT_EQ(entries(), 1U);
}

}  // namespace
}  // namespace swiftlet::sim
