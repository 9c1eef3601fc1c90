// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/yaml_writer.hpp"

#include <algorithm>
#include <string_view>

#include "swiftlet/sim/scenario/units.hpp"

namespace swiftlet::sim {
namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// True for a word that every YAML reader interprets as text without quotes.
bool is_plain(std::string_view text) {
  static constexpr std::string_view kReserved[] = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"};
  if (text.empty() || !(is_letter(text[0]) || text[0] == '/')) return false;
  const auto plain = [](char c) { return is_letter(c) || is_digit(c) || c == '.' || c == '-' || c == '/'; };
  if (!std::all_of(text.begin(), text.end(), plain)) return false;
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::find(std::begin(kReserved), std::end(kReserved), lower) == std::end(kReserved);
}

std::string to_text(const std::string& text) {
  if (is_plain(text)) return text;
  constexpr char kHex[] = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (byte < 0x20 || byte == 0x7F) {
      quoted += std::string("\\x") + kHex[byte >> 4] + kHex[byte & 15];
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string to_text(double value) { return yaml_number(value); }

template <class Values>
std::string flow(const Values& values) {
  std::string text = "[";
  for (const auto& value : values) text += (text.size() > 1 ? ", " : "") + to_text(value);
  return text + "]";
}

class YamlWriter final : public ConfigVisitor {
 public:
  std::string take() { return std::move(text_); }

  void field(const char* key, bool& value, const char*) override { line(key, value ? "true" : "false"); }
  void field(const char* key, int& value, const char*, Range) override { line(key, std::to_string(value)); }
  void field(const char* key, std::uint64_t& value, const char*) override { line(key, std::to_string(value)); }
  void field(const char* key, double& value, const char*, Range) override { line(key, to_text(value)); }
  void field(const char* key, std::string& value, const char*) override { line(key, to_text(value)); }
  void field(const char* key, Eigen::Vector2d& value, const char*, Range) override { line(key, flow(value)); }
  void field(const char* key, Eigen::Vector3d& value, const char*, Range) override { line(key, flow(value)); }
  void field(const char* key, std::vector<double>& value, const char*, Range) override { line(key, flow(value)); }
  void field(const char* key, std::vector<std::string>& value, const char*) override { line(key, flow(value)); }
  void field(const char* key, std::vector<Eigen::Vector3d>& value, const char*, Range) override {
    std::string text = "[";
    for (const Eigen::Vector3d& vector : value) text += (text.size() > 1 ? ", " : "") + flow(vector);
    line(key, text + "]");
  }
  void choice(const char* key, std::string& value, std::span<const char* const>, const char*) override {
    line(key, to_text(value));
  }
  void file(const char* key, std::string& path, const char*) override { line(key, to_text(path)); }
  void model(const char* key, std::string& name, const char*, const char*) override { line(key, to_text(name)); }

  void changes(const char* key, ConfigChanges& value, const char*) override {
    begin_object(key, "");
    for (const auto& [path, text] : value) line(to_text(path), text);
    end_object();
  }

  void module(const char* key, Module& value, std::span<const ModuleType>, const char*) override {
    if (!value.config) return;
    begin_object(key, "");
    visit_module(value);
    end_object();
  }
  void modules(const char* key, std::vector<Module>& values, std::span<const ModuleType>, const char*) override {
    std::size_t size = values.size();
    begin_list(key, size, "");
    for (std::size_t i = 0; i < size; ++i) {
      begin_element(i);
      visit_module(values[i]);
      end_element();
    }
    end_list();
  }

  void check(bool, const char*, const std::string&) override {}

 protected:
  bool begin_object(const char* key, const char*) override {
    line(key, "");
    begin_block("  ");
    return true;
  }
  void end_object() override { end_block(" {}\n"); }

  bool begin_list(const char* key, std::size_t& size, const char*) override {
    line(key, size == 0 ? "[]" : "");
    begin_block("  ");
    return true;
  }
  void end_list() override { end_block(" []\n"); }

  void begin_element(std::size_t) override {
    begin_block("  ");
    dash_ = true;
  }
  void end_element() override {
    if (dash_) text_ += indent_.substr(2) + "- {}\n";
    dash_ = false;
    blocks_.pop_back();
    indent_.resize(indent_.size() - 2);
  }

 private:
  void visit_module(Module& value) {
    line("type", to_text(value.type));
    if (value.config) value.config->visit(*this);
  }

  /// Writes "key: value" at the current depth; the first one of a list element carries the dash.
  void line(std::string_view key, const std::string& value) {
    text_ += dash_ ? indent_.substr(2) + "- " : indent_;
    dash_ = false;
    text_ += std::string(key) + (value.empty() ? ":\n" : ": " + value + "\n");
  }

  void begin_block(const char* indent) {
    indent_ += indent;
    blocks_.push_back(text_.size());
  }
  /// Ends a block; an empty one becomes the empty map or list.
  void end_block(const char* when_empty) {
    indent_.resize(indent_.size() - 2);
    const bool is_empty = text_.size() == blocks_.back();
    blocks_.pop_back();
    if (!is_empty || text_.ends_with("[]\n")) return;
    text_.pop_back();
    text_ += when_empty;
  }

  std::string text_;
  std::string indent_;
  bool dash_ = false;
  std::vector<std::size_t> blocks_;  ///< start offsets of the open blocks
};

}  // namespace

std::string write_config(const ConfigVisit& visit) {
  YamlWriter writer;
  visit(writer);
  return writer.take();
}

}  // namespace swiftlet::sim
