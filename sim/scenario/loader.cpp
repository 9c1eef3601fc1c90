// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/scenario/loader.hpp"

#include <algorithm>

#include "swiftlet/sim/scenario/suggest.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

// [-] Longest chain of `base:` files.
constexpr std::size_t kMaxChain = 16;

bool ends_with_yaml(const std::string& name) { return name.ends_with(".yaml") || name.ends_with(".yml"); }

fs::path normal(const fs::path& path) { return path.lexically_normal(); }

/// Absolute name of a file, to detect cycles and to make resolved configurations relocatable.
fs::path absolute_path(const fs::path& path) {
  std::error_code error;
  const fs::path result = fs::absolute(path, error);
  return normal(error ? path : result);
}

/// Adds the configurations of a folder, in the form of `name`: with or without extension.
void add_known(std::vector<std::string>& known, const std::vector<std::string>& listing, const std::string& name) {
  for (const std::string& file : listing) {
    if (ends_with_yaml(file)) known.push_back(ends_with_yaml(name) ? file : fs::path(file).stem().string());
  }
}

bool is_path_like(const std::string& text) {
  return !text.empty() && text.size() < 1024 && text.find('\0') == std::string::npos;
}

void expect_map(const Node& document) {
  if (!document.is_map()) fail(document.place, "", "expected a map of keys, found " + describe(document));
}

}  // namespace

Node Loader::load(const fs::path& name) {
  const fs::path file = find_main(name);
  // Messages quote file contents, so files that are no configurations are not read: a batch may name any file.
  if (!ends_with_yaml(file.string()))
    throw InputError(file.string() + ": expected a configuration file named .yaml or .yml, found another name");
  return with_base(parse_document(read(file), {file.string(), file.parent_path()}), {file});
}

fs::path Loader::find_main(const fs::path& file) const {
  if (files_.is_file(file)) return file;
  std::vector<std::string> known;
  add_known(known, files_.list(file.has_parent_path() ? file.parent_path() : fs::path(".")), file.string());
  for (const fs::path& root : files_.scenario_roots()) {
    for (const char* extension : {"", ".yaml"}) {
      const fs::path candidate = root / (file.string() + extension);
      if (files_.is_file(candidate)) return candidate;
    }
    add_known(known, files_.list(root), file.string());
  }
  throw InputError(file.string() + ": expected a configuration file, found none" +
                   did_you_mean(file.filename().string(), known));
}

std::string Loader::read(const fs::path& file) const {
  try {
    return files_.read(file);
  } catch (const std::runtime_error& error) {
    throw InputError(error.what());
  }
}

Node Loader::load_text(const std::string& text, const fs::path& name) {
  return with_base(parse_document(text, {name.string(), name.parent_path()}), {name});
}

Node Loader::with_base(Node document, std::vector<fs::path> chain) {
  expect_map(document);
  const auto key = std::find_if(document.entries.begin(), document.entries.end(),
                                [](const Entry& entry) { return entry.key == "base"; });
  if (key == document.entries.end()) return document;
  const Node name = key->value;
  document.entries.erase(key);

  const fs::path file = find_base(name);
  const auto same = [&](const fs::path& other) { return absolute_path(other) == absolute_path(file); };
  if (std::any_of(chain.begin(), chain.end(), same) || chain.size() >= kMaxChain) {
    std::string names;
    for (const fs::path& link : chain) names += link.string() + " -> ";
    fail(name.place, "base", "expected a chain of files that ends, found " + names + file.string());
  }
  chain.push_back(file);
  Node base = with_base(parse_document(read(file), {file.string(), file.parent_path()}), std::move(chain));
  base.place = document.place;
  merge(base, document);
  return base;
}

fs::path Loader::find_base(const Node& base) const {
  if (!base.is_scalar() || !is_path_like(base.text)) {
    fail(base.place, "base", "expected the name of a file, found " + describe(base));
  }
  std::vector<fs::path> folders = {base.place.source->directory};
  const std::vector<fs::path> roots = files_.scenario_roots();
  folders.insert(folders.end(), roots.begin(), roots.end());
  std::vector<std::string> known;
  bool exists = false;
  for (const fs::path& folder : folders) {
    for (const char* extension : {"", ".yaml"}) {
      const fs::path file = normal(folder / (base.text + extension));
      const bool is_here = files_.is_file(file);
      if (is_here && ends_with_yaml(file.string())) return file;
      exists = exists || is_here;
    }
    add_known(known, files_.list(folder), base.text);
  }
  fail(base.place, "base",
       "expected the name of a file, found " + quote(base.text) +
           (exists ? ", which is not named .yaml or .yml" : ", which does not exist") + did_you_mean(base.text, known));
}

const Node& Loader::load_asset(const std::string& name, const std::string& folder, const Place& place,
                               const std::string& path) {
  const fs::path file = find_asset(name, folder, place, path);
  const auto known = assets_.find(file);
  if (known != assets_.end()) return known->second;
  return assets_.emplace(file, load(file)).first->second;
}

fs::path Loader::find_asset(const std::string& name, const std::string& folder, const Place& place,
                            const std::string& path) const {
  if (!is_path_like(name)) fail(place, path, "expected a name from assets/" + folder + ", found " + quote(name));
  if (ends_with_yaml(name)) return find_file(name, place, path);
  std::vector<std::string> known;
  for (const fs::path& root : files_.asset_roots()) {
    const fs::path file = normal(root / folder / (name + ".yaml"));
    if (files_.is_file(file)) return file;
    add_known(known, files_.list(root / folder), name);
  }
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  const std::string choices = known.empty() ? "" : " (" + one_of(known) + ")";
  fail(place, path,
       "expected a name from assets/" + folder + choices + ", found " + quote(name) + did_you_mean(name, known));
}

fs::path Loader::find_file(const std::string& name, const Place& place, const std::string& path) const {
  if (!is_path_like(name)) fail(place, path, "expected the name of a file, found " + quote(name));
  const fs::path beside = place.source ? place.source->directory / name : fs::path(name);
  if (files_.is_file(beside)) return absolute_path(beside);
  for (const fs::path& root : files_.asset_roots()) {
    if (files_.is_file(root / name)) return absolute_path(root / name);
  }
  fail(place, path, "expected an existing file, found " + quote(name) + ", which does not exist" + hint(beside));
}

std::string Loader::hint(const fs::path& missing) const {
  const fs::path folder = missing.parent_path();
  return did_you_mean(missing.filename().string(), files_.list(folder.empty() ? fs::path(".") : folder));
}

}  // namespace swiftlet::sim
