// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/radio/radio.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "swiftlet/core/base/ensure.hpp"
#include "swiftlet/core/math/random.hpp"

namespace swiftlet::sim {

void RadioConfig::visit(ConfigVisitor& v) {
  v.field("rate_kbps", rate_kbps,
          "[kbit/s] transmission rate of each sender; a message occupies the sender for size / rate",
          Range::positive());
  v.field("delay_s", delay_s, "[s] fixed part of the delay from the end of a transmission to its reception",
          Range::non_negative());
  v.field("jitter_s", jitter_s,
          "[s] standard deviation of a normal random number whose absolute value is added to the delay",
          Range::non_negative());
  v.field("loss_probability", loss_probability, "[-] probability that a receiver loses a message",
          Range::probability());
  v.field("range_m", range_m, "[m] largest distance of reception", Range::positive());
  v.field("line_of_sight", line_of_sight, "[-] whether surfaces of the static world block reception");
  v.field("queue_limit_kB", queue_limit_kB,
          "[kB] capacity of the transmission queue of a sender; when full, the oldest messages are dropped",
          Range::positive());
}

namespace {

/// A stored message and the number of vehicles that have yet to receive it. The slot is reused afterwards.
struct Slot {
  Message message;
  std::uint32_t sequence = 0;  ///< sequence number among its sender's messages
  int pending = 0;
};

/// Transmitter of one vehicle, with its queue.
struct Sender {
  std::vector<int> waiting;  ///< indices of the slots of queued messages, oldest first
  std::size_t waiting_bytes = 0;
  TimeNs free_at = 0;  ///< end of the last transmission, from which on the next one may start
  std::uint32_t num_messages = 0;
};

/// Future reception of a stored message by one vehicle.
struct Arrival {
  TimeNs t = 0;
  VehicleId from = kNoVehicle;
  std::uint32_t sequence = 0;
  int slot = 0;
};

/// Order for std::push_heap, which keeps the greatest element on top: here, the earliest arrival.
bool later(const Arrival& a, const Arrival& b) {
  return std::tie(a.t, a.from, a.sequence) > std::tie(b.t, b.from, b.sequence);
}

}  // namespace

struct Radio::Impl {
  Impl(const RadioConfig& config_in, std::uint64_t seed, std::vector<std::string> names,
       std::shared_ptr<const StaticScene> world_in)
      : config(config_in),
        num_vehicles(static_cast<int>(names.size())),
        world(std::move(world_in)),
        senders(num_vehicles),
        inboxes(num_vehicles),
        positions(num_vehicles, Vector3::Zero()) {
    // One random stream per link, so that another vehicle does not change this link.
    for (const std::string& from : names) {
      for (const std::string& to : names) {
        loss.emplace_back(seed, "radio.loss", from + ">" + to);
        jitter.emplace_back(seed, "radio.jitter", from + ">" + to);
      }
    }
  }

  /// Duration of a transmission, at least 1 ns, so that transmissions of a sender never coincide.
  TimeNs air_time(const Message& message) const {
    const double bits = 8.0 * static_cast<double>(message.size_bytes());
    return std::max<TimeNs>(1, from_seconds(bits / (1e3 * config.rate_kbps)));
  }

  int store(const Message& message);
  void enqueue(VehicleId from, TimeNs now, const Message& message);
  void transmit_all_until(TimeNs now);
  void transmit_until(VehicleId from, TimeNs now);
  void transmit(VehicleId from, int slot, TimeNs end);
  void receive(VehicleId to, int slot, TimeNs end);
  void release(int slot);
  void count_topic(const Message& message);
  Message take_buffer();

  RadioConfig config;
  int num_vehicles;
  std::shared_ptr<const StaticScene> world;
  std::vector<Random> loss, jitter;  ///< indexed by link: from * num_vehicles + to
  std::vector<Slot> slots;
  std::vector<int> free_slots;
  std::vector<Sender> senders;
  std::vector<std::vector<Arrival>> inboxes;  ///< heaps, earliest first
  std::vector<Message> buffers;               ///< messages from recycle(), whose memory is reused
  std::vector<Vector3> positions;             ///< vehicle positions in the last tick with a posted message
  TimeNs transmitted_until = -1;              ///< all transmissions due until then have started; -1: none
  TimeNs positions_at = -1;                   ///< time of `positions`; -1: not set
  RadioStatistics statistics;
  double delay_sum_s = 0.0;
  std::vector<RadioTopicStatistics> topics;
};

int Radio::Impl::store(const Message& message) {
  if (free_slots.empty()) {
    free_slots.push_back(static_cast<int>(slots.size()));
    slots.emplace_back();
  }
  const int slot = free_slots.back();
  free_slots.pop_back();
  slots[slot].message = message;  // reuses the capacity of the slot's payload
  return slot;
}

void Radio::Impl::enqueue(VehicleId from, TimeNs now, const Message& message) {
  if (message.to != kNoVehicle && (message.to < 0 || message.to >= num_vehicles)) {
    throw std::invalid_argument("message '" + message.topic + "' to unknown vehicle " + std::to_string(message.to));
  }
  const int slot = store(message);
  Sender& sender = senders[from];
  slots[slot].message.from = from;
  slots[slot].message.sent = now;
  slots[slot].sequence = sender.num_messages++;
  sender.waiting.push_back(slot);
  sender.waiting_bytes += message.size_bytes();

  transmit_until(from, now);
  while (static_cast<double>(sender.waiting_bytes) > 1e3 * config.queue_limit_kB) {
    const int oldest = sender.waiting.front();
    sender.waiting.erase(sender.waiting.begin());
    sender.waiting_bytes -= slots[oldest].message.size_bytes();
    release(oldest);
    ++statistics.dropped;
  }
}

void Radio::Impl::transmit_all_until(TimeNs now) {
  if (now == transmitted_until) return;
  transmitted_until = now;
  for (VehicleId from = 0; from < num_vehicles; ++from) transmit_until(from, now);
}

/// Starts every transmission of this sender that is due at or before `now`.
void Radio::Impl::transmit_until(VehicleId from, TimeNs now) {
  Sender& sender = senders[from];
  while (!sender.waiting.empty()) {
    const int slot = sender.waiting.front();
    const TimeNs start = std::max(sender.free_at, slots[slot].message.sent);
    if (start > now) return;
    sender.waiting.erase(sender.waiting.begin());
    sender.waiting_bytes -= slots[slot].message.size_bytes();
    sender.free_at = start + air_time(slots[slot].message);
    transmit(from, slot, sender.free_at);
  }
}

void Radio::Impl::transmit(VehicleId from, int slot, TimeNs end) {
  const VehicleId to = slots[slot].message.to;
  ++statistics.sent;
  statistics.bytes_sent += slots[slot].message.size_bytes();
  count_topic(slots[slot].message);
  if (to != kNoVehicle) {
    if (to != from) receive(to, slot, end);
  } else {
    for (VehicleId i = 0; i < num_vehicles; ++i) {
      if (i != from) receive(i, slot, end);
    }
  }
  if (slots[slot].pending == 0) release(slot);
}

/// Decides whether the message reaches `to`, and its time of arrival.
void Radio::Impl::receive(VehicleId to, int slot, TimeNs end) {
  const VehicleId from = slots[slot].message.from;
  const std::uint32_t sequence = slots[slot].sequence;
  const std::size_t link = static_cast<std::size_t>(from) * num_vehicles + to;
  if ((positions[to] - positions[from]).norm() > config.range_m) {
    ++statistics.out_of_range;
  } else if (config.line_of_sight && world && world->occluded(positions[from], positions[to])) {
    ++statistics.blocked;
  } else if (loss[link].uniform(sequence, 0) < config.loss_probability) {
    ++statistics.lost;
  } else {
    const double delay_s = config.delay_s + config.jitter_s * std::abs(jitter[link].normal(sequence, 0));
    inboxes[to].push_back({end + from_seconds(delay_s), from, sequence, slot});
    std::push_heap(inboxes[to].begin(), inboxes[to].end(), later);
    ++slots[slot].pending;
  }
}

void Radio::Impl::release(int slot) { free_slots.push_back(slot); }

void Radio::Impl::count_topic(const Message& message) {
  auto row = std::find_if(topics.begin(), topics.end(), [&](const RadioTopicStatistics& known) {
    return known.from == message.from && known.topic == message.topic;
  });
  if (row == topics.end()) row = topics.insert(topics.end(), {message.topic, message.from, 0, 0});
  ++row->messages;
  row->bytes += message.size_bytes();
}

Message Radio::Impl::take_buffer() {
  if (buffers.empty()) return {};
  Message buffer = std::move(buffers.back());
  buffers.pop_back();
  return buffer;
}

Radio::Radio(const RadioConfig& config, std::uint64_t seed, std::vector<std::string> vehicle_names,
             std::shared_ptr<const StaticScene> world)
    : impl_(std::make_unique<Impl>(config, seed, std::move(vehicle_names), std::move(world))) {}

Radio::~Radio() = default;

void Radio::post(VehicleId from, TimeNs now, std::span<const Message> messages, std::span<const VehicleState> states) {
  impl_->transmit_all_until(now);  // transmissions that start before this tick use the earlier positions
  if (now != impl_->positions_at) {
    impl_->positions_at = now;
    for (int i = 0; i < impl_->num_vehicles; ++i) impl_->positions[i] = states[i].p_world_m;
  }
  ENSURE(from >= 0 && from < impl_->num_vehicles && states.size() == static_cast<std::size_t>(impl_->num_vehicles),
         from, states.size(), impl_->num_vehicles);
  for (const Message& message : messages) impl_->enqueue(from, now, message);
}

void Radio::deliver(VehicleId to, TimeNs now, std::vector<Message>& out) {
  impl_->transmit_all_until(now);
  std::vector<Arrival>& inbox = impl_->inboxes[to];
  while (!inbox.empty() && inbox.front().t <= now) {
    std::pop_heap(inbox.begin(), inbox.end(), later);
    const Arrival arrival = inbox.back();
    inbox.pop_back();
    Slot& slot = impl_->slots[arrival.slot];
    out.push_back(impl_->take_buffer());
    out.back() = slot.message;
    out.back().received = arrival.t;
    if (--slot.pending == 0) impl_->release(arrival.slot);

    RadioStatistics& statistics = impl_->statistics;
    const double delay_s = to_seconds(arrival.t - slot.message.sent);
    ++statistics.delivered;
    impl_->delay_sum_s += delay_s;
    statistics.mean_delay_s = impl_->delay_sum_s / static_cast<double>(statistics.delivered);
    statistics.max_delay_s = std::max(statistics.max_delay_s, delay_s);
  }
}

void Radio::recycle(std::vector<Message>& messages) {
  for (Message& message : messages) impl_->buffers.push_back(std::move(message));
  messages.clear();
}

const RadioStatistics& Radio::statistics() const { return impl_->statistics; }

std::vector<RadioTopicStatistics> Radio::topics() const {
  std::vector<RadioTopicStatistics> sorted = impl_->topics;
  std::sort(sorted.begin(), sorted.end(), [](const RadioTopicStatistics& a, const RadioTopicStatistics& b) {
    return std::tie(a.from, a.topic) < std::tie(b.from, b.topic);
  });
  return sorted;
}

}  // namespace swiftlet::sim
