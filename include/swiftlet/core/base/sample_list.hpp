// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "swiftlet/core/base/field_bytes.hpp"
#include "swiftlet/core/base/fields.hpp"
#include "swiftlet/core/base/finite.hpp"

namespace swiftlet {

/// Samples of one type behind a type-erased interface, for recorders, the state hash and checks.
class SampleList {
 public:
  virtual ~SampleList() = default;
  virtual std::unique_ptr<SampleList> copy() const = 0;
  virtual const char* name() const = 0;
  virtual std::vector<Column> columns() const = 0;
  virtual std::size_t size() const = 0;
  virtual void clear() = 0;
  virtual TimeNs time_of(std::size_t i) const = 0;
  virtual bool finite(std::size_t i) const = 0;
  virtual void put(std::size_t i, ColumnSink& sink) const = 0;
  /// Appends every field of every sample.
  virtual void append_bytes(std::vector<std::byte>& bytes) const = 0;
};

/// `Sample` is a kind of data with a `kName` and a time `t`.
template <class Sample>
class SampleListOf final : public SampleList {
 public:
  std::vector<Sample> samples;

  std::unique_ptr<SampleList> copy() const override { return std::make_unique<SampleListOf>(*this); }
  const char* name() const override { return Sample::kName; }
  std::vector<Column> columns() const override { return columns_of<Sample>(); }
  std::size_t size() const override { return samples.size(); }
  void clear() override { samples.clear(); }
  TimeNs time_of(std::size_t i) const override { return samples[i].t; }
  bool finite(std::size_t i) const override { return is_finite(samples[i]); }
  void put(std::size_t i, ColumnSink& sink) const override { put_columns(samples[i], sink); }
  void append_bytes(std::vector<std::byte>& bytes) const override {
    struct Bytes : FieldBytes<Bytes> {
      explicit Bytes(std::vector<std::byte>& out) : all(out) {}
      void bytes(const void* data, std::size_t size) {
        const auto* first = static_cast<const std::byte*>(data);
        all.insert(all.end(), first, first + size);
      }
      std::vector<std::byte>& all;
    };
    Bytes(bytes).list("", samples, "");
  }
};

/// Lists of any sample types, each created on first use.
class SampleLists {
 public:
  SampleLists() = default;
  SampleLists(SampleLists&&) = default;
  SampleLists& operator=(SampleLists&&) = default;
  SampleLists(const SampleLists& other) {
    lists_.reserve(other.lists_.size());
    for (const auto& list : other.lists_) lists_.push_back(list->copy());
  }
  SampleLists& operator=(const SampleLists& other) { return *this = SampleLists(other); }
  ~SampleLists() = default;

  template <class Sample>
  std::vector<Sample>& of() {
    if (auto* found = find<Sample>()) return found->samples;
    lists_.push_back(std::make_unique<SampleListOf<Sample>>());
    return find<Sample>()->samples;
  }
  template <class Sample>
  const std::vector<Sample>& of() const {
    static const std::vector<Sample> kNone;
    const auto* found = find<Sample>();
    return found == nullptr ? kNone : found->samples;
  }

  auto begin() const { return lists_.begin(); }
  auto end() const { return lists_.end(); }
  void clear() {
    for (const auto& list : lists_) list->clear();
  }

 private:
  template <class Sample>
  SampleListOf<Sample>* find() const {
    for (const auto& list : lists_) {
      if (auto* found = dynamic_cast<SampleListOf<Sample>*>(list.get())) return found;
    }
    return nullptr;
  }

  std::vector<std::unique_ptr<SampleList>> lists_;
};

}  // namespace swiftlet
