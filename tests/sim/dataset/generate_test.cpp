// SPDX-License-Identifier: BSD-3-Clause
// A dataset of half a second: what lies in its directory, and that verification notices what was changed in it.
#include "swiftlet/sim/dataset/generate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sim/dataset/data_card.hpp"
#include "swiftlet/sim/dataset/verify.hpp"
#include "swiftlet/sim/errors.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::vector<std::vector<double>> rows_of(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line.substr(line.find(':') == std::string::npos ? 0 : line.find(':') + 1));
    std::vector<double> numbers;
    for (double number = 0.0; words >> number;) numbers.push_back(number);
    rows.push_back(numbers);
  }
  return rows;
}

/// Two UAVs above a plane, one with a LiDAR of 8 x 32 beams; two flights, of one split each. Named so that it runs
/// before the others: flights are made by forked processes, and a process with threads cannot be forked.
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

TEST_F(SmallDatasetDeathTest, HasASequenceForEachFlightWithItsSplitAndSeed) {
  EXPECT_EQ(report_.flights_done, 2);
  ASSERT_EQ(report_.sequences.size(), 2U);
  const auto manifest = nlohmann::json::parse(text_of(out / "manifest.json"));
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

// As KITTI has them: the upper three rows of a matrix. There is no camera, so that nothing lies between the two frames.
TEST_F(SmallDatasetDeathTest, PosesAndCalibrationAreWholeMatrices) {
  const fs::path sequence = out / "sequences/00";
  const std::vector<double> identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const auto calibration = rows_of(sequence / "calib.txt");
  ASSERT_EQ(calibration.size(), 6U);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(calibration[i], identity);
  const auto poses = rows_of(sequence / "poses.txt"), times = rows_of(sequence / "times.txt");
  ASSERT_EQ(poses.size(), times.size());
  ASSERT_GE(poses.size(), 3U);
  for (const auto& row : poses) {
    ASSERT_EQ(row.size(), 12U);
    Matrix3 rotation;
    for (int i = 0; i < 9; ++i) rotation(i / 3, i % 3) = row[static_cast<std::size_t>(i / 3 * 4 + i % 3)];
    EXPECT_TRUE((rotation * rotation.transpose()).isIdentity(1e-9));
    EXPECT_GT(row[11], 0.5);  // above the ground
    EXPECT_LT(row[11], 8.0);
  }
  // Told by ground truth: the same places.
  const auto told = rows_of(sequence / "told.tum");
  ASSERT_EQ(told.size(), poses.size());
  for (std::size_t k = 1; k < told.size(); ++k) {
    ASSERT_EQ(told[k].size(), 8U);
    EXPECT_NEAR(told[k][0], times[k][0], 1e-9);
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(told[k][1 + axis], poses[k][3 + 4 * axis], 0.02);
  }
}

TEST_F(SmallDatasetDeathTest, CountsOfItsStatisticsAreThoseOfItsFiles) {
  SequenceStatistics both;
  std::int64_t boxes = 0, points = 0;
  for (const SequenceInfo& info : report_.sequences) {
    both.add(info.statistics);
    const fs::path sequence = out / "sequences" / sequence_name(info.sequence);
    const std::string table = text_of(sequence / "boxes.csv");
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

TEST_F(SmallDatasetDeathTest, IsVerifiedAndItsFramesComeOutTheSameAgain) {
  const VerifyReport report = verify(2);
  EXPECT_THAT(report.problems, IsEmpty());
  EXPECT_EQ(report.resimulated, 2);
  EXPECT_EQ(report.frames, report_.sequences[0].statistics.frames + report_.sequences[1].statistics.frames);
}

TEST_F(SmallDatasetDeathTest, VerificationTellsWhichFileIsNotWhatItWas) {
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
  EXPECT_THAT(found, Contains(HasSubstr("sequences/01/foreign.txt: the manifest does not name it")));
  for (const std::string& problem : found) EXPECT_THAT(problem, ::testing::Not(HasSubstr("sequences/01/velodyne")));
}

TEST_F(SmallDatasetDeathTest, AManifestThatIsNoneIsRefused) {
  const auto whole = nlohmann::json::parse(text_of(out / "manifest.json"));
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

TEST_F(SmallDatasetDeathTest, ADirectoryWithSomethingElseIsLeftAsItIs) {
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
