// SPDX-License-Identifier: BSD-3-Clause
// The state hash covers every field of a vehicle's true state, its observations and its actions.
#include "sim/run/state_hash.hpp"

#include <gtest/gtest.h>

#include <set>

#include "sim/run/hasher_internal.hpp"
#include "swiftlet/sim/metrics/detection_score.hpp"
#include "swiftlet/sim/metrics/relative_score.hpp"
#include "swiftlet/sim/recording/recorder.hpp"
#include "tests/support/field_coverage.hpp"

namespace swiftlet::sim {
namespace {

/// The visitor that changes the n-th value of a kind of data a little.
class Nudge {
 public:
  explicit Nudge(int n) : n_(n) {}
  bool was_there() const { return n_ < 0; }

  void time(const char*, TimeNs& t, const char*) { number(t); }
  void valid(const char*, bool& value, const char*) { number(value); }
  void vehicle(const char*, VehicleId& id, const char*) { number(id); }
  void choice(const char*, auto& value, std::span<const char* const>, const char*) {
    if (n_-- == 0) value = static_cast<std::remove_reference_t<decltype(value)>>(1 - static_cast<int>(value));
  }
  void covariance(const char*, auto& matrix, const char*) { numbers(matrix.data(), matrix.size()); }
  void array(const char*, auto& values, const char*) { numbers(values.data(), values.size()); }
  template <class T>
  void list(const char*, std::vector<T>& values, const char*) {
    if (n_-- == 0) values.emplace_back();
    for (T& value : values) T::visit(value, *this);
  }
  template <class T>
  void field(const char*, T& value, const char*) {
    if constexpr (std::is_arithmetic_v<T>) {
      number(value);
    } else if constexpr (std::is_same_v<T, Pose>) {
      for (int i = 0; i < 4; ++i) numbers(value.data() + 4 * i, 3);  // column by column, without the constant row
    } else if constexpr (requires { value.coeffs(); }) {
      numbers(value.coeffs().data(), 4);
    } else if constexpr (requires { value.colwise(); }) {
      numbers(value.data(), value.size());
    } else {
      if (n_-- == 0) value.push_back({});
    }
  }

 private:
  void number(auto& value) {
    if (n_-- == 0) value = static_cast<std::remove_reference_t<decltype(value)>>(value == 0 ? 1 : 0);
  }
  void numbers(auto* values, std::ptrdiff_t size) {
    for (std::ptrdiff_t i = 0; i < size; ++i) number(values[i]);
  }

  int n_;
};

/// Number of values of a kind of data that change the hash of its holder, and number of all values.
template <class Kind, class HashOfHolder>
std::pair<int, int> values_that_count(const HashOfHolder& hash_of_holder) {
  const std::uint64_t before = hash_of_holder(Kind{});
  std::pair<int, int> counts;
  for (int n = 0;; ++n) {
    Kind changed{};
    Nudge nudge(n);
    Kind::visit(changed, nudge);
    if (!nudge.was_there()) return counts;
    counts.first += hash_of_holder(changed) != before;
    ++counts.second;
  }
}

TEST(StateHash, EveryValueOfEverySampleCounts) {
  Observation observation;
  Observation::each_samples(observation, [&]<class Sample>(std::vector<Sample>& samples) {
    const auto [counting, all] = values_that_count<Sample>([&](const Sample& sample) {
      samples = {sample};
      return hash_of(observation);
    });
    samples.clear();
    EXPECT_GT(all, 2) << Sample::kName;
    EXPECT_EQ(counting, all) << Sample::kName;
  });
}

TEST(StateHash, CoversEveryScanAndMessageValue) {
  const auto [of_scan, in_scan] = values_that_count<Scan>([](const Scan& scan) {
    Observation observation;
    observation.scans.push_back(std::make_shared<const Scan>(scan));
    return hash_of(observation);
  });
  EXPECT_EQ(of_scan, in_scan);
  const auto [of_message, in_message] = values_that_count<Message>([](const Message& message) {
    Observation observation;
    observation.messages.push_back(message);
    return hash_of(observation);
  });
  EXPECT_EQ(of_message, in_message);
}

TEST(StateHash, CoversEveryTrueStateValue) {
  const auto [counting, all] =
      values_that_count<VehicleState>([](const VehicleState& state) { return hash_of(state); });
  EXPECT_EQ(counting, all);
  EXPECT_EQ(all, 1 + 3 + 4 + 3 + 3 + 2 * kMaxRotors + 1);
}

TEST(StateHash, EveryValueOfAnActionCounts) {
  const auto [of_action, in_action] = values_that_count<Action>([](const Action& action) { return hash_of(action); });
  EXPECT_EQ(of_action, in_action);
  EXPECT_TRUE(forgets<Action>(sizeof(Action::overlays)));
  const auto of_list = [](auto member) {
    return [member](const auto& value) {
      Action action;
      (action.*member).push_back(value);
      return hash_of(action);
    };
  };
  const auto [of_detection, in_detection] = values_that_count<Detection>(of_list(&Action::detections));
  EXPECT_EQ(of_detection, in_detection);
  const auto [of_track, in_track] = values_that_count<Track>(of_list(&Action::tracks));
  EXPECT_EQ(of_track, in_track);
  const auto [of_message, in_message] = values_that_count<Message>(of_list(&Action::messages));
  EXPECT_EQ(of_message, in_message);
}

TEST(StateHash, ThePlaceOfAValueCounts) {
  Observation altimeter, compass;
  altimeter.altimeter.emplace_back();
  compass.compass.emplace_back();
  EXPECT_NE(hash_of(altimeter), hash_of(compass)) << "equal numbers from different sensors";
  Observation one, two;
  one.messages.resize(1);
  two.messages.resize(1);
  one.messages[0].topic = "ab";
  two.messages[0].topic = "a";
  two.messages[0].payload = {std::byte{'b'}};
  EXPECT_NE(hash_of(one), hash_of(two)) << "equal bytes, divided differently";
}

TEST(StateHash, SimulatorTypesNameAllTheirFields) {
  EXPECT_TRUE(forgets<VehicleState>(0));
  EXPECT_TRUE(forgets<Event>(0));
  EXPECT_TRUE(forgets<DetectionScore>(0));
  EXPECT_TRUE(forgets<RelativeScore>(0));
}

struct TwoFields {
  double height_m = 1.0, sigma_m = 2.0;
  static void visit(auto& s, auto& v) {
    v.field("height_m", s.height_m, "[m] height");
    v.field("sigma_m", s.sigma_m, "[m] standard deviation");
  }
};

struct ThreeFields : TwoFields {
  double bias_m = 0.0;
  static void visit(auto& s, auto& v) {
    TwoFields::visit(s, v);
    v.field("bias_m", s.bias_m, "[m] bias");
  }
};

template <class Kind>
std::uint64_t hash_of_kind(const Kind& value) {
  Hasher hasher;
  Kind::visit(value, hasher);
  return hasher.digest();
}

TEST(StateHash, ChangesWithAnAddedField) { EXPECT_NE(hash_of_kind(TwoFields{}), hash_of_kind(ThreeFields{})); }

TEST(StateHash, IsIndependentOfPieceSize) {
  // Data larger than the hasher's buffer are streamed: the value must not depend on the cuts.
  for (const std::size_t size : {100U, 511U, 512U, 513U, 5000U}) {
    Hasher whole, pieces;
    const std::vector<double> values(size, 0.1);
    whole.field("", values, "");
    pieces.field("", size, "");
    for (const double value : values) pieces.field("", value, "");
    EXPECT_EQ(whole.digest(), pieces.digest()) << size;
  }
}

}  // namespace
}  // namespace swiftlet::sim
