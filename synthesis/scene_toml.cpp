#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/toml/table.h"
#include "synthesis/scene.h"
#include "synthesis/scene_fields.h"

namespace roseau::synthesis {

namespace {

// Reads one table; what makes no sense is reported at its line.
class TableReader final : public SceneFields {
 public:
  explicit TableReader(TomlTable& table) : table_(table) {}

  void number(std::string_view key, double& value, double low, double high) override {
    value = table_.number(key, value);
    require(value >= low && value <= high, key, fmt::format("must be between {} and {}, not {}", low, high, value));
  }
  void whole(std::string_view key, std::int64_t& value, std::int64_t low, std::int64_t high) override {
    const std::int64_t given = table_.integer(key, value);
    require(given >= low && given <= high, key, fmt::format("must be between {} and {}, not {}", low, high, given));
    value = std::clamp(given, low, high);
  }
  void flag(std::string_view key, bool& value) override { value = table_.boolean(key, value); }
  void text(std::string_view key, std::string& value) override { value = table_.text(key, value); }
  void word(std::string_view key, std::string& value, std::span<const std::string_view> allowed) override {
    value = table_.text(key, value);
    require(std::ranges::find(allowed, value) != allowed.end(), key,
            fmt::format("must be one of {}, not {}", fmt::join(allowed, ", "), value));
  }
  void point(std::string_view key, Vec3& value) override {
    const std::vector<double> numbers = table_.numbers(key, 3);
    if (numbers.size() == 3) value = {numbers[0], numbers[1], numbers[2]};
    require(std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z), key, "must be three numbers");
  }
  void numbers(std::string_view key, std::vector<double>& values) override {
    if (table_.has(key)) {
      values = table_.numbers(key);
    } else {
      table_.numbers(key);  // tells the table that the key is known
    }
  }
  void require(bool holds, std::string_view key, const std::string& what) override {
    if (!holds) table_.complain(key, what);
  }
  void section(std::string_view name, const std::function<void(SceneFields&)>& describe) override {
    TomlTable table = table_.table(name);
    TableReader reader(table);
    describe(reader);
  }

 protected:
  std::size_t list_size(std::string_view name, std::size_t present, std::size_t least, std::size_t most) override {
    items_ = table_.tables(name);
    if (items_.empty()) return present;
    require(items_.size() >= least && items_.size() <= most, name, fmt::format("must be given {} to {} times", least, most));
    return std::min(items_.size(), most);
  }
  void item(std::string_view, std::size_t index, const std::function<void(SceneFields&)>& describe) override {
    if (index >= items_.size()) return;  // the defaults stand
    TableReader reader(items_[index]);
    describe(reader);
  }

 private:
  TomlTable& table_;
  std::vector<TomlTable> items_;  // of the list that is being read
};

// Looks at a scene as it is; keeps the first thing that makes no sense.
class Checker final : public SceneFields {
 public:
  explicit Checker(std::optional<Error>& first, std::string place = {}) : first_(first), place_(std::move(place)) {}

  void number(std::string_view key, double& value, double low, double high) override {
    require(value >= low && value <= high, key, fmt::format("must be between {} and {}, not {}", low, high, value));
  }
  void whole(std::string_view key, std::int64_t& value, std::int64_t low, std::int64_t high) override {
    require(value >= low && value <= high, key, fmt::format("must be between {} and {}, not {}", low, high, value));
  }
  void flag(std::string_view, bool&) override {}
  void text(std::string_view, std::string&) override {}
  void word(std::string_view key, std::string& value, std::span<const std::string_view> allowed) override {
    require(std::ranges::find(allowed, value) != allowed.end(), key,
            fmt::format("must be one of {}, not {}", fmt::join(allowed, ", "), value));
  }
  void point(std::string_view key, Vec3& value) override {
    require(std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z), key, "must be three numbers");
  }
  void numbers(std::string_view key, std::vector<double>& values) override {
    require(std::ranges::all_of(values, [](double value) { return std::isfinite(value); }), key, "must be numbers");
  }
  void require(bool holds, std::string_view key, const std::string& what) override {
    if (holds || first_) return;
    first_ = Error{ErrorCode::invalid_argument, fmt::format("scene: {}{} {}", place_, key, what)};
  }
  void section(std::string_view name, const std::function<void(SceneFields&)>& describe) override {
    Checker inside(first_, fmt::format("{}{}: ", place_, name));
    describe(inside);
  }

 protected:
  std::size_t list_size(std::string_view name, std::size_t present, std::size_t least, std::size_t most) override {
    require(present >= least && present <= most, name, fmt::format("must be given {} to {} times", least, most));
    return present;
  }
  void item(std::string_view name, std::size_t index, const std::function<void(SceneFields&)>& describe) override {
    section(fmt::format("{} {}", name, index), describe);
  }

 private:
  std::optional<Error>& first_;
  std::string place_;  // "camera 1: "
};

}  // namespace

Result<Scene> scene_from_toml(std::string_view text, const std::string& source_name) {
  auto root = TomlTable::parse(text, source_name);
  if (!root) return root.error();
  Scene scene;
  TableReader reader(*root);
  describe(scene, reader);
  if (auto finished = root->finish(); !finished) return finished.error();
  return scene;
}

Result<void> check(const Scene& scene) {
  std::optional<Error> first;
  Checker checker(first);
  Scene copy = scene;  // a walk may write; the checker does not
  describe(copy, checker);
  if (first) return *first;
  return {};
}

}  // namespace roseau::synthesis
