// SPDX-License-Identifier: BSD-3-Clause
// A dataset of half a second: contents of its directory, and detection of changes by verification.
#include "swiftlet/sim/dataset/generate.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/dataset/data_card.hpp"
#include "sim/dataset/hash.hpp"
#include "swiftlet/sim/dataset/verify.hpp"
#include "swiftlet/sim/errors/errors.hpp"
#include "tests/sim/dataset/read_files.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Two UAVs above a plane, one with a LiDAR of 8 x 32 beams; two flights of one split each. The name makes it run
/// before the others: flights run in forked processes, and a process with threads cannot fork.
class SmallDatasetDeathTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    made_ = new TemporaryDirectory();
    std::ofstream(made_->path() / "team.yaml") << R"(name: pair
duration_s: 0.5
tick_s: 0.01
world: {type: empty, ground: true}
vehicles:
  - name: uav1
    model: f330
    sensors:
      - {type: lidar, name: grid, rate_hz: 10, range_max_m: 60, pattern: {type: uniform, rows: 8, columns: 32}}
    agent: {type: stack, localization: ground_truth}
  - {name: uav2, model: f330, agent: {type: stack, localization: ground_truth}}
)";
    std::ofstream(made_->path() / "pair.yaml") << R"(name: pair
splits: [{name: train, flights: 1, first_seed: 5}, {name: valid, flights: 1, first_seed: 9}]
families: [{name: plane, scenario: team.yaml, flight: {height_max_m: 6, partner_max_m: 12}}]
content: {point_truth: true, images: false}
pictures: {flights_per_split: 0}
)";
    GenerateOptions options;
    options.directory = made_->path() / "out";
    report_ = generate_dataset(plan(), options);
  }
  static void TearDownTestSuite() {
    delete made_;
    made_ = nullptr;
  }

  static DatasetPlan plan() { return plan_dataset(load_dataset(made_->path() / "pair.yaml")); }

  void SetUp() override { fs::copy(made_->path() / "out", out, fs::copy_options::recursive); }

  VerifyReport verify(int frames) const {
    VerifyOptions options;
    options.frames = frames;
    return verify_dataset(out, options);
  }
  std::vector<std::string> problems() const { return verify(0).problems; }
  void append(const std::string& name, const std::string& text) const {
    std::ofstream(out / name, std::ios::app | std::ios::binary) << text;
  }

  static inline TemporaryDirectory* made_ = nullptr;
  static inline GenerateReport report_;
  TemporaryDirectory copies;
  fs::path out = copies.path() / "out";
};

TEST_F(SmallDatasetDeathTest, HasASequenceForEachFlight) {
  EXPECT_EQ(report_.flights_done, 2);
  ASSERT_EQ(report_.sequences.size(), 2U);
  const auto manifest = nlohmann::json::parse(read_whole_file(out / "manifest.json"));
  EXPECT_TRUE(manifest["complete"].get<bool>());
  for (int i = 0; i < 2; ++i) {
    const auto& sequence = manifest["sequences"][static_cast<std::size_t>(i)];
    EXPECT_EQ(sequence["sequence"], i == 0 ? "00" : "01");
    EXPECT_EQ(sequence["split"], i == 0 ? "train" : "valid");
    EXPECT_EQ(sequence["seed"], i == 0 ? 5 : 9);
    EXPECT_EQ(sequence["frames"], report_.sequences[static_cast<std::size_t>(i)].statistics.frames);
  }
  for (const auto& file : manifest["files"]) {
    EXPECT_EQ(fs::file_size(out / file["path"].get<std::string>()), file["bytes"].get<std::uint64_t>());
  }
}

// Tests that generate run before tests that verify: the latter simulate here, which starts threads.
TEST_F(SmallDatasetDeathTest, RegeneratesMissingFlightsIdentically) {
  const auto manifest = nlohmann::json::parse(read_whole_file(out / "manifest.json"));
  fs::remove_all(out / "sequences/01");
  fs::create_directories(out / "sequences/.01.partial");
  fs::create_directories(out / "sequences/.kept");
  std::vector<int> reported;
  GenerateOptions options;
  options.directory = out;
  options.resume = true;
  options.progress = [&](int done, int all, const std::string&) {
    EXPECT_EQ(all, 2);
    reported.push_back(done);
  };
  const GenerateReport report = generate_dataset(plan(), options);
  EXPECT_EQ(report.flights_done, 2);
  EXPECT_EQ(report.flights_all, 2);
  EXPECT_FALSE(report.canceled);
  EXPECT_GE(reported.front(), 1);
  EXPECT_EQ(reported.back(), 2);
  EXPECT_GT(report.wall_s, 0.0);
  EXPECT_FALSE(fs::exists(out / "sequences/.01.partial")) << "what a killed worker left";
  EXPECT_TRUE(fs::exists(out / "sequences/.kept"));
  EXPECT_FALSE(fs::exists(out / ".lock"));
  fs::remove_all(out / "sequences/.kept");
  // The manifest lists the same bytes of the same files.
  const auto again = nlohmann::json::parse(read_whole_file(out / "manifest.json"));
  EXPECT_EQ(again.at("sequences"), manifest.at("sequences"));
  EXPECT_EQ(again.at("files"), manifest.at("files"));
}

TEST_F(SmallDatasetDeathTest, ResumesAfterBeingKilled) {
  const fs::path begun = copies.path() / "begun";
  fs::create_directories(begun / "sequences");  // all of it at the earliest kill
  GenerateOptions options;
  options.directory = begun;
  EXPECT_THROW(generate_dataset(plan(), options), InputError) << "an existing directory without the option to resume";
  options.resume = true;
  std::ofstream(begun / "mine.txt") << "";
  EXPECT_THROW(generate_dataset(plan(), options), InputError) << "a file of the user";
  fs::remove(begun / "mine.txt");
  fs::create_directories(begun / "sequences/00");
  EXPECT_THROW(generate_dataset(plan(), options), InputError) << "a sequence of unknown origin";
  fs::remove_all(begun / "sequences");
  std::ofstream(begun / "dataset.yaml") << "mine";
  EXPECT_THROW(generate_dataset(plan(), options), InputError) << "a configuration of the user";
  EXPECT_EQ(read_whole_file(begun / "dataset.yaml"), "mine");
  fs::create_directories(begun / "sequences");
  options.canceled = [] { return true; };
  const GenerateReport report = generate_dataset(plan(), options);
  EXPECT_TRUE(report.canceled);
  EXPECT_EQ(report.flights_done, 0);
  const auto manifest = nlohmann::json::parse(read_whole_file(begun / "manifest.json"));
  EXPECT_FALSE(manifest.at("complete").get<bool>());
  EXPECT_TRUE(fs::exists(begun / "dataset.yaml"));
  EXPECT_TRUE(fs::exists(begun / "scenarios/plane.yaml"));
}

TEST_F(SmallDatasetDeathTest, RefusesAnotherConfigurationOrLockedDirectory) {
  GenerateOptions options;
  options.directory = out;
  options.resume = true;
  const DatasetPlan other = plan_dataset(load_dataset(made_->path() / "pair.yaml", {{"splits[1].first_seed", "10"}}));
  EXPECT_THAT([&] { generate_dataset(other, options); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("expected a dataset of the same configuration")));
  const int lock = ::open((out / ".lock").c_str(), O_RDWR | O_CREAT, 0666);
  ASSERT_EQ(::flock(lock, LOCK_EX), 0);
  EXPECT_THAT([&] { generate_dataset(plan(), options); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("found one in use")));
  ::close(lock);
  std::ofstream(copies.path() / "file") << "";
  options.directory = copies.path() / "file/below";
  EXPECT_THROW(generate_dataset(plan(), options), InputError);
}

TEST_F(SmallDatasetDeathTest, RefusesToWriteThroughLinkedFolders) {
  const fs::path outside = copies.path() / "outside";
  fs::create_directories(outside);
  GenerateOptions options;
  options.resume = true;
  for (const char* folder : {"sequences", "charts"}) {
    options.directory = copies.path() / folder;
    fs::copy(out, options.directory, fs::copy_options::recursive);
    fs::remove_all(options.directory / folder);
    fs::create_directory_symlink(outside, options.directory / folder);
    EXPECT_THAT([&] { generate_dataset(plan(), options); },
                ::testing::ThrowsMessage<InputError>(HasSubstr("found a link")))
        << folder;
    EXPECT_TRUE(fs::is_empty(outside)) << folder;
  }
}

TEST_F(SmallDatasetDeathTest, ReportsFailedFlightsWithTheirAttempts) {
  const DatasetPlan narrow = plan_dataset(
      load_dataset(made_->path() / "pair.yaml", {{"families[0].flight.border_m", "1e6"}, {"max_attempts", "3"}}));
  GenerateOptions options;
  options.directory = copies.path() / "narrow";
  EXPECT_THAT([&] { generate_dataset(narrow, options); },
              ::testing::ThrowsMessage<std::runtime_error>(::testing::AllOf(
                  HasSubstr("flight 0 failed: flight 0 (seed 5): 3 attempts failed, the last because no free paths"),
                  HasSubstr("(0 of 2 flights are finished and kept; continue with --resume)"))));
}

TEST_F(SmallDatasetDeathTest, DescribesTheFlightsOfItsSequences) {
  for (const SequenceInfo& info : report_.sequences) {
    EXPECT_EQ(info.vehicle, "uav1");
    EXPECT_EQ(info.instance, 1);
    EXPECT_EQ(info.sensor, "grid");
    EXPECT_EQ(info.vehicles, (std::vector<std::string>{"uav1", "uav2"}));
    EXPECT_EQ(info.models, (std::vector<std::string>{"f330", "f330"}));
    EXPECT_EQ(info.family, "plane");
    EXPECT_EQ(info.flight, info.sequence);
    EXPECT_EQ(info.attempt, 0);
    EXPECT_EQ(info.fingerprint, plan().fingerprint);
    EXPECT_EQ(info.state_hash.size(), 16U);
    EXPECT_EQ(info.statistics.rows, 8);
    EXPECT_EQ(info.statistics.columns, 32);
    EXPECT_NEAR(info.statistics.duration_s, 0.5, 1e-9);
  }
}

TEST_F(SmallDatasetDeathTest, StatisticsMatchItsFiles) {
  SequenceStatistics both;
  std::int64_t boxes = 0, points = 0;
  for (const SequenceInfo& info : report_.sequences) {
    both.add(info.statistics);
    const fs::path sequence = out / "sequences" / sequence_name(info.sequence);
    const std::string table = read_whole_file(sequence / "boxes.csv");
    boxes += std::count(table.begin(), table.end(), '\n') - 1;
    for (const auto& scan : fs::directory_iterator(sequence / "velodyne"))
      points += static_cast<std::int64_t>(fs::file_size(scan) / 16);
  }
  EXPECT_EQ(both.points, points);
  std::int64_t by_class = 0, by_range = 0, vehicles = 0;
  for (const auto& [label, count] : both.points_by_class) by_class += count;
  for (const std::int64_t count : both.points_by_range) by_range += count;
  for (const auto& bin : both.vehicles_by_range) {
    vehicles += bin.boxes;
    EXPECT_LE(bin.in_view, bin.boxes);
    EXPECT_LE(bin.detected, bin.boxes);
    EXPECT_LE(bin.well_detected, bin.detected);
  }
  EXPECT_EQ(by_class, points);
  EXPECT_EQ(by_range, points);
  EXPECT_EQ(vehicles, boxes);
}

TEST_F(SmallDatasetDeathTest, ReproducesFramesAndReportsDifferingOnes) {
  VerifyOptions options;
  options.frames = 1000;
  std::vector<double> reported;
  options.progress = [&](double done, const std::string& note) {
    if (note.ends_with("again")) reported.push_back(done);
  };
  const VerifyReport whole = verify_dataset(out, options);
  EXPECT_THAT(whole.problems, IsEmpty());
  EXPECT_EQ(whole.resimulated, whole.frames) << "no more than there are";
  EXPECT_THAT(reported, ::testing::ElementsAre(0.5, 0.75));
  // Changed byte in one frame, together with its hash in the manifest.
  const std::string name = "sequences/01/velodyne/000001.bin";
  std::string bytes = read_whole_file(out / name);
  bytes[3] = static_cast<char>(bytes[3] ^ 1);
  std::ofstream(out / name, std::ios::binary) << bytes;
  auto manifest = nlohmann::json::parse(read_whole_file(out / "manifest.json"));
  for (auto& file : manifest["files"]) {
    if (file["path"] == name) file["xxh128"] = hex(hash_of(bytes));
  }
  std::ofstream(out / "manifest.json") << manifest;
  const VerifyReport changed = verify_dataset(out, options);
  EXPECT_THAT(changed.problems, ::testing::ElementsAre(name + ": differs when simulated again"));
  EXPECT_EQ(changed.resimulated, changed.frames);
  // The sample of frames depends on the seed alone: some seeds find the change, some do not, always the same ones.
  options.frames = 4;
  std::vector<bool> found;
  for (const std::uint64_t seed : {1U, 2U, 3U, 1U}) {
    options.seed = seed;
    const VerifyReport some = verify_dataset(out, options);
    EXPECT_EQ(some.resimulated, 4);
    found.push_back(!some.ok());
  }
  EXPECT_EQ(found.front(), found.back());
}

TEST_F(SmallDatasetDeathTest, VerificationNamesChangedFiles) {
  fs::remove(out / "sequences/00/labels/000000.label");
  append("sequences/00/times.txt", "1 2\n");
  append("sequences/00/poses.txt", "1 2 3\n");
  append("sequences/01/point_truth/000000.bin", "x");
  append("sequences/01/foreign.txt", "");
  const auto found = problems();
  EXPECT_THAT(found, Contains(HasSubstr("sequences/00/labels/000000.label: ")));
  EXPECT_THAT(found, Contains(HasSubstr("sequences/00/labels: expected")));
  EXPECT_THAT(found, Contains(HasSubstr("sequences/00/times.txt:")).Times(2));  // bytes, and how many numbers
  EXPECT_THAT(found, Contains(HasSubstr("sequences/00/poses.txt:")).Times(2));
  EXPECT_THAT(found, Contains(HasSubstr("expected 12 numbers")));
  EXPECT_THAT(found, Contains(HasSubstr("sequences/01/point_truth/000000.bin: expected")).Times(2));
  EXPECT_THAT(found, Contains(HasSubstr("sequences/01/foreign.txt: not listed in manifest.json")));
  for (const std::string& problem : found) EXPECT_THAT(problem, ::testing::Not(HasSubstr("sequences/01/velodyne")));
}

TEST_F(SmallDatasetDeathTest, RefusesAnInvalidManifest) {
  const auto whole = nlohmann::json::parse(read_whole_file(out / "manifest.json"));
  auto no_files = whole, no_sequences = whole, no_hash = whole, words = whole;
  no_files.erase("files");
  no_sequences["sequences"] = 3;
  no_hash["files"][0].erase("xxh128");
  words["files"][0] = "README.md";
  for (const auto& manifest : {no_files, no_sequences, no_hash, words, nlohmann::json(7)}) {
    std::ofstream(out / "manifest.json") << manifest;
    EXPECT_THROW(problems(), InputError) << manifest.dump().substr(0, 60);
  }
  fs::remove(out / "manifest.json");
  EXPECT_THROW(problems(), InputError);
}

TEST_F(SmallDatasetDeathTest, LeavesForeignDirectoriesUntouched) {
  GenerateOptions options;
  options.directory = copies.path() / "mine";
  fs::create_directories(options.directory);
  std::ofstream(options.directory / "diary.txt") << "dear";
  for (const bool resume : {false, true}) {
    options.resume = resume;
    EXPECT_THROW(generate_dataset(plan(), options), InputError);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(options.directory), fs::directory_iterator()), 1);
  options.directory = out;
  options.resume = false;
  EXPECT_THROW(generate_dataset(plan(), options), InputError);
  options.resume = true;  // all of it is there
  EXPECT_EQ(generate_dataset(plan(), options).flights_done, 2);
  EXPECT_THAT(problems(), IsEmpty());
}

}  // namespace
}  // namespace swiftlet::sim
