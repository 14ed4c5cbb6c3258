// Problems: what a verification found, the first hundred in words.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace roseau::recorder {

class Problems {
 public:
  void add(std::string text) {
    constexpr std::size_t kMostKept = 100;
    if (texts_.size() < kMostKept) texts_.push_back(std::move(text));
    ++count_;
  }
  std::uint64_t count() const { return count_; }
  std::vector<std::string> take() { return std::move(texts_); }

 private:
  std::vector<std::string> texts_;
  std::uint64_t count_ = 0;
};

}  // namespace roseau::recorder
