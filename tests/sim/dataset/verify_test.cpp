// SPDX-License-Identifier: BSD-3-Clause
// A dataset made by hand, with one thing after the other that is not as it should be.
#include "swiftlet/sim/dataset/verify.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/dataset/sequence_recorder.hpp"
#include "swiftlet/sim/dataset/generate.hpp"
#include "swiftlet/sim/dataset/sequence_info.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "tests/sim/dataset/read_files.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// One sequence of three frames with 2, 0 and 1 points and two other vehicles.
class HandMade : public ::testing::Test {
 protected:
  HandMade() {
    info.sequence = 0;
    info.split = "train";
    info.instance = 1;
    info.vehicles = {"a", "b", "c"};
    info.models = {"x", "x", "x"};
    info.state_hash = "hash";
    info.fingerprint = "print";
    info.statistics.frames = 3;
    info.statistics.points = 3;
    plan.config.name = "hand";
    plan.fingerprint = "print";
    const int points[] = {2, 0, 1};
    for (int frame = 0; frame < 3; ++frame) {
      const auto n = static_cast<std::size_t>(points[frame]);
      write(frame_file("velodyne", frame, "bin"), std::string(16 * n, 'p'));
      std::string labels;
      for (std::size_t i = 0; i < n; ++i)
        labels += i == 0 ? std::string("\x28\0\0\0", 4) : std::string("\x2C\x01\x02\0", 4);
      write(frame_file("labels", frame, "label"), labels);  // 40 ground, 300 a vehicle
    }
    write("poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1e-3 -0 nan 0 0 1 0 0 0 0 1 2.5\n1 0 0 0 0 1 0 0 0 0 1 0\n");
    write("times.txt", "0\n0.1\n0.2\n");
    write("boxes.csv", "frame,vehicle,x\n0,b,1\n0,c,1\n1,b,2\n1,c,2\n2,b,3\n2,c,3\n");
  }

  void write(const std::string& name, const std::string& text) const {
    const fs::path path = sequence() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
  }
  fs::path sequence() const { return root() / "sequences/00"; }
  fs::path root() const { return directory.path() / "out"; }

  static VerifyOptions without_frames() {
    VerifyOptions options;
    options.frames = 0;
    return options;
  }

  /// Verification with descriptions that fit the present files.
  VerifyReport verify(const VerifyOptions& options = without_frames()) {
    std::ofstream(root() / "README.md") << "hand-made";
    info.files = list_files(sequence());
    std::ofstream(sequence() / "sequence.json") << to_json(info);
    auto files = list_files(root(), {}, "sequences");
    std::erase_if(files, [](const FileEntry& file) { return file.path == "manifest.json"; });
    auto described = list_files(root() / "sequences");
    for (FileEntry& file : described) {
      if (!file.path.ends_with("sequence.json")) continue;
      file.path = "sequences/" + file.path;
      files.push_back(file);
    }
    auto manifest = nlohmann::json::parse(manifest_json(plan, {info}, files, true));
    if (change_manifest) change_manifest(manifest);
    std::ofstream(root() / "manifest.json") << manifest;
    return verify_dataset(root(), options);
  }
  std::vector<std::string> problems() { return verify().problems; }

  TemporaryDirectory directory;
  SequenceInfo info;
  DatasetPlan plan;
  std::function<void(nlohmann::json&)> change_manifest;
};

TEST_F(HandMade, IsFineAsItIs) {
  const VerifyReport report = verify();
  EXPECT_THAT(report.problems, IsEmpty());
  EXPECT_TRUE(report.ok());
  EXPECT_EQ(report.frames, 3);
  EXPECT_EQ(report.files, 3 + 3 + 3 + 1 + 1);  // frames, tables, sequence.json, README.md
  EXPECT_EQ(report.resimulated, 0);
  EXPECT_EQ(report.poses_outside, "");
  info.statistics.frames_walled = 3;
  info.statistics.frames_outside = 1;
  EXPECT_EQ(verify().poses_outside, "33.3 % of 3 poses lie outside walls (train 33.3 %)");
}

TEST_F(HandMade, LocatesDamageInTablesAndFrames) {
  const std::string pose = "1 0 0 0 0 1 0 0 0 0 1 0\n", boxes = "frame,vehicle,x\n0,b,1\n0,c,1\n1,b,2\n1,c,2\n";
  const struct {
    std::string file, content;
    std::vector<std::string> problems;  // paths within the sequence
  } cases[] = {
      {"poses.txt", pose + "1 0 0 0 0 1 0 0 0 0 1\n" + pose, {"poses.txt:2: expected 12 numbers"}},
      {"poses.txt", pose + "1 0 0 0 0 1 0 0 0 0 1 0 0\n" + pose, {"poses.txt:2: expected 12 numbers"}},
      {"poses.txt", pose + "1  0 0 0 0 1 0 0 0 0 1\n" + pose, {"poses.txt:2: expected 12 numbers"}},
      {"poses.txt", pose + "1 0 0 0 0 1 0 0 0 0 1 0x\n" + pose, {"poses.txt:2: expected 12 numbers"}},
      {"poses.txt", pose + pose, {"poses.txt: expected 3 lines, found 2"}},
      {"poses.txt", pose + pose + pose + pose, {"poses.txt: expected 3 lines, found 4"}},
      {"times.txt", "0\n0.1\n0.2 3\n", {"times.txt:3: expected 1 numbers"}},
      {"labels/000000.label", {"\x28\0\0\0", 4}, {"labels/000000.label: expected 2 labels, found 1"}},
      {"labels/000000.label", {"\x28\0\0\0\x29\0\0\0", 8}, {"labels/000000.label: class 41 is not in the class table"}},
      {"labels/000000.label", {"\0\0\xFF\xFF\x28\0\0\0", 8}, {}},  // any instance, unlabeled
      {"velodyne/000000.bin",
       std::string(33, 'p'),
       {"velodyne/000000.bin: expected a multiple of 16 bytes (four float32 per point), found 33 bytes"}},
      {"velodyne/000000.bin",
       std::string(48, 'p'),
       {"labels/000000.label: expected 3 labels, found 2", "expected 3 points, found 4"}},
      {"boxes.csv", boxes + "3,b,3\n2,c,3\n", {"boxes.csv:6: expected 3 columns, the first a frame below 3"}},
      {"boxes.csv", boxes + "b,b,3\n2,c,3\n", {"boxes.csv:6: expected 3 columns, the first a frame below 3"}},
      {"boxes.csv", boxes + "2,b\n2,c,3\n", {"boxes.csv:6: expected 3 columns, the first a frame below 3"}},
      {"boxes.csv", boxes + "2,b,3\n", {"boxes.csv: expected 6 boxes, found 5"}},
      {"boxes.csv", boxes + "2,b,3\n2,c,3\n2,c,3\n", {"boxes.csv: expected 6 boxes, found 7"}},
  };
  for (const auto& c : cases) {
    const std::string before = read_whole_file(sequence() / c.file);
    write(c.file, c.content);
    const auto found = problems();
    EXPECT_EQ(found.size(), c.problems.size()) << c.file << ": " << c.content;
    for (const std::string& problem : c.problems) EXPECT_THAT(found, ::testing::Contains(HasSubstr(problem)));
    write(c.file, before);
  }
}

TEST_F(HandMade, RequiresTruthRecordForEachPoint) {
  const int points[] = {2, 0, 1};
  for (int frame = 0; frame < 3; ++frame)
    write(frame_file("point_truth", frame, "bin"), std::string(16 * static_cast<std::size_t>(points[frame]), 't'));
  EXPECT_THAT(problems(), IsEmpty());
  write("point_truth/000002.bin", std::string(17, 't'));
  EXPECT_THAT(problems(), ElementsAre("sequences/00/point_truth/000002.bin: expected 1 records"));
  fs::remove(sequence() / "point_truth/000001.bin");
  write("point_truth/000002.bin", std::string(16, 't'));
  EXPECT_THAT(problems(), ElementsAre("sequences/00/point_truth: expected 3 files, found 2"));
}

TEST_F(HandMade, RequiresFileForEachFrame) {
  write("images/range/000000.png", "p");
  EXPECT_THAT(problems(), ElementsAre("sequences/00/images/range: expected 3 files, found 1",
                                      "sequences/00/images/intensity: expected 3 files, found 0"));
  fs::remove_all(sequence() / "images");
  write("labels/000003.label", "");
  EXPECT_THAT(problems(), ElementsAre("sequences/00/labels: expected 3 files, found 4"));
  fs::remove(sequence() / "labels/000003.label");
  fs::remove(sequence() / "velodyne/000002.bin");
  EXPECT_THAT(problems(), ElementsAre("sequences/00/velodyne: expected 3 files, found 2",
                                      "sequences/00: expected 3 points, found 2"));
}

TEST_F(HandMade, ChecksFileSizesHashesAndNames) {
  change_manifest = [](nlohmann::json& manifest) {
    for (auto& file : manifest["files"]) {
      if (file["path"] == "sequences/00/times.txt") file["bytes"] = 99;
      if (file["path"] == "sequences/00/poses.txt") file["xxh128"] = "0123";
      if (file["path"] == "sequences/00/boxes.csv") file["path"] = "sequences/00/none.csv";
    }
  };
  EXPECT_THAT(problems(),
              ::testing::UnorderedElementsAre(HasSubstr("sequences/00/times.txt: expected 99 bytes, found 10"),
                                              HasSubstr("sequences/00/poses.txt: expected the hash 0123, found "),
                                              HasSubstr("sequences/00/none.csv: No such file"),
                                              HasSubstr("sequences/00/boxes.csv: not listed in manifest.json")));
}

TEST_F(HandMade, ReportsAtMostFiftyProblems) {
  for (int i = 0; i < 60; ++i) std::ofstream(directory.path() / "out" / ("foreign" + std::to_string(i))) << "";
  change_manifest = [](nlohmann::json& manifest) {
    auto& files = manifest["files"];
    for (std::size_t i = files.size(); i-- > 0;) {
      if (files[i]["path"].get<std::string>().starts_with("foreign")) files.erase(i);
    }
  };
  EXPECT_EQ(problems().size(), 50U);
}

TEST_F(HandMade, ASequenceBelongsToItsManifest) {
  info.fingerprint = "another";
  EXPECT_THAT(problems(), ElementsAre(HasSubstr("belongs to another dataset")));
  info.fingerprint = "print";
  change_manifest = [](nlohmann::json& manifest) { manifest["sequences"][0]["state_hash"] = "other"; };
  EXPECT_THAT(problems(), ElementsAre(HasSubstr("belongs to another dataset")));
  change_manifest = [](nlohmann::json& manifest) { manifest["complete"] = false; };
  EXPECT_THAT(problems(), ElementsAre(HasSubstr("the dataset is not complete")));
  for (const auto& complete : {nlohmann::json(), nlohmann::json("yes")}) {
    change_manifest = [&](nlohmann::json& manifest) { manifest["complete"] = complete; };
    EXPECT_THAT(problems(), ElementsAre(HasSubstr("the dataset is not complete")));
  }
  change_manifest = [](nlohmann::json& manifest) { manifest["sequences"][0]["state_hash"] = 7; };
  EXPECT_THAT(problems(), ElementsAre("manifest.json: state_hash: expected a text, found something else"));
  change_manifest = [](nlohmann::json& manifest) { manifest["sequences"].clear(); };
  EXPECT_THAT(problems(), ElementsAre(HasSubstr("expected a dataset with sequences, found none")));
}

TEST_F(HandMade, RequiresOwnVehicleAndPlausibleFrames) {
  const auto expect = HasSubstr("expected instance 1 to 3 and 0 to 100000000 frames");
  for (const int instance : {0, 4}) {
    info.instance = instance;
    EXPECT_THAT(problems(), ElementsAre(expect)) << instance;
  }
  info.instance = 3;
  EXPECT_THAT(problems(), IsEmpty());
  for (const std::int64_t frames : {std::int64_t{-1}, std::int64_t{100'000'001}}) {
    info.statistics.frames = frames;
    EXPECT_THAT(problems(), ElementsAre(expect)) << frames;
  }
  for (const std::int64_t frames : {std::int64_t{0}, std::int64_t{2}}) {
    info.statistics.frames = frames;
    EXPECT_THAT(problems(), ::testing::Each(::testing::Not(expect)));
  }
}

// Frames without files cost no time: as many are looked at as there are files.
TEST_F(HandMade, ReportsFramesWithoutFilesAtOnce) {
  info.statistics.frames = 100'000'000;
  EXPECT_THAT(problems(), ElementsAre("sequences/00/velodyne: expected 100000000 files, found 3",
                                      "sequences/00/labels: expected 100000000 files, found 3",
                                      "sequences/00/poses.txt: expected 100000000 lines, found 3",
                                      "sequences/00/times.txt: expected 100000000 lines, found 3",
                                      "sequences/00/boxes.csv: expected 200000000 boxes, found 6"));
}

TEST_F(HandMade, PathsOutsideTheDatasetAreRefused) {
  for (const std::string path : {"/etc/passwd", "../outside", "sequences/../../outside", "sequences/00/..", ""}) {
    change_manifest = [&](nlohmann::json& manifest) { manifest["files"][0]["path"] = path; };
    EXPECT_THAT([&] { verify(); }, ::testing::ThrowsMessage<InputError>(HasSubstr(
                                       "manifest.json: files: expected paths within the dataset, found \"" + path)))
        << path;
  }
  for (const std::string name : {"../sequences/00", "/tmp", "0", "00/", "x", ""}) {
    change_manifest = [&](nlohmann::json& manifest) { manifest["sequences"][0]["sequence"] = name; };
    EXPECT_THAT(problems(), ElementsAre(HasSubstr("sequences: expected a number such as 07, found \"" + name + "\"")));
  }
}

TEST_F(HandMade, RequiresSequenceNumberOfItsFolder) {
  info.sequence = 1;
  change_manifest = [](nlohmann::json& manifest) {
    manifest["sequences"][0]["sequence"] = "00";
    for (auto& file : manifest["files"]) {
      std::string path = file["path"];
      if (path.starts_with("sequences/01/")) file["path"] = path.replace(10, 2, "00");
    }
  };
  EXPECT_THAT(problems(), ElementsAre("sequences/00/sequence.json: expected sequence 00, found 01"));
}

TEST_F(HandMade, ReportsProgressAndEndsWhenCanceled) {
  for (int i = 0; i < 130; ++i) std::ofstream(root() / ("extra" + std::to_string(i))) << "x";
  VerifyOptions options = without_frames();
  std::vector<double> reported;
  options.progress = [&](double done, const std::string&) { reported.push_back(done); };
  const VerifyReport report = verify(options);
  EXPECT_THAT(report.problems, IsEmpty());
  EXPECT_EQ(report.files, 141);
  EXPECT_THAT(reported, ElementsAre(::testing::DoubleEq(0.5 * 64 / 141), ::testing::DoubleEq(0.5 * 128 / 141)));
  int queries = 0;
  options.canceled = [&] { return ++queries > 10; };
  EXPECT_EQ(verify(options).files, 10);
}

}  // namespace
}  // namespace swiftlet::sim
