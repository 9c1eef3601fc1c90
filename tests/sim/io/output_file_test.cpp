// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/output_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <stdexcept>

#include "tests/support/file_size_limit.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(OutputFile, AppearsUnderItsNameWhenComplete) {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "new/folder/a.txt";
  OutputFile file(path, 8);
  file.append("short ");
  file.append("longer than the buffer ");
  file.append("end");
  EXPECT_FALSE(fs::exists(path));
  EXPECT_TRUE(fs::exists(path.string() + ".part"));
  file.finish();
  EXPECT_EQ(read_whole_file(path), "short longer than the buffer end");
  EXPECT_FALSE(fs::exists(path.string() + ".part"));
}

TEST(OutputFile, KeepsBufferedBytesWhenMoved) {
  const TemporaryDirectory directory;
  OutputFile file(directory.path() / "a.txt", 8);
  std::string expected;
  for (const char* part : {"12345", "678", "9", "abcdefg", "ABCDEFGH", "IJ"}) {
    file.append(part);
    expected += part;
    EXPECT_EQ(file.size(), expected.size());
    EXPECT_LE(expected.size() - fs::file_size(directory.path() / "a.txt.part"), 8U)
        << "at most one buffer is not yet in the file";
  }
  OutputFile moved = std::move(file);
  EXPECT_EQ(moved.size(), expected.size());
  moved.append("K");
  moved.finish();
  EXPECT_EQ(read_whole_file(directory.path() / "a.txt"), expected + "K");
}

TEST(OutputFile, DiscardsFileReplacedByAnother) {
  const TemporaryDirectory directory;
  OutputFile file(directory.path() / "a.txt");
  EXPECT_TRUE(file.is_open());
  file.append("a");
  file = OutputFile(directory.path() / "b.txt");
  EXPECT_FALSE(fs::exists(directory.path() / "a.txt.part"));
  file.append("b");
  file.finish();
  EXPECT_FALSE(file.is_open());
  EXPECT_EQ(read_whole_file(directory.path() / "b.txt"), "b");
  EXPECT_FALSE(OutputFile().is_open());
}

TEST(OutputFile, LeavesNothingWhenUnfinished) {
  const TemporaryDirectory directory;
  {
    OutputFile file(directory.path() / "a.txt");
    file.append("text");
  }
  EXPECT_TRUE(fs::is_empty(directory.path()));
}

TEST(OutputFile, OverwritesEarlierBytes) {
  const TemporaryDirectory directory;
  OutputFile file(directory.path() / "a.txt", 4);
  file.append("0123456789");
  file.append("ab");
  file.overwrite(2, std::as_bytes(std::span("XY", 2)));
  file.append("cd");
  EXPECT_EQ(file.size(), 14U);
  file.finish();
  EXPECT_EQ(read_whole_file(directory.path() / "a.txt"), "01XY456789abcd");
}

TEST(OutputFile, NamesFileWhenDiskIsFull) {
  const TemporaryDirectory directory;
  OutputFile file(directory.path() / "a.bin", 16);
  file.append("fits");
  const FileSizeLimit full(3);
  EXPECT_THAT([&] { file.append("does not fit any more"); },
              ThrowsMessage<std::runtime_error>(AllOf(HasSubstr("a.bin"), HasSubstr("File too large"))));
}

TEST(OutputFile, ReportsFullDiskWhenFinishing) {
  const TemporaryDirectory directory;
  OutputFile file(directory.path() / "a.bin");
  file.append("buffered");
  const FileSizeLimit full(7);
  EXPECT_THAT([&] { file.finish(); }, ThrowsMessage<std::runtime_error>(HasSubstr("File too large")));
  EXPECT_FALSE(fs::exists(directory.path() / "a.bin"));
}

TEST(OutputFile, RefusesSecondRecorderOfSameFile) {
  const TemporaryDirectory directory;
  OutputFile first(directory.path() / "a.txt");
  first.append("first");
  EXPECT_THAT([&] { OutputFile(directory.path() / "a.txt"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("another recorder")));
  first.finish();
  EXPECT_EQ(read_whole_file(directory.path() / "a.txt"), "first");
}

TEST(OutputFile, OverwritesRemainsOfKilledRun) {
  const TemporaryDirectory directory;
  std::ofstream(directory.path() / "a.txt.part") << "much longer than what comes now";
  OutputFile file(directory.path() / "a.txt");
  file.append("now");
  file.finish();
  EXPECT_EQ(read_whole_file(directory.path() / "a.txt"), "now");
}

TEST(OutputFile, ReplacesSymbolicLinks) {
  const TemporaryDirectory directory;
  const fs::path outside = directory.path() / "outside";
  std::ofstream(outside) << "precious";
  for (const char* link : {"a.txt", "a.txt.part"}) {
    for (const fs::path& target : {outside, directory.path() / "nowhere"}) {
      fs::create_directories(directory.path() / "output");
      fs::create_symlink(target, directory.path() / "output" / link);
      write_file(directory.path() / "output/a.txt", "text");
      EXPECT_EQ(read_whole_file(outside), "precious") << link;
      EXPECT_FALSE(fs::exists(directory.path() / "nowhere")) << link;
      EXPECT_FALSE(fs::is_symlink(directory.path() / "output/a.txt")) << link;
      EXPECT_EQ(read_whole_file(directory.path() / "output/a.txt"), "text") << link;
      fs::remove_all(directory.path() / "output");
    }
  }
}

TEST(OutputFile, ReplacesHardLinksAndPipes) {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "a.txt", partial = directory.path() / "a.txt.part";
  std::ofstream(directory.path() / "outside") << "precious";
  fs::create_hard_link(directory.path() / "outside", partial);
  write_file(path, "text");
  EXPECT_EQ(read_whole_file(directory.path() / "outside"), "precious");
  ASSERT_EQ(::mkfifo(partial.c_str(), 0600), 0);
  write_file(path, "after a pipe");
  EXPECT_EQ(read_whole_file(path), "after a pipe");
  fs::create_directory(partial);
  EXPECT_THAT([&] { write_file(path, "x"); }, ThrowsMessage<std::runtime_error>(HasSubstr("Is a directory")));
  EXPECT_EQ(read_whole_file(path), "after a pipe");
}

TEST(OutputFile, NamesPathThatCannotExist) {
  const TemporaryDirectory directory;
  std::ofstream(directory.path() / "file") << "x";
  EXPECT_THAT([&] { OutputFile(directory.path() / "file/below.txt"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("below.txt")));
}

}  // namespace
}  // namespace swiftlet::sim
