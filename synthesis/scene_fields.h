// SceneFields: walks over everything a scene can say. Each section names its keys once (scene_description.cpp), with what
// values make sense; reading a file, checking a scene made in code and listing all keys are three walks over the same
// description.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/geometry.h"

namespace roseau::synthesis {

struct Scene;

class SceneFields {
 public:
  virtual ~SceneFields() = default;

  /// A finite number from `low` to `high`.
  virtual void number(std::string_view key, double& value, double low, double high) = 0;
  virtual void whole(std::string_view key, std::int64_t& value, std::int64_t low, std::int64_t high) = 0;
  virtual void flag(std::string_view key, bool& value) = 0;
  virtual void text(std::string_view key, std::string& value) = 0;
  /// One of some words.
  virtual void word(std::string_view key, std::string& value, std::span<const std::string_view> allowed) = 0;
  virtual void point(std::string_view key, Vec3& value) = 0;
  virtual void numbers(std::string_view key, std::vector<double>& values) = 0;

  /// What no single value's range can say.
  virtual void require(bool holds, std::string_view key, const std::string& what) = 0;

  virtual void section(std::string_view name, const std::function<void(SceneFields&)>& describe) = 0;

  template <class Integer>
    requires std::is_integral_v<Integer>
  void whole(std::string_view key, Integer& value, std::int64_t low, std::int64_t high) {
    auto wide = static_cast<std::int64_t>(value);
    whole(key, wide, low, high);
    value = static_cast<Integer>(wide);
  }

  /// [[name]], `least` to `most` times. A file that has any replaces the list; entries keep the defaults at their place.
  template <class T>
  void list(std::string_view name, std::vector<T>& items, std::size_t least, std::size_t most,
            const std::function<void(SceneFields&, T&)>& describe) {
    items.resize(list_size(name, items.size(), least, most));
    for (std::size_t i = 0; i < items.size(); ++i) {
      item(name, i, [&](SceneFields& fields) { describe(fields, items[i]); });
    }
  }

 protected:
  /// How many entries the list gets.
  virtual std::size_t list_size(std::string_view name, std::size_t present, std::size_t least, std::size_t most) = 0;
  virtual void item(std::string_view name, std::size_t index, const std::function<void(SceneFields&)>& describe) = 0;
};

/// Shows every key of the scene to `fields`, section by section.
void describe(Scene& scene, SceneFields& fields);

}  // namespace roseau::synthesis
