// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <stdexcept>

#include "swiftlet/sim/errors/errors.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(WriteFile, ReplacesTheWholeFile) {
  const TemporaryDirectory directory;
  write_file(directory.path() / "a.txt", "long before");
  write_file(directory.path() / "a.txt", "now");
  EXPECT_EQ(read_whole_file(directory.path() / "a.txt"), "now");
}

TEST(WriteFile, MakesFoldersOnlyWhenAsked) {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "new/a.txt";
  EXPECT_THAT([&] { write_file(path, "text"); }, ThrowsMessage<std::runtime_error>(HasSubstr("No such file")));
  EXPECT_TRUE(fs::is_empty(directory.path()));
  write_file(path, "text", MissingFolders::kMade);
  EXPECT_EQ(read_whole_file(path), "text");
}

TEST(WriteFile, ReportsPathAndReason) {
  EXPECT_THAT([] { write_file("/dev/full/x", "content"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("cannot write /dev/full/x: ")));
}

TEST(PartialFile, RemovesUncommittedDataAndKeepsOriginal) {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "a.txt";
  write_file(path, "before");
  {
    PartialFile file(path);
    std::ofstream(file.partial()) << "half";
  }
  EXPECT_EQ(read_whole_file(path), "before");
  EXPECT_FALSE(fs::exists(path.string() + ".part"));
  PartialFile file(path);
  std::ofstream(file.partial()) << "whole";
  file.commit();
  EXPECT_EQ(read_whole_file(path), "whole");
}

TEST(PartialFile, ReportsPathsThatAreDirectories) {
  const TemporaryDirectory directory;
  fs::create_directories(directory.path() / "taken/inside");
  PartialFile file(directory.path() / "taken");
  std::ofstream(file.partial()) << "text";
  EXPECT_THAT([&] { file.commit(); }, ThrowsMessage<std::runtime_error>(HasSubstr("taken: ")));
}

TEST(ReadWholeFile, ReportsUnreadableFiles) {
  const TemporaryDirectory directory;
  EXPECT_THAT([&] { read_whole_file(directory.path()); }, ThrowsMessage<InputError>(HasSubstr("is a directory")));
  EXPECT_THAT([&] { read_whole_file(directory.path() / "none"); },
              ThrowsMessage<InputError>(HasSubstr("No such file")));
}

TEST(ReadWholeFile, ReadsBytesUpToFourGib) {
  const TemporaryDirectory directory;
  const std::string bytes("a\0\r\n\xFF", 5);
  write_file(directory.path() / "a", bytes);
  EXPECT_EQ(read_whole_file(directory.path() / "a"), bytes);
  write_file(directory.path() / "empty", "");
  EXPECT_EQ(read_whole_file(directory.path() / "empty"), "");
  fs::resize_file(directory.path() / "a", (std::uintmax_t{4} << 30) + 1);  // takes no room
  EXPECT_THAT([&] { read_whole_file(directory.path() / "a"); },
              ThrowsMessage<InputError>(HasSubstr("expected at most 4 GiB, found 4294967297 bytes")));
}

TEST(PartialFile, MovesAndRemovesTheReplacedFile) {
  const TemporaryDirectory directory;
  PartialFile first(directory.path() / "a"), second(directory.path() / "b");
  std::ofstream(first.partial()) << "a";
  std::ofstream(second.partial()) << "b";
  first = std::move(second);
  EXPECT_FALSE(fs::exists(directory.path() / "a.part"));
  first.commit();
  EXPECT_EQ(read_whole_file(directory.path() / "b"), "b");
}

TEST(ReadWholeFile, WaitsForNoWriter) {
  const TemporaryDirectory directory;
  ASSERT_EQ(::mkfifo((directory.path() / "pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", directory.path() / "endless");
  for (const char* name : {"pipe", "endless"}) {
    EXPECT_THAT([&] { read_whole_file(directory.path() / name); },
                ThrowsMessage<InputError>(HasSubstr("expected a regular file")));
  }
}

TEST(MakeInnerDirectory, RefusesLinksAndCreatesMissingFolders) {
  const TemporaryDirectory directory;
  fs::create_directory(directory.path() / "outside");
  for (const char* target : {"outside", "nowhere"}) {
    fs::create_symlink(directory.path() / target, directory.path() / "link");
    EXPECT_THAT([&] { make_inner_directory(directory.path() / "link"); },
                ThrowsMessage<InputError>(HasSubstr("found a link")));
    fs::remove(directory.path() / "link");
  }
  EXPECT_FALSE(fs::exists(directory.path() / "nowhere"));
  make_inner_directory(directory.path() / "inner");
  make_inner_directory(directory.path() / "inner");
  EXPECT_TRUE(fs::is_directory(directory.path() / "inner"));
}

TEST(MakeDirectory, MakesThoseAboveIt) {
  const TemporaryDirectory directory;
  make_directory(directory.path() / "a/b/c");
  EXPECT_TRUE(fs::is_directory(directory.path() / "a/b/c"));
  write_file(directory.path() / "file", "x");
  EXPECT_THROW(make_directory(directory.path() / "file/below"), InputError);
  fs::create_symlink("unmounted", directory.path() / "link");
  EXPECT_THAT([&] { make_directory(directory.path() / "link"); },
              ThrowsMessage<InputError>(HasSubstr("a link to unmounted, which is not there")));
}

}  // namespace
}  // namespace swiftlet::sim
